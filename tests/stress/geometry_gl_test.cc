// What must hold of occluders near the light, near the receiver, near each other, and of broken ones; and two truths in
// closed form: a plate parallel to the light, a penumbra that is as wide as its gap.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <glm/gtc/matrix_transform.hpp>
#include <random>

#include "renderer/light/occluders.h"
#include "renderer/shadow/shadow_method.h"
#include "tests/stress/stress_fixture.h"
#include "tests/support/closed_forms.h"

namespace halfshade {
namespace {

class GeometryStressTest : public StressTest {
 protected:
  // Width of a texel of the fine method's front map on the plane at light_z, metres; 0: it has no map.
  static double TexelAt(const View& view, double light_z) {
    const int map_size = FindMethod(GetParam().Fine()).method->Needs(GetParam().Fine(), {}).map_size;
    if (map_size == 0) return 0;
    const LightSpaceOccluders occluders = BuildLightSpaceOccluders(view.scene, *BuildPose(view.scene, 0), view.light);
    const Window window = occluders.hull.FrontWindow({view.light.width_m / 2, view.light.height_m / 2});
    return std::max(window.u1 - window.u0, window.v1 - window.v0) / map_size * light_z;
  }
  static float Brightest(const Image& v) {
    return v.size() == 0 ? 1 : *std::max_element(v.data(), v.data() + v.size());
  }
  static float Darkest(const Image& v) { return v.size() == 0 ? 0 : *std::min_element(v.data(), v.data() + v.size()); }
};
INSTANTIATE_TEST_SUITE_P(Methods, GeometryStressTest, testing::ValuesIn(TestMethods()), TestMethodName);

TEST_P(GeometryStressTest, ALightInsideOrTouchingAnOccluderLightsNothingBehindIt) {
  // A closed box around the light: everything outside is dark. The plane lies below.
  for (const double gap : {0.1, 1e-5, 1e-6, 0.0}) {
    View view = Still(0.2);
    const glm::dvec3 at = view.light.center_ws;
    // The light's own plane is `gap` above the box's floor.
    view.scene = MakeFlatScene({MakeBox({at.x, at.y - gap + 0.5, at.z}, {1, 1, 1}), MakePlate({0, 0, 0}, 8, 8)});
    const Image v = Render(view);
    float brightest = 0;
    for (int y = kStressSize / 2; y < kStressSize; ++y) {
      for (int x = 0; x < kStressSize; ++x) brightest = std::max(brightest, v.at(x, y, 0));
    }
    // At gap 0 the floor lies in the light's plane and occludes or not by contract of who is in front: only finite.
    Row(gap == 1e-6 ? "light touching a box" : "light in a box", IsInRange(v) && (gap == 0 || brightest == 0),
        "gap " + std::to_string(gap) + ": brightest " + std::to_string(brightest));
  }
}

// A plate right above the plane: under it all is dark, on it all is lit, whatever else stands how near to the light. 4
// ulps are 4.8e-7.
TEST_P(GeometryStressTest, TwoPlanesAreSeparateWhileTheirGapIsOverFourUlps) {
  for (const double far_to_near : {1.0, 1e2, 1e4, 1e7}) {
    for (const double gap : {1e-1, 1e-3, 1e-5, 1.5e-6, 5e-7}) {  // of the distance to the light
      std::vector<GlbMesh> meshes = {MakePlate({0, gap, 0}, 0.5, 0.5), MakePlate({0, 0, 0}, 0.6, 0.6)};
      if (far_to_near > 1) {
        // So small beside the light that it hides a hundredth of a thousandth of it at most, and aside.
        const double z = 1 / far_to_near;
        meshes.push_back(MakePlate({3 * z, 1 - z, 0}, 3e-3 * z, 3e-3 * z));
      }
      View view = {MakeFlatScene(meshes), LookDown(gap / 2, 0.4), LightAbove(1, 0.1)};
      const float under = Brightest(Render(view));
      view.camera = LookDown(0.5, 0.4);
      view.camera.near_m = 1e-3;
      const float above = Darkest(Render(view));
      char figure[120];
      std::snprintf(figure, sizeof(figure), "far/near %.0e, gap %.0e: brightest under it %g, darkest on it %g",
                    far_to_near, gap, under, above);
      Row(gap == 5e-7 ? "near planes, 4 ulps" : "near planes", under == 0 && above >= 1 - 1e-3f, figure);
    }
  }
}

// Penumbra of a straight edge `gap` above the plane: L gap / (H - gap) wide.
TEST_P(GeometryStressTest, APenumbraIsAsWideAsItsGapSays) {
  constexpr double kHeight = 2, kLight = 0.4;
  for (const double gap : {0.02, 0.04, 0.08, 0.16, 0.32}) {
    const double width = kLight * gap / (kHeight - gap);
    View view;
    view.scene = MakeFlatScene({MakePlate({-0.5, gap, 0}, 1, 1), MakePlate({0, 0, 0}, 1, 1)});
    view.light = LightAbove(kHeight, kLight);
    view.camera = LookDown(gap / 2, 2 * width);
    if (width < 2 * TexelAt(view, kHeight)) continue;
    const Image v = Render(view, GetParam().Fine(), 128);
    // Of a ramp from 0 to 1 the integral of v (1 - v) is a sixth of its width.
    double measured = 0;
    for (size_t i = 0; i < v.size(); ++i) measured += 6.0 * v.data()[i] * (1 - v.data()[i]);
    measured *= 2 * width / 128 / 128;
    Row("contact penumbra", std::abs(measured / width - 1) <= 0.1,
        "gap " + std::to_string(gap) + ": " + std::to_string(measured / width) + " of its width, " +
            std::to_string(width / TexelAt(view, kHeight)) + " texels");
  }
}

// A square plate parallel to light and ground: the product of two trapezoids. A map may move each edge by half a texel.
TEST_P(GeometryStressTest, BehindAParallelPlateVisibilityIsTheTrapezoidWithinHalfATexelsSlope) {
  constexpr double kView = 3.2;
  View view;
  view.scene = MakeFlatScene({MakePlate({0, 1, 0}, 0.8, 0.8), MakePlate({0, 0, 0}, 4, 4)});
  view.light = LightAbove(2, 0.4);
  view.camera = LookDown(0.5, kView);
  const Image v = Render(view, GetParam().Fine(), 128);
  double max = 0, mean = 0;
  for (int y = 0; y < v.height(); ++y) {
    for (int x = 0; x < v.width(); ++x) {
      const glm::dvec3 receiver(((x + 0.5) / 128 - 0.5) * kView, ((y + 0.5) / 128 - 0.5) * kView, 2);
      const double d =
          std::abs(v.at(x, y, 0) - VisibilityBehindPlate(glm::dvec2(0.2), {0, 0, 1}, {0.4, 0.4}, receiver));
      max = std::max(max, d);
      mean += d / double(v.size());
    }
  }
  // h / (2 L dw) an axis, dw = 1/1 - 1/2; the texel's width in slopes is that on the plane light_z = 1.
  const double half_texel = TexelAt(view, 1) / (2 * 0.4 * 0.5);
  const double most = 2 * half_texel + GetParam().fine_step;
  char figure[120];
  std::snprintf(figure, sizeof(figure), "max %.5f, mean %.5f; half a texel's slope %.5f an axis, taps or samples %.5f",
                max, mean, half_texel, GetParam().fine_step);
  Row("parallel plate", v.size() > 0 && max <= most, figure);
}

// A lone convex solid shadows itself by its horizon alone.
TEST_P(GeometryStressTest, ALoneConvexSolidSeesExactlyTheShareOfTheLightAboveItsPlanes) {
  struct Solid {
    const char* name;
    GlbMesh mesh;
  };
  size_t whole = 0, partial = 0;
  GlbMesh turned = MakeBox({0, 0, 0}, {1.2, 0.8, 1});
  turned.world_from_mesh = glm::rotate(glm::dmat4(1), 0.6, glm::normalize(glm::dvec3(1, 2, 3)));
  for (const Solid& solid : {Solid{"sphere", MakeSphere({0, 0, 0}, 0.8, 16)}, Solid{"box", turned}}) {
    for (const glm::dvec3& eye : {glm::dvec3(3, 2, 2), glm::dvec3(-2, 3, 1)}) {
      View view = {MakeFlatScene({solid.mesh}), LookFrom(eye, {0, 0, 0}), LightAbove(3, 1.5, {0.3, 0.2})};
      const Image v = Render(view, GetParam().Fine());
      RenderRequest bare;
      bare.camera = view.camera;
      bare.width = bare.height = kStressSize;
      bare.lights = {view.light};
      bare.method = GetParam().options;
      bare.node_overrides.emplace_back().casts = false;
      const Image share = RenderVisibility(view.scene, bare);
      double acne = 0, cut = 0;
      for (size_t i = 0; i < v.size(); ++i) {
        const double difference = std::abs(double(share.data()[i]) - v.data()[i]);
        (share.data()[i] == 1 ? acne : cut) = std::max(share.data()[i] == 1 ? acne : cut, difference);
        ++(share.data()[i] == 1 ? whole : partial);
      }
      char figure[120];
      std::snprintf(figure, sizeof(figure), "%s from x = %g: whole light off by %.2g, a cut one by %.2g", solid.name,
                    eye.x, acne, cut);
      Row("lone solid", acne <= 1e-3 && cut <= 2e-2, figure);
    }
  }
  EXPECT_GT(whole, 10000u);
  EXPECT_GT(partial, 1000u);
}

TEST_P(GeometryStressTest, BrokenTrianglesChangeNothing) {
  const Image whole = Render(Still());
  const std::vector<GlbMesh> clean = StillMeshes();
  std::mt19937 random(3);
  constexpr size_t kSphere = 0, kBox = 1;
  struct Fault {
    const char* name;
    size_t mesh;
    double bound;
    std::function<void(GlbMesh&)> make;
  };
  const auto add_point = [](GlbMesh& mesh, const glm::vec3& p) {
    mesh.positions.push_back(p);
    if (!mesh.normals.empty()) mesh.normals.push_back(mesh.normals[0]);
    return uint32_t(mesh.positions.size() - 1);
  };
  const std::vector<Fault> faults = {
      {"duplicates", kSphere, 1e-6,
       [](GlbMesh& mesh) {
         const std::vector<uint32_t> again = mesh.indices;
         mesh.indices.insert(mesh.indices.end(), again.begin(), again.end());
       }},
      {"inverted", kSphere, 1e-6,
       [](GlbMesh& mesh) {
         for (size_t i = 0; i < mesh.indices.size(); i += 3) std::swap(mesh.indices[i], mesh.indices[i + 1]);
         mesh.is_double_sided = true;
         mesh.normals.clear();
       }},
      // Inside the sphere: seen by nobody, hides nothing more.
      {"a third triangle on an edge", kSphere, 1e-6,
       [&](GlbMesh& mesh) {
         const uint32_t middle = add_point(mesh, {-0.3f, 1.0f, 0.0f});
         mesh.indices.insert(mesh.indices.end(), {mesh.indices[300], mesh.indices[301], middle});
       }},
      {"no area", kSphere, 1e-6,
       [&](GlbMesh& mesh) {
         const uint32_t a = mesh.indices[30], b = mesh.indices[31];
         const uint32_t middle = add_point(mesh, mesh.positions[a]);
         mesh.indices.insert(mesh.indices.end(), {a, a, b, a, b, middle, a, a, a});
       }},
      // In the plane of the box's faces, a millionth as wide as long.
      {"slivers", kBox, 1e-6,
       [&](GlbMesh& mesh) {
         const std::vector<uint32_t> faces = mesh.indices;
         for (size_t i = 0; i < faces.size(); i += 3) {
           const glm::vec3 a = mesh.positions[faces[i]], b = mesh.positions[faces[i + 1]],
                           c = mesh.positions[faces[i + 2]];
           mesh.indices.insert(mesh.indices.end(),
                               {faces[i], faces[i + 1], add_point(mesh, (a + b) / 2.0f + (c - b) * 1e-6f)});
         }
       }},
      // Every triangle cut in two at the middle of its first edge; the neighbour across it is not.
      {"T-junctions", kBox, 1e-6,
       [&](GlbMesh& mesh) {
         for (size_t i = 0, end = mesh.indices.size(); i < end; i += 3) {
           const uint32_t b = mesh.indices[i + 1], c = mesh.indices[i + 2];
           const uint32_t middle = add_point(mesh, (mesh.positions[mesh.indices[i]] + mesh.positions[b]) / 2.0f);
           mesh.indices[i + 1] = middle;
           mesh.indices.insert(mesh.indices.end(), {middle, b, c});
         }
       }},
      // Of what is drawn in another order sums may round otherwise.
      {"shuffled", kSphere, 1e-4,
       [&random](GlbMesh& mesh) {
         std::vector<std::array<uint32_t, 3>> triangles;
         for (size_t i = 0; i < mesh.indices.size(); i += 3) {
           triangles.push_back({mesh.indices[i], mesh.indices[i + 1], mesh.indices[i + 2]});
         }
         std::shuffle(triangles.begin(), triangles.end(), random);
         mesh.indices.clear();
         for (const auto& triangle : triangles) {
           mesh.indices.insert(mesh.indices.end(), triangle.begin(), triangle.end());
         }
       }},
  };
  for (const Fault& fault : faults) {
    std::vector<GlbMesh> meshes = clean;
    fault.make(meshes[fault.mesh]);
    View view = Still();
    view.scene = MakeFlatScene(meshes);
    const Difference d = Between(whole, Render(view), fault.bound);
    Row("broken triangles", d.is_finite && d.max <= fault.bound, std::string(fault.name) + ": " + Text(d));
  }
}

// Four plates in the corners, nearer to the light than all else, give every set the same windows.
TEST_P(GeometryStressTest, TwoSetsOfOccludersHideNoMoreThanTheirSumAndNoLessThanTheLarger) {
  const GlbMesh a = MakeSphere({-0.3, 1, 0}, 0.5, 16), b = MakeBox({0.4, 0.6, 0.2}, {0.3, 0.4, 0.35});
  const auto occlusion = [&](std::vector<GlbMesh> meshes) {
    meshes.push_back(MakePlate({0, 0, 0}, 8, 8));
    for (const double x : {-1.1, 1.9}) {
      for (const double z : {-1.2, 1.8}) meshes.push_back(MakePlate({x, 1.6, z}, 0.1, 0.1));
    }
    View view = Still();
    view.scene = MakeFlatScene(meshes);
    view.camera = LookDown(0.3, 4);  // below the occluders: the plane alone
    return Render(view);
  };
  SetsOfOccluders(occlusion({a}), occlusion({b}), occlusion({a, b}));
}

}  // namespace
}  // namespace halfshade
