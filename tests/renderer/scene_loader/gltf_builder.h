// Small glTFs for the loader's tests: JSON that a test may bend, over one buffer that it fills.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "renderer/scene_loader/scene_loader.h"

namespace halfshade {

struct GltfBuilder {
  nlohmann::json json = {{"asset", {{"version", "2.0"}}},
                         {"scene", 0},
                         {"scenes", {{{"nodes", {0}}}}},
                         {"nodes", {{{"mesh", 0}}}},
                         {"meshes", {{{"primitives", {{{"attributes", nlohmann::json::object()}}}}}}}};
  std::string bytes;

  // A unit right triangle in z = 0 and its corner numbers; accessors 0 and 1.
  static GltfBuilder Triangle() {
    GltfBuilder gltf;
    gltf.primitive()["attributes"]["POSITION"] = gltf.Accessor<float>({0, 0, 0, 1, 0, 0, 0, 1, 0}, "VEC3", 5126);
    gltf.primitive()["indices"] = gltf.Accessor<uint8_t>({0, 1, 2}, "SCALAR", 5121);
    return gltf;
  }

  nlohmann::json& primitive() { return json["meshes"][0]["primitives"][0]; }

  // A view of its own, at a multiple of four.
  template <typename T>
  size_t View(const std::vector<T>& values) {
    bytes.resize((bytes.size() + 3) / 4 * 4);
    json["bufferViews"].push_back(
        {{"buffer", 0}, {"byteOffset", bytes.size()}, {"byteLength", values.size() * sizeof(T)}});
    bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
    return json["bufferViews"].size() - 1;
  }

  template <typename T>
  size_t Accessor(const std::vector<T>& values, const std::string& type, int component, bool is_normalized = false) {
    const size_t width = type == "SCALAR" ? 1 : type.starts_with("VEC") ? size_t(type[3] - '0') : 16;
    json["accessors"].push_back(
        {{"bufferView", View(values)}, {"componentType", component}, {"count", values.size() / width}, {"type", type}});
    if (is_normalized) json["accessors"].back()["normalized"] = true;
    return json["accessors"].size() - 1;
  }

  std::string Text() const {
    nlohmann::json whole = json;
    if (!bytes.empty() && !whole.contains("buffers")) {
      whole["buffers"] = {{{"byteLength", bytes.size()}, {"uri", "a%20b.bin"}}};
    }
    return whole.dump();
  }

  absl::StatusOr<FlatScene> Load(const SceneLoadLimits& limits = {}) const {
    return LoadGltf(Text(), {{"a b.bin", &bytes}}, limits);
  }
};

// Corners of all triangles in object space.
inline std::vector<glm::dvec3> Corners(const FlatScene& scene) {
  std::vector<glm::dvec3> corners;
  for (const Mesh& mesh : scene.meshes) {
    for (uint32_t i = 0; i < mesh.index_count; ++i) {
      corners.push_back(mesh.origin +
                        glm::dvec3(scene.positions[mesh.first_vertex + scene.indices[mesh.first_index + i]]));
    }
  }
  return corners;
}

}  // namespace halfshade
