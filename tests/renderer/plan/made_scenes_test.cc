// The scenes of tests/support: well formed, lit and framed so that there is something to see.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <tuple>

#include "renderer/plan/frame_plan.h"
#include "tests/support/flat_scene_builder.h"
#include "tests/support/scene_classes.h"
#include "tests/support/scene_makers.h"

namespace halfshade {
namespace {

// The large classes in a small form.
MadeScene MakeSmall(const std::string& name, uint32_t seed = 0) { return MakeScene(name, {20000, seed, 0}); }

size_t CountTriangles(const MadeScene& scene) {
  size_t count = 0;
  for (const GlbMesh& mesh : scene.meshes) count += mesh.indices.size() / 3;
  return count;
}

// Edges that no neighbour walks the other way, vertices welded by position.
size_t CountOpenEdges(const GlbMesh& mesh) {
  using Key = std::tuple<float, float, float>;
  std::map<Key, uint32_t> welded;
  const auto weld = [&](uint32_t index) {
    const glm::vec3& p = mesh.positions[index];
    return welded.try_emplace(Key(p.x, p.y, p.z), uint32_t(welded.size())).first->second;
  };
  std::map<std::pair<uint32_t, uint32_t>, int> edges;
  for (size_t i = 0; i < mesh.indices.size(); i += 3) {
    const std::array<uint32_t, 3> corners = {weld(mesh.indices[i]), weld(mesh.indices[i + 1]),
                                             weld(mesh.indices[i + 2])};
    for (size_t j = 0; j < 3; ++j) {
      ++edges[{corners[j], corners[(j + 1) % 3]}];
      --edges[{corners[(j + 1) % 3], corners[j]}];
    }
  }
  return size_t(std::count_if(edges.begin(), edges.end(), [](const auto& edge) { return edge.second != 0; }));
}

// Vertices in the world, moving nodes where they are at a time.
std::vector<glm::dvec3> PointsAt(const MadeScene& scene, double time_s) {
  std::vector<glm::dmat4> places;
  for (const GlbMesh& mesh : scene.meshes) places.push_back(mesh.world_from_mesh);
  for (const NodeOverride& change : OverridesAt(scene, time_s)) places[change.node] = *change.local;
  std::vector<glm::dvec3> points;
  for (size_t i = 0; i < places.size(); ++i) {
    for (const glm::vec3& p : scene.meshes[i].positions) {
      points.emplace_back(places[i] * glm::dvec4(glm::dvec3(p), 1));
    }
  }
  return points;
}

constexpr double kTimes[] = {0, 0.9, 1.7, 2.6, 3.5};  // seconds

class MadeSceneTest : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Scenes, MadeSceneTest, testing::ValuesIn(SceneNames()),
                         [](const auto& tested) { return tested.param; });

TEST_P(MadeSceneTest, IsWellFormedAndStandsOnItsGround) {
  const MadeScene scene = MakeSmall(GetParam());
  for (const GlbMesh& mesh : scene.meshes) {
    ASSERT_EQ(mesh.normals.size(), mesh.positions.size());
    ASSERT_EQ(mesh.indices.size() % 3, 0u);
    ASSERT_LT(*std::max_element(mesh.indices.begin(), mesh.indices.end()), mesh.positions.size());
    for (const glm::vec3& n : mesh.normals) ASSERT_NEAR(glm::length(n), 1, 1e-5);
  }
  for (const double time_s : kTimes) {
    for (const glm::dvec3& p : PointsAt(scene, time_s)) {
      ASSERT_TRUE(std::isfinite(p.x) && std::isfinite(p.z));
      ASSERT_GE(p.y, scene.ground_height_m);
    }
  }
}

TEST_P(MadeSceneTest, ItsShadowIsComputedAndItsOccludersAreInView) {
  const MadeScene scene = MakeSmall(GetParam());
  RenderRequest request = RequestFor(scene);
  request.outputs = {OutputKind::kVisibility};
  const FlatScene flat = MakeFlatScene(scene.meshes);
  const FramePlan plan = PlanFrame(flat, *BuildPose(flat, 0), request);
  EXPECT_TRUE(plan.draws_gbuffer);
  EXPECT_EQ(plan.lights[0].outcome, LightOutcome::kCompute);
  const Camera& camera = request.camera;
  const double aspect = double(request.width) / request.height;
  for (const double time_s : kTimes) {
    for (const glm::dvec3& p : PointsAt(scene, time_s)) {
      const glm::dvec3 v = p - camera.eye_ws;
      const double reach = glm::dot(v, camera.forward_ws) * camera.tan_half_fovy;
      ASSERT_GT(reach, camera.near_m * camera.tan_half_fovy);
      ASSERT_LT(std::abs(glm::dot(v, camera.right_ws)), reach * aspect) << time_s;
      ASSERT_LT(std::abs(glm::dot(v, camera.up_ws)), reach) << time_s;
    }
  }
}

TEST_P(MadeSceneTest, ItsLightHasAFrame) {
  const AreaLight light = RequestFor(MakeSmall(GetParam())).lights[0];
  const glm::dmat3 axes(light.axis_u_ws, light.axis_v_ws, light.normal_ws);
  EXPECT_NEAR(glm::determinant(axes), 1, 1e-12) << "orthonormal and right-handed, straight down too";
  EXPECT_NEAR(glm::dot(light.axis_u_ws, light.normal_ws), 0, 1e-12);
  EXPECT_NEAR(glm::length(light.axis_u_ws), 1, 1e-12);
}

TEST_P(MadeSceneTest, TheSameOptionsGiveTheSameBytesAndTheLightFollowsItsShare) {
  const MadeScene scene = MakeSmall(GetParam());
  EXPECT_EQ(WriteGlb(scene.meshes), WriteGlb(MakeSmall(GetParam()).meshes));
  const bool is_random = GetParam() == "S5" || GetParam() == "S6" || GetParam() == "S7" || GetParam() == "plant";
  EXPECT_EQ(WriteGlb(scene.meshes) != WriteGlb(MakeSmall(GetParam(), 1).meshes), is_random);
  const MadeScene lit = MakeScene(GetParam(), {20000, 0, 0.5});
  EXPECT_EQ(lit.light_edge_m, 0.5 * OccluderExtent(scene));
}

class SceneClassTest : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Classes, SceneClassTest, testing::ValuesIn(SceneClassNames()),
                         [](const auto& tested) { return tested.param; });

