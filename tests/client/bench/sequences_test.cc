#include "client/bench/sequences.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "client/bench/suites.h"
#include "tests/support/status_matchers.h"

namespace halfshade::bench {
namespace {

void AddPass(const char* name, double ms, const char* skipped_since, v1::RenderReport* report) {
  v1::Pass* pass = report->add_passes();
  pass->set_name(name);
  pass->set_ms(ms);
  pass->set_skipped(skipped_since != nullptr);
  if (skipped_since != nullptr) pass->set_reason(skipped_since);
}

TEST(CountSkipsTest, SaysHowOftenEachReasonHeldAndWhatThePassTakesWhereItIsDrawn) {
  std::vector<v1::RenderReport> reports(4);
  for (const double ms : {2.0, 6.0}) AddPass("gbuffer", ms, nullptr, &reports[ms > 2 ? 1 : 0]);
  AddPass("gbuffer", 0, "nothing is in view", &reports[2]);
  AddPass("gbuffer", 0, "the same view was drawn before", &reports[3]);
  for (v1::RenderReport& report : reports) AddPass("shade", 0, "no FRAME is asked", &report);
  const std::vector<Skip> skips = CountSkips(reports);
  ASSERT_EQ(skips.size(), 3u);
  EXPECT_EQ(skips[0].reason, "nothing is in view");
  EXPECT_DOUBLE_EQ(skips[0].share, 0.25);
  EXPECT_DOUBLE_EQ(skips[0].saved_ms.value(), 4);
  EXPECT_EQ(skips[1].reason, "the same view was drawn before");
  EXPECT_DOUBLE_EQ(skips[2].share, 1);
  EXPECT_FALSE(skips[2].saved_ms.has_value()) << "shading was never drawn";
}

TEST(CountSkipsTest, ReasonsThatDifferByAFigureAreOne) {
  std::vector<v1::RenderReport> reports(2);
  AddPass("gbuffer", 0, "256 triangles out of view", &reports[0]);
  AddPass("gbuffer", 0, "1024 triangles out of view", &reports[1]);
  const std::vector<Skip> skips = CountSkips(reports);
  ASSERT_EQ(skips.size(), 1u);
  EXPECT_EQ(skips[0].reason, "N triangles out of view");
  EXPECT_DOUBLE_EQ(skips[0].share, 1);
}

TEST(LitTilesTest, IsTheMeanOverTheReportsThatTellIt) {
  std::vector<v1::RenderReport> reports(3);
  EXPECT_FALSE(LitTiles(reports));
  AddPass("resolve", 1, nullptr, &reports[0]);
  reports[0].mutable_passes(0)->set_reason("3 tiles lit: nothing in their shafts; polygons of blocks in 1 others");
  AddPass("resolve", 1, nullptr, &reports[2]);
  reports[2].mutable_passes(0)->set_reason("1 tiles lit: nothing in their shafts; polygons of blocks in 3 others");
  EXPECT_DOUBLE_EQ(LitTiles(reports).value(), 0.5);
}

Case MakeLookAt() {
  Case result;
  v1::LookAt* camera = result.request.mutable_camera()->mutable_look_at();
  camera->mutable_eye()->set_x(3);
  camera->mutable_eye()->set_y(2);
  v1::AreaLight* light = result.request.add_lights();
  light->mutable_edge_u()->set_z(2);
  return result;
}

TEST(SequencesTest, AnOrbitIsACircleInEqualSteps) {
  const SequencePlan plan = OrbitCamera(MakeLookAt(), 60);
  ASSERT_EQ(plan.frames.size(), 60u);
  for (size_t i = 0; i < plan.frames.size(); ++i) {
    const v1::Vec3& eye = plan.frames[i].camera().look_at().eye();
    EXPECT_NEAR(std::hypot(eye.x(), eye.z()), 3, 1e-9);
    EXPECT_DOUBLE_EQ(eye.y(), 2);
    const v1::Vec3& before = plan.frames[i == 0 ? 59 : i - 1].camera().look_at().eye();
    EXPECT_NEAR(std::hypot(eye.x() - before.x(), eye.z() - before.z()), 6 * std::sin(3 * M_PI / 180), 1e-9);
  }
  EXPECT_THAT(plan.judged, testing::ElementsAre(0, 20, 40));
}

TEST(SequencesTest, ADraggedLightMovesAlongItsEdgeAndTheCameraStays) {
  const SequencePlan plan = DragLight(MakeLookAt(), 60);
  EXPECT_DOUBLE_EQ(plan.frames[0].lights(0).center().z(), -3);
  EXPECT_DOUBLE_EQ(plan.frames[30].lights(0).center().z(), 0);
  for (const v1::RenderRequest& frame : plan.frames) {
    EXPECT_EQ(frame.camera().SerializeAsString(), plan.frames[0].camera().SerializeAsString());
  }
}

TEST(AutoSuiteTest, EveryBudgetStandsBesideEachRivalAndFramesInARow) {
  const auto suite = MakeSuite("auto", {"multi_map", "pcss", "ray", "shaft"}, "");
  ASSERT_OK(suite);
  std::map<std::string, int> families;
  for (const Setting& setting : suite->settings) ++families[setting.family];
  EXPECT_THAT(families, testing::UnorderedElementsAre(
                            testing::Pair("auto", 4), testing::Pair("ray", 4), testing::Pair("ray filtered", 2),
                            testing::Pair("ray adaptive", 3), testing::Pair("ray adaptive by budget", 4),
                            testing::Pair("multi_map", 3), testing::Pair("pcss", 2), testing::Pair("shaft", 5)));
  EXPECT_EQ(suite->judged, "auto");
  EXPECT_EQ(suite->sequences.size(), 3 * suite->replies.size());
  EXPECT_EQ(MakeSuite("huge", {}, "").status().message(),
            "--suite: 'huge'; there are auto, quick, full, pdsm, shaft, ssm and sssm");
}

}  // namespace
}  // namespace halfshade::bench
