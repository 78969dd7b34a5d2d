#include "renderer/shadow/shaft/mesh_shape.h"

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <glm/gtc/matrix_transform.hpp>
#include <memory>
#include <random>

#include "renderer/light/cpu_occluders.h"
#include "renderer/scene/pose.h"
#include "renderer/shadow/shaft/polygon_tree.h"
#include "tests/renderer/shadow/shaft/resolve_points.h"
#include "tests/support/closed_forms.h"
#include "tests/support/flat_scene_builder.h"
#include "tests/support/mesh_parts.h"
#include "tests/support/render_fixture.h"

namespace halfshade {
namespace {

absl::StatusOr<Rgba8Image> NoImage(const EncodedImage&) { return absl::InternalError("nothing is masked"); }

// The scene's one mesh at each of these places.
FlatScene At(FlatScene scene, const std::vector<glm::dmat4>& places) {
  const Node node = scene.nodes[0];
  scene.nodes.clear();
  scene.scenes[0].roots.clear();
  for (const glm::dmat4& place : places) {
    scene.scenes[0].roots.push_back(uint32_t(scene.nodes.size()));
    scene.nodes.push_back(node);
    scene.nodes.back().local = place;
  }
  return scene;
}

// A potato of 4 rings (rings - 1) triangles, closed.
FlatScene Potato(int rings) {
  GlbMesh mesh;
  AddStarSolid(mesh, {0.1, -0.2, 0.05}, rings, [](const glm::dvec3& d) {
    return 1 + 0.3 * std::sin(5 * d.x + 1) * std::cos(4 * d.y) + 0.1 * std::sin(9 * d.z);
  });
  return MakeFlatScene({mesh});
}

// A sheet of 2 cells^2 triangles that is seen from both sides.
FlatScene Sheet(int cells) {
  GlbMesh mesh;
  AddGrid(mesh, cells, cells,
          [](double s, double t) { return glm::dvec3(2 * s - 1, 0.3 * std::sin(4 * s + 3 * t), 2 * t - 1); });
  return MakeFlatScene({mesh});
}

// Turned, stretched and mirrored at random, `size` large, in a box of half edges `reach` around (0, height, 0).
std::vector<glm::dmat4> Scattered(int count, double size, const glm::dvec3& reach, double height) {
  std::mt19937 random(7);
  const auto uniform = [&](double low, double high) { return low + (high - low) * double(random()) / 4294967296.0; };
  std::vector<glm::dmat4> places;
  for (int i = 0; i < count; ++i) {
    const glm::dvec3 offset(uniform(-reach.x, reach.x), uniform(-reach.y, reach.y), uniform(-reach.z, reach.z));
    const glm::dvec3 axis(uniform(-1, 1), uniform(-1, 1), uniform(0.1, 1));
    glm::dmat4 place = glm::translate(glm::dmat4(1), offset + glm::dvec3(0, height, 0));
    place = glm::rotate(place, uniform(0, 6), glm::normalize(axis));
    const glm::dvec3 scale(uniform(0.5, 1.5) * size * (i % 3 == 0 ? -1 : 1), uniform(0.5, 1.5) * size, size);
    places.push_back(glm::scale(place, scale));
  }
  return places;
}

enum class Form { kCopies, kShapes, kShapesWithLevels };

struct Built {
  MeshShapes shapes;
  CpuOccluders occluders;
  PolygonTree tree;
  double shape_cpu_s = 0, light_cpu_s = 0;
};

double CpuSeconds() { return double(std::clock()) / CLOCKS_PER_SEC; }

// The same occluders in any form.
std::unique_ptr<const Built> Build(Form form, const FlatScene& scene, const AreaLight& light) {
  auto built = std::make_unique<Built>();
  const double start = CpuSeconds();
  if (form == Form::kShapesWithLevels) {
    built->shapes = *BuildMeshShapes(scene, [] { return absl::OkStatus(); });
  } else {
    built->shapes.kept_meshes.resize(scene.meshes.size(), kNotKept);
  }
  if (form == Form::kShapes) {
    built->shapes.kept_meshes = FindKeptMeshes(scene);
    for (const Mesh& mesh : scene.meshes) built->shapes.shapes.push_back(MakeMeshShape(scene, mesh, {}));
  }
  const double middle = CpuSeconds();
  built->occluders = *BuildCpuOccluders(scene, *BuildPose(scene, 0), built->shapes.kept_meshes, light, &NoImage);
  built->tree = BuildPolygonTree(built->occluders, built->shapes.shapes, light);
  built->shape_cpu_s = middle - start;
  built->light_cpu_s = CpuSeconds() - middle;
  return built;
}

// The ground, and points in the midst of what stands over it, with and without planes.
std::vector<CpuReceivers> Receivers(float size) {
  const std::vector<glm::vec3> ground = GroundPoints(64, size);
  std::vector<glm::vec3> midst = GroundPoints(24, size);
  for (size_t i = 0; i < midst.size(); ++i) midst[i].y = 0.2f + 1.5f * float(i % 7) / 7;
  return {OnGround(ground), OnGround(midst), MakePointReceivers(midst, {})};
}

double Mean(const std::vector<float>& values) {
  double sum = 0;
  for (const float value : values) sum += value / double(values.size());
  return sum;
}

void ExpectTheSameBits(const FlatScene& scene, const AreaLight& light, size_t in_front, float size) {
  const auto copies = Build(Form::kCopies, scene, light), instances = Build(Form::kShapes, scene, light);
  EXPECT_TRUE(copies->tree.instances.empty());
  EXPECT_EQ(instances->tree.instances.size(), in_front);
  EXPECT_TRUE(instances->tree.polygons.empty());
  EXPECT_EQ(instances->tree.space.scale, copies->tree.space.scale);
  for (const CpuReceivers& receivers : Receivers(size)) {
    const double start = CpuSeconds();
    const Resolved expected = ResolveTree(copies->tree, {}, light, receivers, 16);
    const double middle = CpuSeconds();
    const Resolved resolved = ResolveTree(instances->tree, {}, light, receivers, 16);
    const double end = CpuSeconds();
    const double mean = Mean(expected.hidden);
    EXPECT_GT(mean, 0.02) << "a shadow to compare";
    EXPECT_LT(mean, 0.98);
    EXPECT_EQ(resolved.hidden, expected.hidden);
    std::printf("%zu receivers: hidden %.3f on average, CPU time %.2f of that of copies\n", receivers.size(), mean,
                (end - middle) / (middle - start));
  }
}

TEST(MeshShapeTest, AThousandInstancesOfAClosedMeshHideWhatTheirCopiesDoToTheBit) {
  const AreaLight light = LightAbove(3, 0.6);
  const FlatScene scene = At(Potato(16), Scattered(1000, 0.06, {2.5, 0.7, 2.5}, 1.1));
  ExpectTheSameBits(scene, light, 1000, 5);
}

TEST(MeshShapeTest, AThousandInstancesOfAnOpenMeshHideWhatTheirCopiesDoToTheBit) {
  const AreaLight light = LightAbove(3, 0.6);
  const FlatScene scene = At(Sheet(16), Scattered(1000, 0.06, {2.5, 0.7, 2.5}, 1.1));
  ExpectTheSameBits(scene, light, 1000, 5);
}

TEST(MeshShapeTest, PointAndLineLightsSeeTheSameBits) {
  AreaLight light = LightAbove(3, 0);
  const FlatScene scene = At(Potato(16), Scattered(300, 0.12, {2, 0.7, 2}, 1.1));
  ExpectTheSameBits(scene, light, 300, 4);
  light.width_m = 0.8;
  ExpectTheSameBits(scene, light, 300, 4);
}

TEST(MeshShapeTest, AMeshFarFromItsOwnOriginHidesTheSameBits) {
  FlatScene scene = Potato(16);
  const glm::vec3 far(1000, -300, 70);
  for (glm::vec3& position : scene.positions) position += far;
  for (glm::vec3* corner : {&scene.meshes[0].bounds.min, &scene.meshes[0].bounds.max}) *corner += far;
  std::vector<glm::dmat4> places = Scattered(300, 0.12, {2, 0.7, 2}, 1.1);
  for (glm::dmat4& place : places) place = glm::translate(place, -glm::dvec3(far));
  ExpectTheSameBits(At(scene, places), LightAbove(3, 0.6), 300, 4);
}

// Some stand across the light's plane and are cut there, some behind it and hide nothing.
TEST(MeshShapeTest, AroundTheLightsPlaneTheBitsAreTheSameToo) {
  const AreaLight light = LightAbove(1.6, 0.6);
  const FlatScene scene = At(Potato(16), Scattered(1000, 0.06, {2.5, 0.7, 2.5}, 1.1));
  const auto built = Build(Form::kShapes, scene, light);
  const auto is_cut = [](const ShapeInstance& instance) { return instance.is_cut; };
  const auto& instances = built->tree.instances;
  EXPECT_GT(std::count_if(instances.begin(), instances.end(), is_cut), 50);
  EXPECT_LT(instances.size(), 1000u);
  ExpectTheSameBits(scene, light, instances.size(), 5);
}

// The light shines from within: no surface is a closed one there.
TEST(MeshShapeTest, AMeshAroundTheLightHidesTheSameBits) {
  const AreaLight light = LightAbove(1.6, 0.6);
  FlatScene scene = Potato(40);
  for (size_t i = 0; i < scene.positions.size(); ++i) scene.positions[i] *= i % 7 == 0 ? 2.2f : 2.5f;
  for (glm::vec3* corner : {&scene.meshes[0].bounds.min, &scene.meshes[0].bounds.max}) *corner *= 2.5f;
  ExpectTheSameBits(At(scene, {glm::translate(glm::dmat4(1), {0.0, 1.2, 0.0})}), light, 1, 5);
}

TEST(MeshShapeTest, TheBytesAreTheSameOnEveryInstructionSet) {
  const AreaLight light = LightAbove(3, 0.6);
  const auto instances = Build(Form::kShapes, At(Potato(16), Scattered(300, 0.12, {2, 0.7, 2}, 1.1)), light);
  ASSERT_EQ(instances->tree.instances.size(), 300u);
  const CpuReceivers receivers = OnGround(GroundPoints(64, 4));
  std::vector<std::vector<float>> results;
  for (const int64_t target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    results.push_back(ResolveTree(instances->tree, {}, light, receivers, 16).hidden);
  }
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  EXPECT_GT(results.size(), 1u) << "nothing to compare on this machine";
  for (const std::vector<float>& hidden : results) EXPECT_EQ(hidden, results[0]);
}

// One box of many faces stands over the ground, all others where they hide nothing of it. Its front faces must not
// count, whichever way its place turns it, or the receivers on its top would be dark.
TEST(MeshShapeTest, ABoxThatItsPlaceMirrorsHidesItsSilhouetteAndNotItself) {
  const AreaLight light = LightAbove(3, 0.6);
  GlbMesh box;
  AddTurnedBox(box, {-0.15, -0.3, -0.2}, {0.15, 0.3, 0.2}, 0, 24);
  const FlatScene mesh = MakeFlatScene({box});
  std::vector<glm::vec3> points = GroundPoints(48, 2), normals(points.size(), {0, 1, 0});
  const size_t on_ground = points.size();
  for (const glm::vec3& point : GroundPoints(16, 0.25)) {
    points.push_back(point + glm::vec3(0.1f, 1.3f, -0.1f));
    normals.emplace_back(0, 1, 0);
  }
  const CpuReceivers receivers = MakePointReceivers(points, normals);
  for (const glm::dvec3& mirror : {glm::dvec3(1), glm::dvec3(-1, 1, 1), glm::dvec3(1, -1, 1), glm::dvec3(-1)}) {
    std::vector<glm::dmat4> places;
    for (int i = 0; i < 80; ++i) places.push_back(glm::translate(glm::dmat4(1), {20.0 + i, 1.0, 0.0}));
    places[40] = glm::scale(glm::translate(glm::dmat4(1), {0.1, 1.0, -0.1}), mirror);
    const auto instances = Build(Form::kShapes, At(mesh, places), light);
    ASSERT_EQ(instances->tree.instances.size(), places.size());
    const Resolved resolved = ResolveTree(instances->tree, {}, light, receivers, 64);
    double largest = 0;
    for (size_t i = 0; i < points.size(); ++i) {
      // The light's y is the world's z.
      const double truth = i >= on_ground ? 0
                                          : 1 - VisibilityBehindBox({0.3, 0.3}, {-0.05, -0.3, 1.7}, {0.25, 0.1, 2.3},
                                                                    {points[i].x, points[i].z, 3});
      largest = std::max(largest, std::abs(resolved.hidden[i] - truth));
    }
    EXPECT_LE(largest, 0.01) << mirror.x << " " << mirror.y << " " << mirror.z;  // as of one that is not shared
  }
}

// Squeezed to a plate, it is copied; the rest are not.
TEST(MeshShapeTest, ABoxThatItsPlaceSqueezesFlatHidesWhatAPlateDoes) {
  const AreaLight light = LightAbove(3, 0.6);
  GlbMesh box;
  AddTurnedBox(box, {-0.25, -0.3, -0.15}, {0.25, 0.3, 0.15}, 0, 24);
  std::vector<glm::dmat4> places;
  for (int i = 0; i < 80; ++i) places.push_back(glm::translate(glm::dmat4(1), {20.0 + i, 1.0, 0.0}));
  places[40] = glm::scale(glm::translate(glm::dmat4(1), {0.0, 1.2, 0.0}), {1.0, 0.0, 1.0});
  const auto instances = Build(Form::kShapes, At(MakeFlatScene({box}), places), light);
  ASSERT_EQ(instances->tree.instances.size(), places.size() - 1);
  const std::vector<glm::vec3> points = GroundPoints(64, 2);
  const Resolved resolved = ResolveTree(instances->tree, {}, light, OnGround(points), 64);
  for (size_t i = 0; i < points.size(); ++i) {
    const double truth =
        1 - VisibilityBehindPlate({0.3, 0.3}, {0, 0, 1.8}, {0.25, 0.15}, {points[i].x, points[i].z, 3});
    ASSERT_NEAR(resolved.hidden[i], truth, 0.01);
  }
}

// What is nearer than a level allows is drawn from the mesh, the rest from the level: within what that may show (0.24
// of a row), and a sample more or less.
TEST(MeshShapeTest, TheLevelsOfADenseMeshSavePolygonsAndShowLittle) {
  const AreaLight light = LightAbove(3, 0.6);
  const FlatScene scene = At(Potato(71), Scattered(30, 0.2, {1.5, 0.7, 1.5}, 1.1));
  const auto whole = Build(Form::kShapes, scene, light), simple = Build(Form::kShapesWithLevels, scene, light);
  ASSERT_EQ(whole->tree.instances.size(), 30u);
  ASSERT_EQ(simple->tree.instances.size(), 30u);
  ASSERT_GT(simple->tree.instances[0].shape->roots.size(), 1u);
  const CpuReceivers receivers = OnGround(GroundPoints(96, 3));
  const int rows = 16;
  const Resolved expected = ResolveTree(whole->tree, {}, light, receivers, rows);
  const Resolved resolved = ResolveTree(simple->tree, {}, light, receivers, rows);
  double largest = 0, mean = 0;
  for (size_t i = 0; i < receivers.size(); ++i) {
    const double difference = std::abs(double(resolved.hidden[i]) - double(expected.hidden[i]));
    largest = std::max(largest, difference);
    mean += difference / double(receivers.size());
  }
  const double drawn = double(resolved.drawn) / double(expected.drawn);
  std::printf("levels show %.6f, %.6f at most; polygons %.2f of those without\n", mean, largest, drawn);
  EXPECT_GT(mean, 0);
  EXPECT_LT(largest, (0.24 + 0.4) / rows);
  EXPECT_LT(drawn, 0.6);
}

TEST(MeshShapeTest, AThousandInstancesOfTwentyThousandTrianglesTakeAFewMegabytes) {
  const AreaLight light = LightAbove(3, 0.6);
  const FlatScene mesh = Potato(71);
  EXPECT_EQ(mesh.meshes[0].TriangleCount(), 19880u);
  const FlatScene scene = At(mesh, Scattered(1000, 0.06, {2.5, 0.7, 2.5}, 1.1));
  const auto instances = Build(Form::kShapesWithLevels, scene, light);
  ASSERT_EQ(instances->tree.instances.size(), 1000u);
  constexpr int kCopies = 20;
  const auto copies = Build(Form::kCopies, At(mesh, Scattered(kCopies, 0.06, {2.5, 0.7, 2.5}, 1.1)), light);
  const double instance_bytes = double(instances->tree.SizeBytes()) / 1000;
  const double copy_bytes = double(copies->tree.SizeBytes()) / kCopies;
  std::printf("the shape: %.2f MB, %.3f CPU-s; for a light %.0f bytes and %.1f us an instance\n",
              double(instances->shapes.SizeBytes()) / 1e6, instances->shape_cpu_s, instance_bytes,
              1e3 * instances->light_cpu_s);
  std::printf("a copy: %.2f MB, %.4f CPU-s, so 1000 of them %.0f MB, %.1f CPU-s\n", copy_bytes / 1e6,
              copies->light_cpu_s / kCopies, copy_bytes / 1e3, 1000 * copies->light_cpu_s / kCopies);
  EXPECT_LT(instances->shapes.SizeBytes(), 4u << 20);
  EXPECT_LT(instance_bytes, 512);
  EXPECT_GT(copy_bytes, 1e6);
}

}  // namespace
}  // namespace halfshade
