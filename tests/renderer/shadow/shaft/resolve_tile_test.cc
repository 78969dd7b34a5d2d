#include "renderer/shadow/shaft/resolve_tile.h"

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>
#include <string>

#include "renderer/light/cpu_occluders.h"
#include "renderer/light/trace_light.h"
#include "renderer/math/light_frame.h"
#include "renderer/scene/pose.h"
#include "tests/renderer/shadow/shaft/resolve_points.h"
#include "tests/support/closed_forms.h"
#include "tests/support/flat_scene_builder.h"
#include "tests/support/mesh_parts.h"
#include "tests/support/render_fixture.h"

namespace halfshade {
namespace {

// The image of every mask: 8 x 8 texels, a half of them holes.
absl::StatusOr<Rgba8Image> DecodeHoles(const EncodedImage&) {
  Rgba8Image image{8, 8, std::vector<uint8_t>(256, 255)};
  for (size_t i = 0; i < 64; ++i) image.texels[4 * i + 3] = (i / 8 + i) % 2 == 0 ? 255 : 0;
  return image;
}

// Seen from a light at height 3 that shines down.
Resolved ResolvePoints(const FlatScene& scene, const AreaLight& light, const CpuReceivers& receivers, int rows,
                       uint32_t seed = 0, const MeshShapes* kept = nullptr) {
  MeshShapes none;
  none.kept_meshes.resize(scene.meshes.size(), kNotKept);
  const MeshShapes& shapes = kept != nullptr ? *kept : none;
  const CpuOccluders occluders =
      *BuildCpuOccluders(scene, *BuildPose(scene, 0), shapes.kept_meshes, light, &DecodeHoles);
  const PolygonTree tree = BuildPolygonTree(occluders, shapes.shapes, light);
  return ResolveTree(tree, occluders.masks, light, receivers, rows, seed);
}

class RowsTest : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Rows, RowsTest, testing::Values(4, 8, 16, 32, 64));

// An edge across the rows is met to a fraction of a sample in each, and those of R rows add up to what van der Corput's
// shifts miss of an arc: 2 (log2(R) / 3 + 1). An edge along them cuts as many rows as they lean, together to a sample.
// There are two of each.
TEST_P(RowsTest, BehindAPlateTheTrapezoidsAreMetToAFewSamples) {
  const int rows = GetParam();
  const double bound = (4 * (std::log2(rows) / 3 + 1) + 2) / (32 * rows);
  const AreaLight light = LightAbove(3, 0.6);
  const FlatScene scene = MakeFlatScene({MakePlate({0, 1.2, 0}, 0.5, 0.3)});
  const std::vector<glm::vec3> points = GroundPoints(64, 2);
  const Resolved resolved = ResolvePoints(scene, light, OnGround(points), rows);
  double largest = 0, mean = 0;
  for (size_t i = 0; i < points.size(); ++i) {
    const double truth =
        1 - VisibilityBehindPlate({0.3, 0.3}, {0, 0, 1.8}, {0.25, 0.15}, {points[i].x, points[i].z, 3});
    const double error = std::abs(resolved.hidden[i] - truth);
    largest = std::max(largest, error);
    mean += error / double(points.size());
  }
  std::printf("%d rows: mean %.6f, largest %.5f, bound %.5f\n", rows, mean, largest, bound);
  EXPECT_LE(largest, bound);
  EXPECT_LE(mean, 0.5 / (32 * rows));  // they rarely add up
}

TEST(ResolveTileTest, BehindABoxAndABoxTurnedInsideOutIsItsSilhouette) {
  const AreaLight light = LightAbove(3, 0.6);
  const std::vector<glm::vec3> points = GroundPoints(48, 2);
  GlbMesh box = MakeBox({0.1, 1, -0.1}, {0.3, 0.6, 0.4});
  for (const bool is_turned : {false, true}) {
    if (is_turned) std::reverse(box.indices.begin(), box.indices.end());
    const Resolved resolved = ResolvePoints(MakeFlatScene({box}), light, OnGround(points), 64);
    double largest = 0;
    for (size_t i = 0; i < points.size(); ++i) {
      // The light's y is the world's z.
      const double truth =
          1 - VisibilityBehindBox({0.3, 0.3}, {-0.05, -0.3, 1.7}, {0.25, 0.1, 2.3}, {points[i].x, points[i].z, 3});
      largest = std::max(largest, std::abs(resolved.hidden[i] - truth));
    }
    EXPECT_LE(largest, 0.01) << "turned: " << is_turned;
  }
}

// Two plates that overlap on the light, edge to edge and one over the other: what both hide counts once.
TEST(ResolveTileTest, WhatTwoPlatesHideIsTheirUnionToTheBit) {
  const AreaLight light = LightAbove(3, 0.6);
  const std::vector<glm::vec3> points = GroundPoints(48, 2);
  const CpuReceivers receivers = OnGround(points);
  const FlatScene whole = MakeFlatScene({MakePlate({0, 1, 0}, 1, 0.4)});
  const FlatScene halves = MakeFlatScene({MakePlate({-0.25, 1, 0}, 0.5, 0.4), MakePlate({0.25, 1, 0}, 0.5, 0.4)});
  const FlatScene over = MakeFlatScene(
      {MakePlate({-0.1, 1, 0}, 0.8, 0.4), MakePlate({0.1, 1, 0}, 0.8, 0.4), MakePlate({0, 1, 0}, 1, 0.4)});
  const std::vector<float> expected = ResolvePoints(whole, light, receivers, 16).hidden;
  EXPECT_EQ(ResolvePoints(halves, light, receivers, 16).hidden, expected);
  EXPECT_EQ(ResolvePoints(over, light, receivers, 16).hidden, expected);
}

std::vector<GlbMesh> Clutter() {
  std::mt19937 random(5);
  const auto uniform = [&](double low, double high) { return low + (high - low) * double(random()) / 4294967296.0; };
  std::vector<GlbMesh> meshes = {MakeSphere({0.2, 0.8, 0.1}, 0.3, 12), MakeBox({-0.5, 0.3, 0}, {0.3, 0.6, 0.3})};
  for (int i = 0; i < 60; ++i) {
    meshes.push_back(MakeSquare({uniform(-1, 1), uniform(0.1, 3.4), uniform(-1, 1)}, 0.2, uniform(-1.5, 1.5)));
  }
  return meshes;
}

// Every third of them full of holes.
FlatScene ClutterWithMasks() {
  std::vector<GlbMesh> meshes = Clutter();
  for (GlbMesh& mesh : meshes) {
    for (size_t i = 0; i < mesh.positions.size(); ++i) mesh.texcoords.emplace_back(i % 2 == 0 ? 0 : 1, i / 2 % 2);
  }
  FlatScene scene = MakeFlatScene(meshes);
  scene.images.emplace_back();
  scene.textures.emplace_back();
  for (size_t i = 0; i < scene.materials.size(); i += 3) {
    scene.materials[i].alpha_mode = AlphaMode::kMask;
    scene.materials[i].base_color_texture.texture = 0;
  }
  return scene;
}

TEST(ResolveTileTest, TheBytesAreTheSameOnEveryInstructionSet) {
  const FlatScene scene = ClutterWithMasks();
  const AreaLight light = LightAbove(3, 0.7);
  const CpuReceivers receivers = OnGround(GroundPoints(64, 3));
  const CpuReceivers loose = MakePointReceivers(GroundPoints(64, 3), {});
  std::vector<std::vector<float>> results;
  std::string names;
  for (const int64_t target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    names.append(" ").append(hwy::TargetName(target));
    std::vector<float>& hidden = results.emplace_back(ResolvePoints(scene, light, receivers, 16).hidden);
    const std::vector<float> more = ResolvePoints(scene, light, loose, 8).hidden;
    hidden.insert(hidden.end(), more.begin(), more.end());
  }
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  std::printf("the same on:%s\n", names.c_str());
  RecordProperty("instruction_sets", names);
  EXPECT_GT(results.size(), 1u) << "nothing to compare on this machine";
  for (const std::vector<float>& hidden : results) {
    EXPECT_EQ(std::memcmp(hidden.data(), results[0].data(), hidden.size() * sizeof(float)), 0);
  }
}

// In clutter that stands around, through and behind the light, from points with and without planes. `factor`: of
// ExpectedTraceError, for a straight edge, or for one that holes make many of.
void ExpectWhatRaysSay(const FlatScene& scene, double factor) {
  const auto rays = RayScene::Create(scene, *BuildPose(scene, 0), &DecodeHoles);
  ASSERT_OK(rays);
  for (const double size : {0.0, 0.05, 0.7}) {
    const AreaLight light = LightAbove(3, size);
    const std::vector<glm::vec3> points = GroundPoints(32, 3);
    for (const CpuReceivers& receivers : {OnGround(points), MakePointReceivers(points, {})}) {
      const auto traced =
          TraceLight(**rays, light, receivers, {.rays = 4096, .seed = 3}, [] { return absl::OkStatus(); });
      ASSERT_OK(traced);
      const Resolved resolved = ResolvePoints(scene, light, receivers, 64);
      double mean = 0;
      for (size_t i = 0; i < points.size(); ++i) mean += std::abs(resolved.hidden[i] - traced->hidden[i]) / 1024;
      std::printf("light %.2f: mean difference from rays %.5f\n", size, mean);
      // 2048 and 4096 samples: factor sqrt(v (1 - v)) k^-.75 of each, at v = 1/2; of a point rays and polygons may
      // only disagree at silhouettes.
      EXPECT_LE(mean, size == 0 ? 2.0 / 1024 : 0.5 * factor * (std::pow(2048, -0.75) + std::pow(4096, -0.75)));
    }
  }
}
TEST(ResolveTileTest, WhatIsHiddenIsWhatRaysSay) { ExpectWhatRaysSay(MakeFlatScene(Clutter()), 0.7); }
TEST(ResolveTileTest, WhatMasksHideIsWhatRaysSay) { ExpectWhatRaysSay(ClutterWithMasks(), 1); }

TEST(ResolveTileTest, WithoutAPolygonInTheShaftNothingIsDrawn) {
  const FlatScene scene = MakeFlatScene({MakePlate({0, 5, 0}, 4, 4), MakePlate({0, -1, 0}, 4, 4)});
  const Resolved resolved = ResolvePoints(scene, LightAbove(3, 0.6), OnGround(GroundPoints(16, 2)), 16);
  EXPECT_EQ(resolved.drawn, 0u);
  for (const float hidden : resolved.hidden) EXPECT_EQ(hidden, 0);
}

TEST(ResolveTileTest, UnderAFullOccluderAllIsHiddenAndTheListIsNotDrawnToItsEnd) {
  std::vector<GlbMesh> plates;
  for (int i = 0; i < 100; ++i) plates.push_back(MakePlate({0, 1 + 0.01 * i, 0}, 20, 20));
  const Resolved resolved = ResolvePoints(MakeFlatScene(plates), LightAbove(3, 0.6), OnGround(GroundPoints(16, 2)), 16);
  for (const float hidden : resolved.hidden) EXPECT_EQ(hidden, 1);
  EXPECT_LE(resolved.drawn, 16u * 4);  // 16 blocks, asked every fourth polygon
}

// The ground, and the upper side of a ball that stands in its own way.
CpuReceivers GroundAndBall() {
  std::vector<glm::vec3> points = GroundPoints(96, 3), normals(points.size(), {0, 1, 0});
  for (int i = 0; i < 2048; ++i) {
    const double height = (i + 0.5) / 2048, around = 2.399963 * i, out = std::sqrt(1 - height * height);
    const glm::dvec3 direction(out * std::cos(around), height, out * std::sin(around));
    points.emplace_back(glm::dvec3(0, 0.8, 0) + 0.5 * direction);
    normals.emplace_back(direction);
  }
  return MakePointReceivers(points, normals);
}

FlatScene DenseBall() {
  GlbMesh ball;
  AddStarSolid(ball, {0, 0.8, 0}, 160, [](const glm::dvec3&) { return 0.5; });
  return MakeFlatScene({ball});
}

// A ball of 100 k triangles: its levels take a good part of the polygons away and show by less than the samples miss.
TEST(ResolveTileTest, LevelsOfADenseMeshSavePolygonsAndShowLessThanTheSamplesMiss) {
  const FlatScene scene = DenseBall();
  const MeshShapes shapes = *BuildMeshShapes(scene, [] { return absl::OkStatus(); });
  ASSERT_GT(shapes.shapes[0].roots.size(), 1u);
  const CpuReceivers receivers = GroundAndBall();
  const AreaLight light = LightAbove(3, 0.6);
  const Resolved truth = ResolvePoints(scene, light, receivers, 64, 9);
  for (const int rows : {8, 16, 64}) {
    const Resolved whole = ResolvePoints(scene, light, receivers, rows);
    const Resolved simple = ResolvePoints(scene, light, receivers, rows, 0, &shapes);
    double error = 0, simple_error = 0, largest = 0;
    for (size_t i = 0; i < truth.hidden.size(); ++i) {
      error += std::abs(whole.hidden[i] - truth.hidden[i]);
      simple_error += std::abs(simple.hidden[i] - truth.hidden[i]);
      largest = std::max(largest, double(std::abs(simple.hidden[i] - whole.hidden[i])));
    }
    std::printf("%d rows: polygons %.2f, error %.2f of those without levels, largest difference %.4f\n", rows,
                double(simple.drawn) / double(whole.drawn), simple_error / error, largest);
    // The mesh itself is drawn as quads, its levels as triangles.
    EXPECT_LT(double(simple.drawn), (rows == 8 ? 0.62 : rows == 16 ? 0.73 : 0.95) * double(whole.drawn));
    EXPECT_LT(simple_error, 1.2 * error);
    // What a level may show, where it is not that a sample more or less is hidden; so nothing shines between two.
    EXPECT_LT(largest, (0.24 + 0.4) / rows);
  }
}

TEST(ResolveTileTest, UnderAPointLightADenseMeshIsDrawnAsItIs) {
  const FlatScene scene = DenseBall();
  const MeshShapes shapes = *BuildMeshShapes(scene, [] { return absl::OkStatus(); });
  const CpuReceivers receivers = GroundAndBall();
  const AreaLight light = LightAbove(3, 0);
  EXPECT_EQ(ResolvePoints(scene, light, receivers, 16, 0, &shapes).hidden,
            ResolvePoints(scene, light, receivers, 16).hidden);
}

// Rows against rows: within 2x of the truth, as a quarter of it.
TEST(ResolveTileTest, AQuarterOfTheRowsDisagreementIsTheErrorWithinAFactorOfTwo) {
  const FlatScene scene = MakeFlatScene(Clutter());
  const AreaLight light = LightAbove(3, 0.7);
  const CpuReceivers receivers = OnGround(GroundPoints(64, 3));
  const std::vector<float> truth = ResolvePoints(scene, light, receivers, 64, 9).hidden;
  for (const int rows : {8, 16}) {
    const Resolved resolved = ResolvePoints(scene, light, receivers, rows);
    double error = 0;
    for (size_t i = 0; i < truth.size(); ++i) error += std::abs(resolved.hidden[i] - truth[i]) / double(truth.size());
    const double predicted = 0.25 * resolved.disagreement;
    std::printf("%d rows: error %.5f, predicted %.5f\n", rows, error, predicted);
    EXPECT_GT(predicted, error / 2);
    EXPECT_LT(predicted, error * 2);
  }
}

}  // namespace
}  // namespace halfshade
