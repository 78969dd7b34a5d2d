// What the libraries compress loads as what was compressed.
#include <draco/compression/encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>
#include <gtest/gtest.h>
#include <meshoptimizer.h>

#include "renderer/scene_loader/scene_loader.h"
#include "tests/renderer/scene_loader/gltf_builder.h"
#include "tests/support/status_matchers.h"

namespace halfshade {
namespace {

using testing::HasSubstr;

std::vector<float> Positions() { return {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0.5}; }

// The triangles 0 1 2 and 2 1 3, their views compressed.
GltfBuilder MeshoptQuad() {
  GltfBuilder gltf = GltfBuilder::Triangle();
  gltf.json["bufferViews"] = nlohmann::json::array();
  gltf.json["accessors"] = nlohmann::json::array();
  gltf.bytes.clear();
  gltf.json["extensionsUsed"] = gltf.json["extensionsRequired"] = {"EXT_meshopt_compression"};
  const std::vector<float> positions = Positions();
  std::vector<unsigned char> vertices(meshopt_encodeVertexBufferBound(4, 12));
  vertices.resize(meshopt_encodeVertexBuffer(vertices.data(), vertices.size(), positions.data(), 4, 12));
  const std::vector<unsigned> corners = {0, 1, 2, 2, 1, 3};
  std::vector<unsigned char> triangles(meshopt_encodeIndexBufferBound(6, 4));
  triangles.resize(meshopt_encodeIndexBuffer(triangles.data(), triangles.size(), corners.data(), 6));
  const auto add = [&](const std::vector<unsigned char>& bytes, const char* mode, size_t count, size_t stride) {
    const size_t view = gltf.View(bytes);
    const nlohmann::json compressed = {{"buffer", 0},
                                       {"byteOffset", gltf.json["bufferViews"][view]["byteOffset"]},
                                       {"byteLength", bytes.size()},
                                       {"byteStride", stride},
                                       {"count", count},
                                       {"mode", mode}};
    gltf.json["bufferViews"][view] = {{"buffer", 1}, {"byteLength", count * stride}};
    gltf.json["bufferViews"][view]["extensions"]["EXT_meshopt_compression"] = compressed;
  };
  add(vertices, "ATTRIBUTES", 4, 12);
  add(triangles, "TRIANGLES", 6, 4);
  gltf.json["accessors"] = {{{"bufferView", 0}, {"componentType", 5126}, {"count", 4}, {"type", "VEC3"}},
                            {{"bufferView", 1}, {"componentType", 5125}, {"count", 6}, {"type", "SCALAR"}}};
  gltf.json["buffers"] = {{{"byteLength", gltf.bytes.size()}, {"uri", "a%20b.bin"}}, {{"byteLength", 72}}};
  gltf.json["buffers"][1]["extensions"]["EXT_meshopt_compression"]["fallback"] = true;
  return gltf;
}

TEST(MeshoptTest, ViewsAreDecompressed) {
  const auto scene = MeshoptQuad().Load();
  ASSERT_OK(scene);
  const std::vector<glm::dvec3> corners = Corners(*scene);
  ASSERT_EQ(corners.size(), 6u);
  EXPECT_EQ(corners[1], glm::dvec3(1, 0, 0));
  EXPECT_EQ(glm::vec3(corners[5] + corners[4] + corners[3]), glm::vec3(2, 2, 0.5)) << "in any rotation";
}

// Positions of 23 bits with an exponent for each component, and a list of indices that is not of triangles.
TEST(MeshoptTest, FiltersAndSequencesAreUndone) {
  GltfBuilder gltf = MeshoptQuad();
  const std::vector<float> positions = Positions();
  std::vector<uint32_t> filtered(positions.size());
  meshopt_encodeFilterExp(filtered.data(), 4, 12, 23, positions.data());
  std::vector<unsigned char> vertices(meshopt_encodeVertexBufferBound(4, 12));
  vertices.resize(meshopt_encodeVertexBuffer(vertices.data(), vertices.size(), filtered.data(), 4, 12));
  const std::vector<unsigned> corners = {3, 1, 2};
  std::vector<unsigned char> sequence(meshopt_encodeIndexSequenceBound(3, 4));
  sequence.resize(meshopt_encodeIndexSequence(sequence.data(), sequence.size(), corners.data(), 3));
  const auto replace = [&](size_t view, const std::vector<unsigned char>& bytes, const char* mode, size_t count) {
    const size_t raw = gltf.View(bytes);
    nlohmann::json& json = gltf.json["bufferViews"][view];
    nlohmann::json& compressed = json["extensions"]["EXT_meshopt_compression"];
    compressed["byteOffset"] = gltf.json["bufferViews"][raw]["byteOffset"];
    compressed["byteLength"] = bytes.size();
    compressed["mode"] = mode;
    compressed["count"] = count;
    json["byteLength"] = count * compressed["byteStride"].get<size_t>();
    gltf.json["bufferViews"].erase(raw);
  };
  replace(0, vertices, "ATTRIBUTES", 4);
  gltf.json["bufferViews"][0]["extensions"]["EXT_meshopt_compression"]["filter"] = "EXPONENTIAL";
  replace(1, sequence, "INDICES", 3);
  gltf.json["accessors"][1]["count"] = 3;
  gltf.json["buffers"][0]["byteLength"] = gltf.bytes.size();
  const auto scene = gltf.Load();
  ASSERT_OK(scene);
  const std::vector<glm::dvec3> loaded = Corners(*scene);
  ASSERT_EQ(loaded.size(), 3u);
  EXPECT_LT(glm::distance(loaded[0], {1, 1, 0.5}), 1e-6);
  EXPECT_LT(glm::distance(loaded[1], {1, 0, 0}), 1e-6);
}

TEST(MeshoptTest, AViewOfAFallbackMustBeCompressed) {
  GltfBuilder gltf = MeshoptQuad();
  gltf.json["bufferViews"][0].erase("extensions");
  EXPECT_THAT(gltf.Load(), StatusIs(absl::StatusCode::kInvalidArgument,
                                    HasSubstr("/bufferViews/0/buffer: /buffers/1 has no bytes")));
  gltf = MeshoptQuad();
  gltf.json.erase("extensionsUsed");
  gltf.json.erase("extensionsRequired");
  EXPECT_THAT(gltf.Load(), StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("/buffers/1: has no uri")));
}

TEST(MeshoptTest, WhatIsDecodedIsBounded) {
  SceneLoadLimits limits;
  limits.max_scene_bytes = 20'000;
  GltfBuilder gltf = MeshoptQuad();
  // A view that no accessor reads: many times as many bytes as are sent.
  const std::vector<float> zeros(3000);
  std::vector<unsigned char> bytes(meshopt_encodeVertexBufferBound(1000, 12));
  bytes.resize(meshopt_encodeVertexBuffer(bytes.data(), bytes.size(), zeros.data(), 1000, 12));
  const size_t view = gltf.View(bytes);
  nlohmann::json& json = gltf.json["bufferViews"][view];
  json["extensions"]["EXT_meshopt_compression"] = {{"buffer", 0},
                                                   {"byteOffset", json["byteOffset"]},
                                                   {"byteLength", bytes.size()},
                                                   {"byteStride", 12},
                                                   {"count", 1000},
                                                   {"mode", "ATTRIBUTES"}};
  json["byteOffset"] = 0;
  json["byteLength"] = 12'000;
  json["buffer"] = 1;
  gltf.json["buffers"][0]["byteLength"] = gltf.bytes.size();
  gltf.json["buffers"][1]["byteLength"] = 12'000;
  EXPECT_OK(gltf.Load(limits));
  gltf.json["bufferViews"].push_back(json);
  EXPECT_THAT(gltf.Load(limits),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("takes 24072 bytes; at most 20000")));
}

