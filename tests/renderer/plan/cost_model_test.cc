#include "renderer/plan/cost_model.h"

#include <gtest/gtest.h>

#include "renderer/light/kept_meshes.h"
#include "renderer/scene/pose.h"
#include "tests/support/flat_scene_builder.h"
#include "tests/support/render_fixture.h"
#include "tests/support/scene_makers.h"
#include "tests/support/status_matchers.h"

namespace halfshade {
namespace {

MethodFacts Facts(uint64_t triangles, uint64_t receivers = 640 * 360) {
  return {.casting_triangles = triangles, .receivers = receivers};
}

TEST(CostModelTest, WhatShaftKeepsCostsOnceWhateverTheLights) {
  MethodFacts copied = Facts(2'000'000);
  copied.lights = 10;
  MethodFacts kept = copied;
  kept.kept_share = 0.75;
  const PredictedCost of_copied = PredictCost(copied, ShaftOptions{}), of_placed = PredictCost(kept, ShaftOptions{});
  EXPECT_DOUBLE_EQ(of_placed.light_ms, of_copied.light_ms / 4);
  EXPECT_EQ(of_placed.receiver_ms, of_copied.receiver_ms);
  kept.kept_triangles = 1'500'000;  // at one place
  const PredictedCost of_kept = PredictCost(kept, ShaftOptions{});
  EXPECT_EQ(of_kept.light_ms, of_placed.light_ms);
  EXPECT_GT(of_kept.scene_ms, 0);
  EXPECT_LT(of_kept.TotalMs(), of_copied.TotalMs());
  EXPECT_LT(of_kept.FrameMs(1), of_kept.TotalMs());
  EXPECT_LT(of_kept.FrameMs(100), of_kept.FrameMs(1));
  kept.lights = 20;
  EXPECT_EQ(PredictCost(kept, ShaftOptions{}).scene_ms, of_kept.scene_ms);
  kept.lights = 10;
  EXPECT_EQ(PredictCost(kept, RayOptions{}).TotalMs(), PredictCost(copied, RayOptions{}).TotalMs());
}

TEST(CostModelTest, ASceneSaysWhatShaftKeeps) {
  FlatScene scene = MakeFlatScene({MakeSphere({0, 0, 0}, 0.1, 20), MakePlate({0, 0, 0}, 8, 8)});
  const Node node = scene.nodes[0];
  const uint64_t triangles = scene.meshes[0].TriangleCount();
  const uint64_t least = (kLeastTrianglesOfAll + triangles - 1) / triangles;
  const auto facts_at = [&](uint64_t places) {
    while (scene.nodes.size() < places + 1) {  // and the plate
      scene.scenes[0].roots.push_back(uint32_t(scene.nodes.size()));
      scene.nodes.push_back(node);
    }
    return FactsForMethod(scene, *BuildPose(scene, 0), RenderRequest(), 1000);
  };
  EXPECT_EQ(facts_at(least - 1).kept_share, 0);
  EXPECT_EQ(facts_at(least - 1).kept_triangles, 0u);
  EXPECT_DOUBLE_EQ(facts_at(least).kept_share, double(least * triangles) / double(least * triangles + 2));
  EXPECT_EQ(facts_at(least).kept_triangles, triangles);
}

// What `halfshade bench --suite quick` measured at 640 x 360: the geometric mean of its two scenes in README.md's
// table, of 5 k and 6 k triangles. A factor of three either way: what decides between methods is an order of magnitude.
TEST(CostModelTest, IsNearTheTableOfTheReadme) {
  struct Row {
    MethodOptions options;
    double shadow_ms;
  };
  PcssOptions pcss;
  SssmOptions sssm;
  sssm.blocker_taps = 11;
  sssm.filter_taps = 21;
  sssm.sub_lights = 2;
  const Row rows[] = {{HardOptions{1024}, 27},
                      {pcss, 65},
                      {sssm, 284},
                      {MultiMapOptions{16, 512}, 123},
                      {MultiMapOptions{64, 512}, 492},
                      {PdsmOptions{}, 500},
                      {SsmOptions{.occluder_map_size = 256, .sub_lights = 2}, 63},
                      {SsmOptions{}, 227},
                      {RayOptions{.rays = 16}, 73},
                      {RayOptions{.rays = 64}, 178},
                      {RayOptions{.rays = 256, .is_adaptive = true}, 210},
                      {ShaftOptions{.rows = 8}, 35},
                      {ShaftOptions{.rows = 64}, 58}};
  for (const Row& row : rows) {
    const double predicted_ms = PredictCost(Facts(5000), row.options).TotalMs();
    EXPECT_GT(predicted_ms, row.shadow_ms / 3) << row.options.index();
    EXPECT_LT(predicted_ms, row.shadow_ms * 3) << row.options.index();
  }
}

TEST(CostModelTest, GrowsWithWhatIsWorkAndOnlyWithThat) {
  const MethodOptions methods[] = {HardOptions{}, MultiMapOptions{}, RayOptions{},  PcssOptions{},
                                   SsmOptions{},  PdsmOptions{},     SssmOptions{}, ShaftOptions{}};
  for (const MethodOptions& options : methods) {
    const PredictedCost cost = PredictCost(Facts(5000), options);
    const PredictedCost denser = PredictCost(Facts(50'000), options),
                        larger = PredictCost(Facts(5000, 921'600), options);
    EXPECT_GT(denser.TotalMs(), cost.TotalMs()) << options.index();
    EXPECT_GT(larger.receiver_ms, 3 * cost.receiver_ms) << options.index();
    EXPECT_EQ(larger.light_ms, cost.light_ms) << "light data knows no camera";
    MethodFacts two_lights = Facts(5000);
    two_lights.lights = 2;
    EXPECT_GT(PredictCost(two_lights, options).TotalMs(), cost.TotalMs());
    EXPECT_LE(PredictCost(two_lights, options).TotalMs(), 2 * cost.TotalMs());
  }
}

TEST(CostModelTest, ErrorsFallWithWorkAndRowsAndRaysAreTheFewestThatMeetThem) {
  const MethodFacts plain = Facts(5000);
  MethodFacts masked = plain;
  masked.masked_share = 1;
  EXPECT_GT(RayError(masked, 64), RayError(plain, 64));
  MethodFacts blend = masked;
  blend.blend_share = 1;
  EXPECT_NEAR(ShaftError(blend, 32) - ShaftError(masked, 32), RayError(blend, 1024) - RayError(masked, 1024), 1e-12)
      << "as many samples, as much noise";
  EXPECT_GT(ShaftError(blend, 64), 0.313 / std::sqrt(64 * 32.0)) << "what no row takes away";
  EXPECT_GT(RaysFor(blend, 0.01), RaysFor(masked, 0.01));
  for (const double max_error : {0.03, 0.01, 0.003, 0.001}) {
    const int rays = RaysFor(plain, max_error), rows = ShaftRowsFor(plain, max_error);
    EXPECT_LE(RayError(plain, rays), max_error);
    EXPECT_TRUE(rays == 16 || RayError(plain, rays / 2) > max_error);
    EXPECT_LE(ShaftError(plain, rows), max_error);
    EXPECT_TRUE(rows == 4 || ShaftError(plain, rows / 2) > max_error);
  }
  EXPECT_EQ(RaysFor(plain, 1e-9), kMostRays);
  EXPECT_EQ(ShaftRowsFor(plain, 1e-9), 64);
  EXPECT_GT(ShaftError(masked, 64) / ShaftError(plain, 64), ShaftError(masked, 8) / ShaftError(plain, 8));
}

TEST(CostModelTest, InRoomsMapsAreFiveAndRaysAreRays) {
  MethodFacts room = Facts(5000);
  room.has_side_windows = true;
  EXPECT_GT(PredictCost(room, MultiMapOptions{}).TotalMs(), 4 * PredictCost(Facts(5000), MultiMapOptions{}).TotalMs());
  EXPECT_EQ(PredictCost(room, ShaftOptions{}).TotalMs(), PredictCost(Facts(5000), ShaftOptions{}).TotalMs());
  const FlatScene scene = MakeFlatScene({MakeBox({0, 0, 0}, {2, 2, 2})});
  const Pose pose = *BuildPose(scene, 0);
  RenderRequest request;
  for (const auto& [height, is_beside] : {std::pair{1.01, false}, {0.99, true}, {-1.01, false}}) {
    request.lights = {LightAbove(height, 1)};
    EXPECT_EQ(FactsForMethod(scene, pose, request, 1).has_side_windows, is_beside) << height;
  }
}

TEST(CostModelTest, WallTimeGoesWithTheMachine) {
  const MethodFacts facts = Facts(5000);
  EXPECT_DOUBLE_EQ(PredictWallMs(facts, 100, 3), 3 * PredictWallMs(facts, 100, 1));
}

// Leaves share no vertex: rays disagree over more of the picture, and the more the finer the error; lists are longer.
TEST(CostModelTest, ClutterIsDearestForRaysAtFineErrors) {
  MethodFacts smooth = Facts(6000), clutter = smooth;
  clutter.clutter = 1;
  const auto times_as_dear = [&](const MethodOptions& options) {
    return PredictCost(clutter, options).receiver_ms / PredictCost(smooth, options).receiver_ms;
  };
  const auto rays = [](float max_error) {
    return RayOptions{.rays = kMostRays, .is_adaptive = true, .max_error = max_error};
  };
  EXPECT_GT(times_as_dear(ShaftOptions{.rows = 8}), 1.2);
  EXPECT_GT(times_as_dear(rays(0.02f)), 1.2);
  EXPECT_GT(times_as_dear(rays(0.002f)), 2 * times_as_dear(rays(0.02f)));
  EXPECT_EQ(times_as_dear(RayOptions{.rays = 64}), 1);
}

TEST(CostModelTest, ClutterIsToldByTheVerticesThatTrianglesShare) {
  const auto clutter_of = [](const char* name) {
    const MadeScene made = MakeScene(name, {.light_share = 0.2});
    const FlatScene scene = MakeFlatScene(made.meshes);
    const auto pose = BuildPose(scene, 0, {});
    EXPECT_OK(pose);
    return FactsForMethod(scene, *pose, RequestFor(made), 640 * 360).clutter;
  };
  EXPECT_EQ(clutter_of("S2"), 0) << "a smooth solid";
  EXPECT_EQ(clutter_of("S5"), 1) << "leaves of two triangles";
}

}  // namespace
}  // namespace halfshade
