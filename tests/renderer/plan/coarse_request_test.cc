#include "renderer/plan/coarse_request.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "renderer/plan/choose_method.h"
#include "tests/support/flat_scene_builder.h"
#include "tests/support/status_matchers.h"

namespace halfshade {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

class CoarseRequestTest : public testing::Test {
 protected:
  CoarseRequestTest() {
    request_.lights.resize(1);
    request_.outputs = {OutputKind::kVisibility};
    request_.is_auto = true;
  }
  void Settle() { ASSERT_OK(SettleMethod(scene_, pose_, ReceiverCount(request_), &request_)); }
  std::vector<RenderRequest> Plan() { return PlanCoarseRequests(scene_, pose_, request_); }

  const FlatScene scene_ = MakeFlatScene({MakeBox({0, 0, 0}, {1, 1, 1})});
  const Pose pose_ = *BuildPose(scene_, 0);
  RenderRequest request_;
};

TEST_F(CoarseRequestTest, AQuarterThenAHalfOfTheSizeAtCoarserErrorsAndWithoutBudgetOrCertificate) {
  request_.budget.max_error = 0.002;
  request_.certify = CertifyOptions{};
  request_.samples = 4;
  Settle();
  const std::vector<RenderRequest> coarse = Plan();
  ASSERT_EQ(coarse.size(), 2u);
  EXPECT_EQ(coarse[0].width, 320);
  EXPECT_EQ(coarse[0].height, 180);
  EXPECT_EQ(coarse[1].width, 640);
  EXPECT_EQ(coarse[1].height, 360);
  EXPECT_FLOAT_EQ(std::get<ShaftOptions>(coarse[0].method).max_error, 0.024f);
  EXPECT_FLOAT_EQ(std::get<ShaftOptions>(coarse[1].method).max_error, 0.008f);
  EXPECT_LT(*coarse[0].predicted_cpu_ms, 0.1 * *request_.predicted_cpu_ms) << "the first image in a tenth of the time";
  for (const RenderRequest& one : coarse) {
    EXPECT_EQ(one.samples, 1);
    EXPECT_FALSE(one.certify);
    EXPECT_FALSE(one.budget.max_error);
    EXPECT_THAT(one.method_reason, StartsWith("coarse, a "));
    EXPECT_GT(*one.predicted_error, 0.0);
  }
}

// Shaft's shape of it is much of the whole's time.
TEST(CoarseRequestOfADenseMeshTest, TheFirstIsByRaysWhoseHierarchyIsThereSooner) {
  const FlatScene scene = MakeFlatScene({MakeSphere({0, 1, 0}, 1, 300)});
  const Pose pose = *BuildPose(scene, 0);
  RenderRequest request;
  request.lights.resize(1);
  request.lights[0].center_ws = {0, 5, 0};
  request.lights[0].axis_v_ws = {0, 0, -1};
  request.lights[0].normal_ws = {0, -1, 0};
  request.outputs = {OutputKind::kVisibility};
  request.is_auto = true;
  request.budget.max_error = 0.002;
  ASSERT_OK(SettleMethod(scene, pose, ReceiverCount(request), &request));
  const std::vector<RenderRequest> coarse = PlanCoarseRequests(scene, pose, request);
  ASSERT_EQ(coarse.size(), 2u);
  EXPECT_TRUE(std::holds_alternative<RayOptions>(coarse[0].method)) << coarse[0].method_reason;
  EXPECT_FALSE(coarse[0].certify);
  EXPECT_TRUE(std::holds_alternative<ShaftOptions>(coarse[1].method)) << "whose shape the whole needs as well";
  EXPECT_LT(*coarse[0].predicted_cpu_ms, 0.2 * *request.predicted_cpu_ms);
}

TEST_F(CoarseRequestTest, APictureThatIsAsSoonThereHasNone) {
  request_.width = request_.height = 64;
  Settle();
  EXPECT_TRUE(Plan().empty()) << "what a picture takes whatever its size is over half of this one";
  request_.width = request_.height = 1024;
  Settle();
  EXPECT_EQ(Plan().size(), 2u);
}

TEST_F(CoarseRequestTest, ADearMethodIsPrecededByWhatAutoWouldTake) {
  request_.is_auto = false;
  request_.method = MultiMapOptions{.k = 1024};
  Settle();
  const std::vector<RenderRequest> coarse = Plan();
  ASSERT_EQ(coarse.size(), 2u);
  EXPECT_TRUE(std::holds_alternative<ShaftOptions>(coarse[0].method));
}

TEST_F(CoarseRequestTest, WidthsOfPenumbraeComeFromTheMethodThatKnowsThem) {
  request_.outputs = {OutputKind::kPenumbraWidth};
  Settle();
  const std::vector<RenderRequest> coarse = Plan();
  ASSERT_FALSE(coarse.empty());
  EXPECT_TRUE(std::holds_alternative<SssmOptions>(coarse[0].method));
}

TEST_F(CoarseRequestTest, OfALatencyTheyTakeWhatTheWholeLeaves) {
  Settle();
  const MethodFacts facts = FactsForMethod(scene_, pose_, request_, ReceiverCount(request_));
  const double whole_ms = PredictWallMs(facts, *request_.predicted_cpu_ms, 1);
  request_.budget.max_latency_ms = 1.5 * whole_ms;
  EXPECT_EQ(Plan().size(), 2u);
  request_.budget.max_latency_ms = 1.1 * whole_ms;
  EXPECT_EQ(Plan().size(), 1u);
  request_.budget.max_latency_ms = 1.001 * whole_ms;
  EXPECT_TRUE(Plan().empty());
}

TEST_F(CoarseRequestTest, OnePixelOfEachSideIsLeft) {
  request_.is_auto = false;
  request_.method = RayOptions{.rays = 65536};
  request_.width = 3;
  request_.height = 4096;
  request_.light_map_size = 16;
  Settle();
  const std::vector<RenderRequest> coarse = Plan();
  ASSERT_EQ(coarse.size(), 2u);
  EXPECT_EQ(coarse[0].width, 1);
  EXPECT_EQ(coarse[0].height, 1024);
  EXPECT_EQ(coarse[0].light_map_size, 16);
}

}  // namespace
}  // namespace halfshade