GltfBuilder DracoTriangle(int points_said) {
  draco::TriangleSoupMeshBuilder builder;
  builder.Start(1);
  const int positions = builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
  const float corners[3][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  builder.SetAttributeValuesForFace(positions, draco::FaceIndex(0), corners[0], corners[1], corners[2]);
  const auto mesh = builder.Finalize();
  draco::Encoder encoder;
  draco::EncoderBuffer encoded;
  EXPECT_TRUE(encoder.EncodeMeshToBuffer(*mesh, &encoded).ok());
  GltfBuilder gltf = GltfBuilder::Triangle();
  gltf.json["extensionsUsed"] = gltf.json["extensionsRequired"] = {"KHR_draco_mesh_compression"};
  gltf.json["bufferViews"] = nlohmann::json::array();
  gltf.bytes.clear();
  gltf.View(std::vector<char>(encoded.data(), encoded.data() + encoded.size()));
  gltf.json["accessors"] = {{{"componentType", 5126}, {"count", points_said}, {"type", "VEC3"}},
                            {{"componentType", 5121}, {"count", 3}, {"type", "SCALAR"}}};
  gltf.primitive()["extensions"]["KHR_draco_mesh_compression"] = {
      {"bufferView", 0}, {"attributes", {{"POSITION", mesh->attribute(positions)->unique_id()}}}};
  return gltf;
}

TEST(DracoTest, PrimitivesAreDecompressed) {
  const auto scene = DracoTriangle(3).Load();
  ASSERT_OK(scene);
  glm::dvec3 sum(0);
  for (const glm::dvec3& corner : Corners(*scene)) sum += corner;
  EXPECT_EQ(Corners(*scene).size(), 3u);
  EXPECT_EQ(sum, glm::dvec3(1, 1, 0));
}

TEST(DracoTest, WhatTheAccessorsSayMustBeWhatIsThere) {
  EXPECT_THAT(DracoTriangle(4).Load(),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("KHR_draco_mesh_compression/attributes/POSITION: /accessors/0 has a count of 4; its "
                                 "bytes have 3 vertices")));
  GltfBuilder gltf = DracoTriangle(3);
  gltf.json["accessors"][1]["count"] = 6;
  EXPECT_THAT(gltf.Load(),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("/indices: /accessors/1 has a count of 6")));
}

}  // namespace
}  // namespace halfshade
