// The table's rows for soft shadow maps that pictures look up: of what does not cast, which is all that gets shadows
// there.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <random>

#include "tests/stress/stress_fixture.h"

namespace halfshade {
namespace {

class SoftShadowMapStressTest : public StressTest {
 protected:
  // Node 2, Still()'s plane, does not cast.
  static Image Render(const View& view) {
    RenderRequest request = RequestFor(view, GetParam().options, kStressSize);
    NodeOverride& plane = request.node_overrides.emplace_back();
    plane.node = 2;
    plane.casts = false;
    request.light_map_size = 256;
    return RenderVisibility(view.scene, request);
  }
};
INSTANTIATE_TEST_SUITE_P(Forms, SoftShadowMapStressTest, testing::ValuesIn(SoftShadowMapForms()), TestMethodName);

TEST_P(SoftShadowMapStressTest, ScaleAndPlaceChangeAlmostNothing) {
  const Image one = Render(Still());
  EXPECT_LT(*std::min_element(one.data(), one.data() + one.size()), 0.1f) << "there is a shadow";
  for (const double scale : {0x1p-20, 0x1p20}) {
    const Difference d = Between(one, Render(Moved(Still(), glm::dmat4(1), scale)), 0);
    Row("scale by powers of two", d.is_finite && d.max == 0, std::to_string(scale) + ": " + Text(d));
  }
  for (const double scale : {1e-6, 1e-3, 3.0, 1e3, 1e6}) {
    const Difference d = Between(one, Render(Moved(Still(), glm::dmat4(1), scale)), 2e-3);
    Row("scale", d.is_finite && d.share_over <= 1e-3, std::to_string(scale) + ": " + Text(d));
  }
  for (const double extents : {1.0, 1e2, 1e4}) {
    const glm::dmat4 move = glm::translate(glm::dmat4(1), glm::dvec3(8, 2, -5) * extents);
    const Difference d = Between(one, Render(Moved(Still(), move)), 1e-3);
    Row("translation", d.is_finite && d.share_over <= 1e-3, std::to_string(extents) + " extents: " + Text(d));
  }
  const Image far = Render(Moved(Still(), glm::translate(glm::dmat4(1), glm::dvec3(1e9, 0, 0))));
  Row("far translation", IsInRange(far), "finite and in [0,1]");
}

TEST_P(SoftShadowMapStressTest, TheLightsAxesChangeNothing) {
  View still = Still();
  still.light.height_m = 0.6;
  const AreaLight light = still.light;
  const Image one = Render(still);
  View turned = still;
  turned.light.axis_u_ws = light.axis_v_ws;
  turned.light.axis_v_ws = -light.axis_u_ws;
  std::swap(turned.light.width_m, turned.light.height_m);
  Difference d = Between(one, Render(turned), 1e-3);
  Row("turned light", d.is_finite && d.share_over <= 1e-3, "90 degrees: " + Text(d));
  turned = still;
  turned.light.axis_u_ws = -light.axis_u_ws;
  turned.light.axis_v_ws = -light.axis_v_ws;
  d = Between(one, Render(turned), 1e-3);
  Row("turned light", d.is_finite && d.share_over <= 1e-3, "180 degrees: " + Text(d));
}

TEST_P(SoftShadowMapStressTest, LightsOfEverySizeAreInRangeAndGrowAsLightsDo) {
  LightGrows();
  const Difference d = Between(Render(Still(0)), Render(Still(3e-7)), 1e-3);
  Row("tiny light", d.is_finite && d.share_over <= 0.01, Text(d));
  for (const glm::dvec2 size : {glm::dvec2(1, 0), glm::dvec2(0, 1), glm::dvec2(0, 0), glm::dvec2(1, 1e-3)}) {
    View view = Still();
    view.light.width_m = size.x;
    view.light.height_m = size.y;
    Row("thin light", IsInRange(Render(view)), std::to_string(size.x) + " x " + std::to_string(size.y));
  }
  View inside = Still();
  inside.light.center_ws = {-0.3, 1.2, 0};
  Row("light in an occluder", IsInRange(Render(inside)), "finite and in [0,1]");
}

TEST_P(SoftShadowMapStressTest, TheOrderOfTrianglesChangesNothing) {
  std::vector<GlbMesh> meshes = StillMeshes();
  std::vector<uint32_t>& indices = meshes[0].indices;
  std::vector<std::array<uint32_t, 3>> triangles;
  for (size_t i = 0; i < indices.size(); i += 3) triangles.push_back({indices[i], indices[i + 1], indices[i + 2]});
  std::mt19937 random(3);
  std::shuffle(triangles.begin(), triangles.end(), random);
  indices.clear();
  for (const auto& triangle : triangles) indices.insert(indices.end(), triangle.begin(), triangle.end());
  View view = Still();
  view.scene = MakeFlatScene(meshes);
  const Difference d = Between(Render(Still()), Render(view), 1e-4);
  Row("shuffled triangles", d.is_finite && d.max <= 1e-4, Text(d));
}

TEST_P(SoftShadowMapStressTest, NothingIsExactlyLitAndAFullCoverDark) {
  View view = Still();
  view.camera = LookDown(0.05, 2);
  view.scene = MakeFlatScene({MakePlate({0, 5, 0}, 1, 1), MakePlate({0, 6, 0}, 1, 1), MakePlate({0, 0, 0}, 8, 8)});
  const Image lit = Render(view);  // occluders behind the light
  Row("no occluder", std::all_of(lit.data(), lit.data() + lit.size(), [](float v) { return v == 1; }), "exactly 1");
  view.scene = MakeFlatScene({MakePlate({0, 1, 0}, 9, 9), MakePlate({0, 6, 0}, 1, 1), MakePlate({0, 0, 0}, 8, 8)});
  const Image dark = Render(view);
  const float most = *std::max_element(dark.data(), dark.data() + dark.size());
  // Halves hold a sum of batches to some 2^-7.
  const bool has_halves = std::get<SsmOptions>(GetParam().options).blend != SsmBlend::kFp32;
  Row("full cover", most <= (has_halves ? 0.02f : 1e-5f), std::to_string(most));
}

// As of all methods: four plates in the corners give every set the same windows.
TEST_P(SoftShadowMapStressTest, TwoSetsOfOccludersHideNoMoreThanTheirSumAndNoLessThanTheLarger) {
  const GlbMesh a = MakeSphere({-0.3, 1, 0}, 0.5, 16), b = MakeBox({0.4, 0.6, 0.2}, {0.3, 0.4, 0.35});
  const auto occlusion = [&](std::vector<GlbMesh> meshes) {
    if (meshes.size() == 1) meshes.push_back(MakePlate({-1.1, 1.6, -1.2}, 0.1, 0.1));
    meshes.push_back(MakePlate({0, 0, 0}, 8, 8));
    for (const double x : {-1.1, 1.9}) {
      for (const double z : {-1.2, 1.8}) meshes.push_back(MakePlate({x, 1.6, z}, 0.1, 0.1));
    }
    View view = Still();
    view.scene = MakeFlatScene(meshes);
    view.camera = LookDown(0.3, 4);
    return Render(view);
  };
  SetsOfOccluders(occlusion({a}), occlusion({b}), occlusion({a, b}));
}

}  // namespace
}  // namespace halfshade
