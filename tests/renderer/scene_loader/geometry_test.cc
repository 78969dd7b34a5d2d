#include <gtest/gtest.h>

#include "renderer/scene/pose.h"
#include "renderer/scene_loader/scene_loader.h"
#include "tests/renderer/scene_loader/gltf_builder.h"
#include "tests/support/status_matchers.h"

namespace halfshade {
namespace {

using testing::ElementsAre;

const std::vector<float> kSquare = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};

TEST(GeometryTest, EveryTypeOfIndexNamesTheSameTriangles) {
  const auto load = [](auto type, int component) {
    GltfBuilder gltf;
    gltf.primitive()["attributes"]["POSITION"] = gltf.Accessor(kSquare, "VEC3", 5126);
    gltf.primitive()["indices"] = gltf.Accessor<decltype(type)>({0, 1, 2, 0, 2, 3}, "SCALAR", component);
    const auto scene = gltf.Load();
    EXPECT_OK(scene);
    return scene.ok() ? scene->indices : std::vector<uint32_t>();
  };
  const std::vector<uint32_t> expected = {0, 1, 2, 0, 2, 3};
  EXPECT_EQ(load(uint8_t(), 5121), expected);
  EXPECT_EQ(load(uint16_t(), 5123), expected);
  EXPECT_EQ(load(uint32_t(), 5125), expected);
}

TEST(GeometryTest, EveryTypeOfTexcoordMeansTheSame) {
  const auto load = [](auto values, int component) {
    GltfBuilder gltf = GltfBuilder::Triangle();
    values.resize(values.size());
    const bool is_float = component == 5126;
    // Two components of a byte or short need padding to four bytes per element.
    const size_t accessor = gltf.Accessor(values, "VEC2", component, !is_float);
    gltf.json["accessors"][accessor]["count"] = 3;
    if (component == 5121) {
      gltf.json["bufferViews"].back()["byteStride"] = 4;
    }
    gltf.primitive()["attributes"]["TEXCOORD_0"] = accessor;
    const auto scene = gltf.Load();
    EXPECT_OK(scene);
    return scene.ok() ? scene->texcoords : std::vector<glm::vec2>();
  };
  const std::vector<glm::vec2> expected = {{0, 0}, {1, 0}, {0, 1}};
  EXPECT_EQ(load(std::vector<float>{0, 0, 1, 0, 0, 1}, 5126), expected);
  EXPECT_EQ(load(std::vector<uint8_t>{0, 0, 9, 9, 255, 0, 9, 9, 0, 255, 9, 9}, 5121), expected);
  EXPECT_EQ(load(std::vector<uint16_t>{0, 0, 65535, 0, 0, 65535}, 5123), expected);
}

TEST(GeometryTest, InterleavedVerticesReadWithTheirStride) {
  GltfBuilder gltf = GltfBuilder::Triangle();
  gltf.View<float>({0, 0, 0, 0, 0, 2, 1, 0, 0, 0, 0, 2, 0, 1, 0, 0, 0, 2});
  gltf.json["bufferViews"][2]["byteStride"] = 24;
  const nlohmann::json accessor = {{"bufferView", 2}, {"componentType", 5126}, {"count", 3}, {"type", "VEC3"}};
  gltf.json["accessors"][0] = accessor;
  gltf.json["accessors"].push_back(accessor);
  gltf.json["accessors"][2]["byteOffset"] = 12;
  gltf.primitive()["attributes"]["NORMAL"] = 2;
  const auto scene = gltf.Load();
  ASSERT_OK(scene);
  EXPECT_THAT(Corners(*scene), ElementsAre(glm::dvec3(0), glm::dvec3(1, 0, 0), glm::dvec3(0, 1, 0)));
  EXPECT_EQ(scene->normals, std::vector<glm::vec3>(3, {0, 0, 1})) << "made unit";
}

TEST(GeometryTest, SparseValuesReplaceTheirElements) {
  GltfBuilder gltf = GltfBuilder::Triangle();
  gltf.json["accessors"][0]["sparse"] = {
      {"count", 1},
      {"indices", {{"bufferView", gltf.View<uint16_t>({1})}, {"componentType", 5123}}},
      {"values", {{"bufferView", gltf.View<float>({7, 0, 0})}}}};
  auto scene = gltf.Load();
  ASSERT_OK(scene);
  EXPECT_THAT(Corners(*scene), ElementsAre(glm::dvec3(0), glm::dvec3(7, 0, 0), glm::dvec3(0, 1, 0)));
  gltf.json["accessors"][0].erase("bufferView");
  scene = gltf.Load();
  ASSERT_OK(scene);
  EXPECT_EQ(scene->degenerate_triangles_dropped, 1u) << "over zeros the triangle is a line";
}

TEST(GeometryTest, StripsAndFansKeepTheWinding) {
  const auto load = [](int mode, std::vector<uint8_t> indices) {
    GltfBuilder gltf;
    gltf.primitive()["attributes"]["POSITION"] = gltf.Accessor(kSquare, "VEC3", 5126);
    gltf.primitive()["indices"] = gltf.Accessor(indices, "SCALAR", 5121);
    gltf.primitive()["mode"] = mode;
    const auto scene = gltf.Load();
    EXPECT_OK(scene);
    return scene.ok() ? scene->indices : std::vector<uint32_t>();
  };
  EXPECT_THAT(load(5, {0, 1, 3, 2}), ElementsAre(0, 1, 3, 1, 2, 3));
  EXPECT_THAT(load(6, {0, 1, 2, 3}), ElementsAre(1, 2, 0, 2, 3, 0));
  EXPECT_THAT(load(5, {0, 1}), ElementsAre());
}

TEST(GeometryTest, VerticesWithoutIndicesAreTakenInOrder) {
  GltfBuilder gltf = GltfBuilder::Triangle();
  gltf.primitive().erase("indices");
  const auto scene = gltf.Load();
  ASSERT_OK(scene);
  EXPECT_THAT(scene->indices, ElementsAre(0, 1, 2));
}

TEST(GeometryTest, OnlyUsedVerticesAreKeptAndMeasured) {
  GltfBuilder gltf;
  std::vector<float> positions = {1e6f, 1e6f, 1e6f};
  positions.insert(positions.end(), kSquare.begin(), kSquare.end());
  gltf.primitive()["attributes"]["POSITION"] = gltf.Accessor(positions, "VEC3", 5126);
  gltf.primitive()["indices"] = gltf.Accessor<uint8_t>({4, 1, 3}, "SCALAR", 5121);
  const auto scene = gltf.Load();
  ASSERT_OK(scene);
  EXPECT_EQ(scene->positions.size(), 3u);
  EXPECT_THAT(scene->indices, ElementsAre(2, 0, 1));
  EXPECT_EQ(scene->meshes[0].origin, glm::dvec3(0.5, 0.5, 0));
  EXPECT_EQ(scene->meshes[0].bounds.max, glm::vec3(0.5, 0.5, 0));
}

TEST(GeometryTest, FarGeometryKeepsItsShapeAroundTheOrigin) {
  GltfBuilder gltf = GltfBuilder::Triangle();
  gltf.primitive()["attributes"]["POSITION"] =
      gltf.Accessor<float>({1e7f, 0, 0, 1e7f + 1, 0, 0, 1e7f, 1, 0}, "VEC3", 5126);
  gltf.json["accessors"].back()["min"] = {5, 5, 5};
  gltf.json["accessors"].back()["max"] = {6, 6, 6};
  const auto scene = gltf.Load();
  ASSERT_OK(scene);
  EXPECT_EQ(scene->meshes[0].origin, glm::dvec3(1e7 + 0.5, 0.5, 0)) << "measured, not what the file says";
  EXPECT_EQ(scene->positions[1], glm::vec3(0.5, -0.5, 0));
}

TEST(GeometryTest, TrianglesWithoutAreaAreDroppedAndCounted) {
  GltfBuilder gltf;
  gltf.primitive()["attributes"]["POSITION"] = gltf.Accessor<float>({0, 0, 0, 1, 0, 0, 2, 0, 0, 0, 1, 0}, "VEC3", 5126);
  gltf.primitive()["indices"] = gltf.Accessor<uint8_t>({0, 1, 2, 0, 1, 1, 0, 1, 3}, "SCALAR", 5121);
  const auto scene = gltf.Load();
  ASSERT_OK(scene);
  EXPECT_EQ(scene->degenerate_triangles_dropped, 2u);
  EXPECT_EQ(scene->meshes[0].TriangleCount(), 1u);
  EXPECT_THAT(scene->warnings, ElementsAre("/meshes: triangles without an area are dropped: 2"));
}

TEST(GeometryTest, APrimitiveOfWhichNothingIsLeftMakesNoMesh) {
  GltfBuilder gltf = GltfBuilder::Triangle();
  gltf.primitive()["indices"] = gltf.Accessor<uint8_t>({0, 1, 1}, "SCALAR", 5121);
  const auto scene = gltf.Load();
  ASSERT_OK(scene);
  EXPECT_TRUE(scene->meshes.empty());
  EXPECT_TRUE(BuildPose(*scene, 0)->bounds_ws.IsEmpty());
}

TEST(GeometryTest, ClustersCoverEveryTriangleOnce) {
  GltfBuilder gltf;
  std::vector<float> positions;
  for (int i = 0; i < 600; ++i) {
    const float x = float(i);
    positions.insert(positions.end(), {x, 0, 0, x + 1, 0, 0, x, 1, 0});
  }
  gltf.primitive()["attributes"]["POSITION"] = gltf.Accessor(positions, "VEC3", 5126);
  const auto scene = gltf.Load();
  ASSERT_OK(scene);
  ASSERT_EQ(scene->clusters.size(), 3u);
  uint32_t next = 0;
  for (const Cluster& cluster : scene->clusters) {
    EXPECT_EQ(cluster.first_triangle, next);
    EXPECT_LE(cluster.triangle_count, Cluster::kMaxTriangles);
    EXPECT_EQ(cluster.bounds.min.x + float(scene->meshes[0].origin.x), float(next));
    next += cluster.triangle_count;
    EXPECT_EQ(cluster.bounds.max.x + float(scene->meshes[0].origin.x), float(next));
  }
  EXPECT_EQ(next, 600u);
}

TEST(GeometryTest, AttributesThatNoMaterialAsksForAreNotKept) {
  GltfBuilder gltf = GltfBuilder::Triangle();
  gltf.primitive()["attributes"]["TEXCOORD_1"] = gltf.Accessor<float>({0, 0, 1, 0, 0, 1}, "VEC2", 5126);
  gltf.primitive()["attributes"]["TANGENT"] = gltf.Accessor<float>({1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1}, "VEC4", 5126);
  const auto scene = gltf.Load();
  ASSERT_OK(scene);
  EXPECT_TRUE(scene->texcoords1.empty());
  EXPECT_TRUE(scene->tangents.empty());
  EXPECT_TRUE(scene->colors.empty());
}

TEST(GeometryTest, EveryTypeOfVertexColourMeansTheSame) {
  const auto load = [](auto values, const char* type, int component, int stride) {
    GltfBuilder gltf = GltfBuilder::Triangle();
    const size_t accessor = gltf.Accessor(values, type, component, component != 5126);
    gltf.json["accessors"][accessor]["count"] = 3;
    if (stride > 0) gltf.json["bufferViews"].back()["byteStride"] = stride;
    gltf.primitive()["attributes"]["COLOR_0"] = accessor;
    const auto scene = gltf.Load();
    EXPECT_OK(scene);
    return scene.ok() ? scene->colors : std::vector<glm::vec4>();
  };
  const std::vector<glm::vec4> rgb = {{1, 0, 0, 1}, {0, 1, 0, 1}, {0, 0, 1, 1}};
  std::vector<glm::vec4> rgba = rgb;
  for (glm::vec4& color : rgba) color.a = 0;
  EXPECT_EQ(load(std::vector<float>{1, 0, 0, 0, 1, 0, 0, 0, 1}, "VEC3", 5126, 0), rgb);
  EXPECT_EQ(load(std::vector<float>{2, 0, 0, -1, 1, 0, 0, 1, 1}, "VEC3", 5126, 0),
            (std::vector<glm::vec4>{{1, 0, 0, 1}, {0, 1, 0, 1}, {0, 1, 1, 1}}))
      << "clamped to [0,1]";
  EXPECT_EQ(load(std::vector<float>{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}, "VEC4", 5126, 0), rgba);
  EXPECT_EQ(load(std::vector<uint8_t>{255, 0, 0, 9, 0, 255, 0, 9, 0, 0, 255, 9}, "VEC3", 5121, 4), rgb);
  EXPECT_EQ(load(std::vector<uint8_t>{255, 0, 0, 0, 0, 255, 0, 0, 0, 0, 255, 0}, "VEC4", 5121, 0), rgba);
  EXPECT_EQ(load(std::vector<uint16_t>{65535, 0, 0, 9, 0, 65535, 0, 9, 0, 0, 65535, 9}, "VEC3", 5123, 8), rgb);
}

TEST(GeometryTest, MeshesWithoutAnAttributeFillItsArray) {
  GltfBuilder gltf = GltfBuilder::Triangle();
  const auto plain = gltf.primitive();
  gltf.primitive()["attributes"]["COLOR_0"] = gltf.Accessor<float>({1, 0, 0, 0, 1, 0, 0, 0, 1}, "VEC3", 5126);
  const auto coloured = gltf.primitive();
  gltf.json["meshes"][0]["primitives"] = {plain, coloured, plain};
  const auto scene = gltf.Load();
  ASSERT_OK(scene);
  ASSERT_EQ(scene->colors.size(), 9u);
  EXPECT_EQ(scene->colors[0], glm::vec4(1));
  EXPECT_EQ(scene->colors[3], glm::vec4(1, 0, 0, 1));
  EXPECT_EQ(scene->colors[8], glm::vec4(1));
}

}  // namespace
}  // namespace halfshade
