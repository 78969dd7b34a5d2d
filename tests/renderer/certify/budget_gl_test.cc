// Budgets against what pictures turn out to be: drawn again where the method was chosen, refused where it was not.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

#include "tests/support/flat_scene_builder.h"
#include "tests/support/render_fixture.h"
#include "tests/support/scene_makers.h"

namespace halfshade {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class DrawnBudgetTest : public testing::Test {
 protected:
  DrawnBudgetTest() {
    const MadeScene made = MakeScene("S5", {.light_share = 0.2});
    scene_ = MakeFlatScene(made.meshes);
    request_ = RequestFor(made);
    request_.width = 160;
    request_.height = 90;
    request_.outputs = {OutputKind::kVisibility};
  }
  absl::StatusOr<RenderResult> Render() {
    auto result = TestRenderer().Render("test", scene_, request_, [] { return absl::OkStatus(); });
    TestRenderer().ForgetScene("test");
    return result;
  }
  FlatScene scene_;
  RenderRequest request_;
};

TEST_F(DrawnBudgetTest, AMethodThatWasAskedForIsRefusedWithTheErrorThatItHas) {
  request_.method = RayOptions{.rays = 16};
  request_.budget.max_error = 0.1;
  EXPECT_OK(Render());
  request_.budget.max_error = 0.005;
  EXPECT_THAT(Render(),
              StatusIs(absl::StatusCode::kFailedPrecondition, HasSubstr("budget.max_error: 0.005; the error is 0.0")));
  request_.method = PcssOptions{};
  request_.certify = CertifyOptions{1024, 256};
  request_.budget.max_error = 0.001;
  EXPECT_THAT(Render(), StatusIs(absl::StatusCode::kFailedPrecondition, HasSubstr(" as measured, by pcss")));
}

TEST_F(DrawnBudgetTest, AMethodThatWasChosenIsDrawnAgainUntilItsErrorIsMet) {
  request_.is_auto = true;
  request_.method_reason = "chosen";
  request_.method = RayOptions{.rays = 16};
  request_.budget.max_error = 0.01;
  auto result = Render();
  ASSERT_OK(result);
  EXPECT_THAT(result->report.reason, HasSubstr("chosen; ray drawn again at half the error: 0.01; the error is 0.0"));
  EXPECT_LE(result->report.error.predicted.value(), 0.01);
  const Image image = std::move(result->images[0].image);
  // The same bytes as if it had been asked for.
  request_.is_auto = false;
  request_.budget = {};
  request_.method = RayOptions{.rays = std::stoi(result->report.options[0].second)};
  result = Render();
  ASSERT_OK(result);
  EXPECT_TRUE(std::equal(image.data(), image.data() + image.size(), result->images[0].image.data()));
}

TEST_F(DrawnBudgetTest, ItIsDrawnAgainOnlyWhereThatIsToEndInTime) {
  request_.is_auto = true;
  request_.method = RayOptions{.rays = 16};
  request_.budget.max_error = 0.01;
  request_.budget.max_latency_ms = 600'000;
  const auto in_time = Render();
  ASSERT_OK(in_time);
  EXPECT_THAT(in_time->report.reason, HasSubstr("ray drawn again at half the error"));
  // A machine on which what is to come takes longer, however quick what was drawn was.
  request_.budget.machine.slowness = 1e6;
  EXPECT_THAT(Render(), StatusIs(absl::StatusCode::kFailedPrecondition,
                                 AllOf(HasSubstr("budget.max_error: 0.01; the error is 0.0"),
                                       HasSubstr(", by ray, and budget.max_latency leaves no time for better"))));
  // And one that has no time left, though what is to come is predicted to take none.
  request_.budget.machine.slowness = 0;
  request_.budget.max_latency_ms = 1e-3;
  EXPECT_THAT(Render(), StatusIs(absl::StatusCode::kFailedPrecondition, HasSubstr("leaves no time for better")));
  // What keeps its error needs no time for another.
  request_.budget.max_error = 0.1;
  EXPECT_OK(Render());
}

// Straight edges, where stratified rays are luckier than their estimate, may be told too large; nothing too small.
TEST_F(DrawnBudgetTest, RaysTellTheirErrorWithinAFactorOfTwoBesideCurvesAndLeavesAndNowhereTooSmall) {
  for (const char* name : {"S1", "S2", "S3", "S5", "S6"}) {
    const MadeScene made = MakeScene(name, {.triangles = std::string(name) == "S6" ? 20000u : 0u, .light_share = 0.2});
    scene_ = MakeFlatScene(made.meshes);
    request_ = RequestFor(made);
    request_.width = 160;
    request_.height = 90;
    request_.outputs = {OutputKind::kVisibility};
    request_.method = RayOptions{.rays = 4096};
    const auto truth = Render();
    ASSERT_OK(truth);
    for (const int rays : {16, 64, 256}) {
      request_.method = RayOptions{.rays = rays};
      request_.seed = 7;
      const auto result = Render();
      ASSERT_OK(result);
      double sum = 0;
      int count = 0;
      for (size_t i = 0; i < truth->images[0].image.size(); ++i) {
        const float v = truth->images[0].image.data()[i];
        if (v >= 1 - 1.0f / 512) continue;
        sum += std::abs(v - result->images[0].image.data()[i]);
        ++count;
      }
      const double error = sum / count, predicted = result->report.error.predicted.value();
      std::printf("%s, %d rays: error %.5f, predicted %.5f\n", name, rays, error, predicted);
      const bool is_straight = std::string(name) == "S1" || std::string(name) == "S3";
      EXPECT_LE(predicted, (is_straight ? 8 : 2) * error) << name << " " << rays;
      EXPECT_GE(predicted, error / 2) << name << " " << rays;
    }
  }
}

}  // namespace
}  // namespace halfshade
