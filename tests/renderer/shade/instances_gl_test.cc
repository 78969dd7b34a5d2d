// What stands in many places is drawn as so many copies of it would be: the same bytes, the same triangles left out.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "renderer/scene/pose.h"
#include "tests/support/flat_scene_builder.h"
#include "tests/support/render_fixture.h"

namespace halfshade {
namespace {

// The same picture three times over: places of one node, nodes that share its meshes, nodes with meshes of their own.
struct Scenes {
  FlatScene places, nodes, copies;
};

// Boxes, each with a ball on it (of several clusters, where `rings` are many); turned, scaled and every fifth mirrored.
Scenes Scatter(uint32_t count, int rings) {
  const std::vector<GlbMesh> parts = {MakeBox({0, 0, 0}, {1, 1, 1}), MakeSphere({0, 1, 0}, 0.5, rings)};
  Scenes scenes;
  FlatScene& places = scenes.places = MakeFlatScene(parts);
  places.scenes[0].roots = {0};
  places.nodes.resize(1);
  Node& node = places.nodes[0];
  node.mesh_count = uint32_t(parts.size());
  node.place_count = count;
  std::mt19937 random(1);
  const auto uniform = [&](float low, float high) { return std::uniform_real_distribution<float>(low, high)(random); };
  const float size = 3 / std::sqrt(float(count));
  for (uint32_t i = 0; i < count; ++i) {
    InstancePlace place;
    place.translation = {uniform(-3, 3), uniform(0, 1), uniform(-3, 3)};
    place.rotation = glm::normalize(glm::quat(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)));
    place.scale = size * glm::vec3(uniform(0.3f, 1), uniform(0.3f, 1), i % 5 == 0 ? -1 : 1);
    places.places.push_back(place);
  }
  scenes.nodes = places;
  scenes.nodes.places.clear();
  scenes.nodes.nodes.clear();
  scenes.nodes.scenes[0].roots.clear();
  scenes.copies = scenes.nodes;
  scenes.copies.meshes.clear();
  for (uint32_t i = 0; i < count; ++i) {
    Node at_place;
    at_place.local = WorldFromPlace(places, node, i, glm::dmat4(1));
    at_place.mesh_count = node.mesh_count;
    for (FlatScene* scene : {&scenes.nodes, &scenes.copies}) {
      at_place.first_mesh = uint32_t(scene == &scenes.copies ? scene->meshes.size() : 0);
      scene->scenes[0].roots.push_back(i);
      scene->nodes.push_back(at_place);
    }
    scenes.copies.meshes.insert(scenes.copies.meshes.end(), places.meshes.begin(), places.meshes.end());
  }
  return scenes;
}

void ExpectSame(const RenderResult& a, const RenderResult& b, size_t images) {
  for (size_t i = 0; i < images; ++i) {
    const Image &left = a.images[i].image, &right = b.images[i].image;
    ASSERT_EQ(left.size(), right.size());
    ASSERT_GT(left.size(), 0u);
    EXPECT_TRUE(std::equal(left.data(), left.data() + left.size(), right.data())) << i;
  }
  const auto drawn = [](const RenderResult& result) {
    return *std::find_if(result.report.passes.begin(), result.report.passes.end(),
                         [](const PassReport& pass) { return pass.name == "gbuffer"; });
  };
  EXPECT_EQ(drawn(a).count, drawn(b).count);
  EXPECT_EQ(drawn(a).reason, drawn(b).reason);
  EXPECT_NE(drawn(a).reason, "") << "some stand out of view";
}

RenderResult Render(const FlatScene& scene, const RenderRequest& request) {
  auto result = TestRenderer().Render("instances", scene, request, [] { return absl::OkStatus(); });
  TestRenderer().ForgetScene("instances");
  EXPECT_OK(result);
  return result.ok() ? *std::move(result) : RenderResult();
}

TEST(InstancesTest, AreDrawnAsTheirCopiesWouldBe) {
  RenderRequest request;
  request.width = 160;
  request.height = 120;
  request.camera = LookFrom({2, 2.5, 3}, {0.5, 0, 0.5});
  request.lights = {LightAbove(4, 0.5)};
  request.ground = Ground{-0.5, 20, false};
  request.method = HardOptions{};
  request.outputs = {OutputKind::kFrame, OutputKind::kVisibility, OutputKind::kDepth, OutputKind::kNormal,
                     OutputKind::kObjectId};
  // Few of many triangles, and more than are held at a time.
  for (const auto& [count, rings] : {std::pair{60u, 20}, std::pair{20'000u, 2}}) {
    const Scenes scenes = Scatter(count, rings);
    const RenderResult copies = Render(scenes.copies, request);
    ExpectSame(Render(scenes.nodes, request), copies, request.outputs.size());
    ExpectSame(Render(scenes.places, request), copies, request.outputs.size() - 1);  // they are one object
  }
}

}  // namespace
}  // namespace halfshade
