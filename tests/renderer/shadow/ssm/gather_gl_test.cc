// The two forms of the gather, on the CPU and in GL, through the method's own door.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <random>

#include "renderer/gl/draw_context.h"
#include "renderer/light/occluders_on_context.h"
#include "renderer/scene/pose.h"
#include "renderer/scene/scene_on_context.h"
#include "renderer/shadow/finish_visibility.h"
#include "renderer/shadow/ssm/ssm.h"
#include "tests/support/render_fixture.h"

namespace halfshade {
namespace {

struct Case {
  const char* name;
  double light_edge_m;
  SsmOptions options;
  uint64_t max_bytes = 1ull << 30;
  bool is_in_room = false;
};

class TwinTest : public testing::TestWithParam<Case> {};
INSTANTIATE_TEST_SUITE_P(
    Lights, TwinTest,
    testing::Values(Case{"wide", 1.2, {.occluder_map_size = 128, .sub_lights = 2}},
                    Case{"narrow", 0.1, {.occluder_map_size = 256, .sub_lights = 1, .bins = 8}},
                    Case{"point", 0, {.occluder_map_size = 128}},
                    Case{"two_passes", 1, {.occluder_map_size = 128, .passes = 2, .sub_lights = 2, .bins = 3}},
                    Case{
                        "without_coverage", 1, {.occluder_map_size = 128, .sub_lights = 1, .measures_coverage = false}},
                    Case{"nothing_kept", 1, {.occluder_map_size = 64, .sub_lights = 2}, 0},
                    Case{"in_a_room", 1, {.occluder_map_size = 128, .sub_lights = 2}, 1ull << 30, true}),
    [](const auto& param) { return param.param.name; });

TEST_P(TwinTest, CpuAndGlGiveTheSameVisibility) {
  const Case& c = GetParam();
  std::vector<GlbMesh> meshes = {MakeSphere({-0.3, 1, 0}, 0.5, 24), MakeBox({0.9, 0.4, 0.2}, {0.3, 0.8, 0.35}),
                                 MakePlate({0, 0, 0}, 8, 8)};
  if (c.is_in_room) meshes.push_back(MakeBox({1.6, 2, 0}, {0.1, 4, 4}));  // a wall through the light's plane
  const FlatScene scene = MakeFlatScene(meshes);
  const AreaLight light = LightAbove(3, c.light_edge_m, {0.4, 0.3});

  // On the ground, on the sphere and on the box's top, each with its normal.
  std::mt19937 random(5);
  std::uniform_real_distribution<float> any(-1, 1);
  std::vector<glm::vec3> points, normals;
  for (int i = 0; i < 2000; ++i) {
    const glm::vec3 direction = glm::normalize(glm::vec3(any(random), any(random), any(random)));
    points.emplace_back(2 * any(random), 0, 2 * any(random));
    normals.emplace_back(0, 1, 0);
    points.push_back(glm::vec3(-0.3f, 1, 0) + 0.5f * direction);
    normals.push_back(direction);
    points.emplace_back(0.9f + 0.15f * any(random), 0.8f, 0.2f + 0.17f * any(random));
    normals.emplace_back(0, 1, 0);
  }
  const CpuReceivers on_cpu = MakePointReceivers(points, normals);

  gl::ProgramCache programs(&TestContext());
  gl::Pacer pacer(TestContext(), [] { return absl::OkStatus(); });
  const DrawContext draw = {&TestContext(), &programs, &pacer};
  const auto pose = BuildPose(scene, 0, {});
  ASSERT_OK(pose);
  auto on_context = SceneOnContext::Create(draw, scene);
  ASSERT_OK(on_context);
  LightInputs inputs;
  inputs.light = light;
  inputs.max_light_data_bytes = c.max_bytes;
  auto occluders = OccludersOnContext::Create(draw, scene, **on_context, BuildLightSpaceOccluders(scene, *pose, light));
  ASSERT_OK(occluders);
  inputs.occluders = *std::move(occluders);
  const auto textures = UploadReceivers(TestContext(), on_cpu);
  ASSERT_OK(textures);
  Receivers receivers = {&textures->planes, on_cpu.camera, on_cpu.width, on_cpu.height};
  receivers.points = &textures->points;
  receivers.on_cpu = &on_cpu;

  std::vector<float> visibility[2];
  double cpu_ms[2];
  for (const SsmProcessor processor : {SsmProcessor::kCpu, SsmProcessor::kGl}) {
    const SsmMethod method(processor);
    EXPECT_EQ(method.Needs(c.options, {}).cpu_receivers, processor == SsmProcessor::kCpu);
    const auto data = method.BuildLightData(draw, inputs, c.options);
    ASSERT_OK(data);
    EXPECT_EQ((*data)->MapsRedrawn() > 0, c.max_bytes == 0);
    // The first one compiles.
    ASSERT_OK(method.ResolveOcclusion(draw, **data, receivers, c.options));
    const std::clock_t start = std::clock();  // of all threads
    const auto sum = method.ResolveOcclusion(draw, **data, receivers, c.options);
    ASSERT_OK(sum);
    TestContext().gl().Finish();
    cpu_ms[int(processor == SsmProcessor::kGl)] = 1e3 * double(std::clock() - start) / CLOCKS_PER_SEC;
    if (processor == SsmProcessor::kCpu) {
      visibility[0] = FinishVisibilityOnCpu(&*sum, on_cpu, light);
    } else {
      const auto finished = FinishVisibility(draw, &*sum, receivers, light);
      ASSERT_OK(finished);
      std::vector<float> pairs(2 * on_cpu.size());
      ASSERT_OK(finished->ReadFloats(pairs.data(), pairs.size()));
      for (size_t i = 0; i < on_cpu.size(); ++i) visibility[1].push_back(pairs[2 * i]);
    }
  }
  double worst = 0, mean = 0;
  int partly = 0;
  for (size_t i = 0; i < points.size(); ++i) {
    const double d = std::abs(double(visibility[0][i]) - visibility[1][i]);
    worst = std::max(worst, d);
    mean += d / double(points.size());
    partly += visibility[0][i] > 0 && visibility[0][i] < 1;
  }
  std::printf("%s: largest difference %.2g, mean %.2g, %d of %zu in penumbra; CPU %.1f ms, GL %.1f CPU-ms\n", c.name,
              worst, mean, partly, points.size(), cpu_ms[0], cpu_ms[1]);
  EXPECT_GT(partly, c.light_edge_m > 0 ? 100 : 20);  // of a point: one texel around the silhouettes
  EXPECT_LE(worst, 1e-4);
}

}  // namespace
}  // namespace halfshade