TEST_P(SceneClassTest, HasAboutAsManyTrianglesAsAsked) {
  for (const uint32_t triangles : {1000u, 20000u, 100000u}) {
    const double count = double(CountTriangles(MakeScene(GetParam(), {triangles, 0, 0})));
    EXPECT_NEAR(count / triangles, 1, 0.15) << triangles;
  }
}

TEST(SceneClassesTest, TheSolidsAreClosedAndTheSheetsAreNot) {
  for (const char* name : {"S2", "S3", "S6", "S7", "S8"})
    EXPECT_EQ(CountOpenEdges(MakeSmall(name).meshes[0]), 0u) << name;
  for (const char* name : {"S1", "S4"}) EXPECT_GT(CountOpenEdges(MakeSmall(name).meshes[0]), 0u) << name;
}

TEST(SceneClassesTest, TheSolidsFaceOutward) {
  for (const char* name : {"S2", "S3", "S6", "S7", "S8"}) {
    const GlbMesh mesh = MakeSmall(name).meshes[0];
    double volume = 0;
    for (size_t i = 0; i < mesh.indices.size(); i += 3) {
      const glm::dvec3 a(mesh.positions[mesh.indices[i]]), b(mesh.positions[mesh.indices[i + 1]]),
          c(mesh.positions[mesh.indices[i + 2]]);
      volume += glm::dot(a, glm::cross(b, c)) / 6;
      const glm::dvec3 normal = glm::cross(b - a, c - a);
      ASSERT_GT(glm::dot(normal, glm::dvec3(mesh.normals[mesh.indices[i]])), 0) << name << " " << i / 3;
    }
    EXPECT_GT(volume, 0.05) << name;
  }
}

TEST(SceneClassesTest, OwnNumbersOfTriangles) {
  const std::map<std::string, size_t> own = {{"S1", 2}, {"S3", 12}, {"S4", 2}, {"S5", 6000}};
  for (const auto& [name, triangles] : own) EXPECT_EQ(CountTriangles(MakeScene(name)), triangles);
  EXPECT_NEAR(double(CountTriangles(MakeScene("S6"))), 229e3, 1e3);
  EXPECT_NEAR(double(CountTriangles(MakeScene("S7"))), 1e6, 5e4);
}

