// Random scenes, lights, cameras and options. HALFSHADE_STRESS_SCENES says how many a method; 300 unless set.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <random>

#include "tests/stress/stress_fixture.h"

namespace halfshade {
namespace {

class RandomStressTest : public StressTest {};
INSTANTIATE_TEST_SUITE_P(Methods, RandomStressTest, testing::ValuesIn(TestMethods()), TestMethodName);

class Random {
 public:
  explicit Random(uint32_t seed) : engine_(seed) {}
  double Unit() { return double(engine_() >> 8) / double(1 << 24); }
  glm::dvec3 Point(double reach) {
    const double x = Unit(), y = Unit(), z = Unit();
    return (glm::dvec3(x, y, z) - 0.5) * (2 * reach);
  }
  size_t Below(size_t count) { return std::min(count - 1, size_t(Unit() * double(count))); }

 private:
  std::mt19937 engine_;
};

std::vector<GlbMesh> RandomMeshes(Random& random) {
  std::vector<GlbMesh> meshes = {MakePlate({0, -1, 0}, 6, 6)};
  const int count = int(1 + 5 * random.Unit());
  for (int i = 0; i < count; ++i) {
    const double kind = random.Unit();
    const glm::dvec3 center = random.Point(1.5);
    if (kind < 0.4) meshes.push_back(MakeSphere(center, 0.01 + 0.6 * random.Unit(), 8));
    if (kind >= 0.4 && kind < 0.8) meshes.push_back(MakeBox(center, glm::abs(random.Point(0.5)) + 1e-3));
    if (kind >= 0.8) meshes.push_back(MakeSquare(center, 2 * random.Unit() + 1e-3, M_PI * random.Unit()));
  }
  return meshes;
}

// Anywhere, among the occluders too; a fifth looks anywhere, the others into the scene. A tenth each without width or
// height, a fifth with two sides.
AreaLight RandomLight(Random& random) {
  AreaLight light = LightAbove(0, 0);
  light.center_ws = random.Point(2.5);
  const bool looks_anywhere = random.Unit() < 0.2;
  light.normal_ws = glm::normalize(random.Point(1) - (looks_anywhere ? glm::dvec3(0) : light.center_ws));
  light.axis_u_ws = glm::normalize(glm::cross(light.normal_ws, random.Point(1)));
  light.axis_v_ws = glm::cross(light.normal_ws, light.axis_u_ws);
  light.width_m = random.Unit() < 0.1 ? 0 : std::pow(10.0, 2 * random.Unit() - 2);
  light.height_m = random.Unit() < 0.1 ? 0 : std::pow(10.0, 2 * random.Unit() - 2);
  light.is_two_sided = random.Unit() < 0.2;
  return light;
}

TEST_P(RandomStressTest, RandomScenesLightsAndOptionsAreFiniteAndInRange) {
  const char* const asked = std::getenv("HALFSHADE_STRESS_SCENES");
  const int scenes = asked != nullptr ? std::atoi(asked) : 300;
  ASSERT_GT(scenes, 0) << "HALFSHADE_STRESS_SCENES=" << asked;
  int bad = 0, partial = 0, compared = 0, far_from_rays = 0;
  double mean_difference = 0;
  for (int round = 0; round < scenes; ++round) {
    Random random(uint32_t(1000 + round));  // the same for every method
    const FlatScene scene = MakeFlatScene(RandomMeshes(random));
    RenderRequest request;
    request.camera = LookFrom(random.Point(3) + glm::dvec3(0, 0.1, 3.1), {0, 0, 0});
    request.width = 64;
    request.height = 36;
    request.lights = {RandomLight(random)};
    request.seed = uint32_t(round);
    request.light_map_size = 64;
    const std::vector<MethodOptions>& others = GetParam().others;
    // Now and then as other tests have it; that is dearer.
    request.method = others.empty() || random.Unit() < 0.05 ? GetParam().options : others[random.Below(others.size())];
    const Image v = RenderVisibility(scene, request);
    if (!IsInRange(v)) {
      ++bad;
      ADD_FAILURE() << "scene " << round;
      continue;
    }
    partial += *std::max_element(v.data(), v.data() + v.size()) > *std::min_element(v.data(), v.data() + v.size());
    if (round % 5 != 0) continue;
    request.method = GetParam().options;
    const Image own = RenderVisibility(scene, request);
    request.method = RayOptions{512};
    const double difference = Between(own, RenderVisibility(scene, request), 1).mean;
    mean_difference += difference;
    far_from_rays += difference > 0.1;
    ++compared;
  }
  // One point or one view may be wrong over most of a picture that is penumbra; light that leaks into the dark, or a
  // side that no map covers, would be wrong in many.
  Row("random scenes, against rays", far_from_rays <= compared / 100,
      std::to_string(far_from_rays) + " of " + std::to_string(compared) + " off by over .1 on average; all by " +
          std::to_string(mean_difference / compared));
  Row("random scenes", bad == 0,
      std::to_string(bad) + " of " + std::to_string(scenes) + " out of range; light and shadow in " +
          std::to_string(partial));
  EXPECT_GT(partial, scenes * 3 / 4) << "else they show little";
}

}  // namespace
}  // namespace halfshade