TEST(MovingReceiversTest, MoveAsRigidNamedNodesThatCastNothingAndComeBack) {
  const MadeScene scene = MakeSmall("S8");
  const FlatScene flat = MakeFlatScene(scene.meshes);
  ASSERT_EQ(scene.moving.size(), 2u);
  EXPECT_EQ(flat.nodes[scene.moving[0].mesh].name, "ball");
  EXPECT_EQ(flat.nodes[scene.moving[1].mesh].name, "vane");
  for (size_t i = 0; i < scene.moving.size(); ++i) {
    const MovingNode& node = scene.moving[i];
    EXPECT_EQ(node.world_from_mesh(0), scene.meshes[node.mesh].world_from_mesh) << "the file has the pose at 0";
    EXPECT_NE(node.world_from_mesh(0.3 * node.period_s), node.world_from_mesh(0));
    const glm::dmat4 difference = node.world_from_mesh(node.period_s) - node.world_from_mesh(0);
    const glm::dmat3 linear(node.world_from_mesh(0.3 * node.period_s));
    EXPECT_NEAR(glm::determinant(linear), 1, 1e-12);
    for (int column = 0; column < 4; ++column) EXPECT_LT(glm::length(difference[column]), 1e-12);
    const NodeOverride change = OverridesAt(scene, 1)[i];
    EXPECT_EQ(change.node, node.mesh);
    EXPECT_EQ(*change.local, node.world_from_mesh(1));
    EXPECT_FALSE(change.casts);
    EXPECT_TRUE(change.is_visible && change.receives);
  }
}

TEST(MovingReceiversTest, TheOccludersStayAndTheReceiversMove) {
  const MadeScene scene = MakeSmall("S8");
  const FlatScene flat = MakeFlatScene(scene.meshes);
  const auto first = BuildPose(flat, 0, OverridesAt(scene, 0)), later = BuildPose(flat, 0, OverridesAt(scene, 1));
  ASSERT_EQ(first->instances.size(), 3u);
  for (size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(first->instances[i].casts, i == 0);
    EXPECT_EQ(first->instances[i].world_from_mesh == later->instances[i].world_from_mesh, i == 0);
  }
  EXPECT_NEAR(OccluderExtent(scene), 1.8, 1e-6) << "of the pergola, wherever the others are";
}

TEST(MovingReceiversTest, AloneAreInFogAndWithMotion) {
  for (const std::string& name : SceneNames()) {
    const MadeScene scene = MakeSmall(name);
    EXPECT_EQ(scene.fog.has_value(), name == "S8");
    EXPECT_EQ(scene.moving.empty(), name != "S8");
    EXPECT_TRUE(OverridesAt(scene, 1).empty() || name == "S8");
  }
  const MadeFog fog = *MakeSmall("S8").fog;
  EXPECT_GT(fog.density_per_m, 0);
  for (int c = 0; c < 3; ++c) EXPECT_TRUE(fog.albedo[c] >= 0 && fog.albedo[c] <= 1);
}

TEST(MovingReceiversTest, APoseFileNamesNodesAndTheirMatricesByColumn) {
  const MadeScene scene = MakeSmall("S8");
  const nlohmann::json pose = nlohmann::json::parse(PoseFileText(scene, 1));
  ASSERT_EQ(pose["nodeOverrides"].size(), 2u);
  EXPECT_EQ(pose["nodeOverrides"][0]["name"], "ball");
  EXPECT_EQ(pose["nodeOverrides"][0]["casts"], false);
  // A quarter of its round: from +x to +z.
  const std::vector<double> transform = pose["nodeOverrides"][0]["transform"];
  ASSERT_EQ(transform.size(), 16u);
  EXPECT_NEAR(transform[12], 0, 1e-12);
  EXPECT_EQ(transform[13], 0.3);
  EXPECT_NEAR(transform[14], 0.35, 1e-12);
  EXPECT_EQ(transform[15], 1);
}

}  // namespace
}  // namespace halfshade
