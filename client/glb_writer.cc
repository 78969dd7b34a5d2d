#include "client/glb_writer.h"

#include <cassert>
#include <cstring>
#include <glm/gtc/type_ptr.hpp>
#include <nlohmann/json.hpp>

namespace halfshade {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kFloat = 5126;
constexpr int kUnsignedInt = 5125;

// Grows the BIN chunk and the JSON that describes it.
class Writer {
 public:
  void Add(const GlbMesh& mesh) {
    Json attributes;
    glm::vec3 low(mesh.positions.empty() ? glm::vec3(0) : mesh.positions[0]);
    glm::vec3 high = low;
    for (const glm::vec3& p : mesh.positions) {
      low = glm::min(low, p);
      high = glm::max(high, p);
    }
    attributes["POSITION"] = AddAccessor(mesh.positions, "VEC3", kFloat, mesh.positions.size());
    json_["accessors"].back()["min"] = {low.x, low.y, low.z};
    json_["accessors"].back()["max"] = {high.x, high.y, high.z};
    if (!mesh.normals.empty()) attributes["NORMAL"] = AddAccessor(mesh.normals, "VEC3", kFloat, mesh.normals.size());
    if (!mesh.texcoords.empty()) {
      attributes["TEXCOORD_0"] = AddAccessor(mesh.texcoords, "VEC2", kFloat, mesh.texcoords.size());
    }
    const int indices = AddAccessor(mesh.indices, "SCALAR", kUnsignedInt, mesh.indices.size());
    const size_t number = json_["nodes"].size();
    const glm::vec4& color = mesh.base_color;
    json_["materials"].push_back(
        {{"pbrMetallicRoughness",
          {{"baseColorFactor", {color.r, color.g, color.b, color.a}}, {"metallicFactor", 0}, {"roughnessFactor", 1}}},
         {"doubleSided", mesh.is_double_sided}});
    json_["meshes"].push_back(
        {{"primitives", Json::array({{{"attributes", attributes}, {"indices", indices}, {"material", number}}})}});
    Json node = {{"name", mesh.name}, {"mesh", number}};
    if (mesh.world_from_mesh != glm::dmat4(1)) {
      node["matrix"] =
          std::vector<double>(glm::value_ptr(mesh.world_from_mesh), glm::value_ptr(mesh.world_from_mesh) + 16);
    }
    json_["nodes"].push_back(node);
  }

  std::string Finish() {
    assert(bin_.size() <= kMaxGlbBytes);
    json_["asset"] = {{"version", "2.0"}, {"generator", "Halfshade"}};
    Json scene = Json::object();
    if (json_.contains("nodes")) {
      for (size_t i = 0; i < json_["nodes"].size(); ++i) scene["nodes"].push_back(i);
    }
    json_["scenes"] = Json::array({scene});
    json_["scene"] = 0;
    if (!bin_.empty()) json_["buffers"] = Json::array({{{"byteLength", bin_.size()}}});
    std::string text = json_.dump();
    text.resize((text.size() + 3) / 4 * 4, ' ');
    std::string glb = "glTF";
    AddU32(&glb, 2);
    AddU32(&glb, uint32_t(12 + 8 + text.size() + 8 + bin_.size()));
    AddU32(&glb, uint32_t(text.size()));
    glb += "JSON" + text;
    AddU32(&glb, uint32_t(bin_.size()));
    glb += std::string("BIN\0", 4) + bin_;
    return glb;
  }

 private:
  static void AddU32(std::string* out, uint32_t value) {
    char bytes[4];
    std::memcpy(bytes, &value, sizeof(value));
    out->append(bytes, sizeof(bytes));
  }

  // Elements are multiples of four bytes, so that views stay aligned.
  template <typename T>
  int AddAccessor(const std::vector<T>& values, const char* type, int component, size_t count) {
    json_["bufferViews"].push_back(
        {{"buffer", 0}, {"byteOffset", bin_.size()}, {"byteLength", values.size() * sizeof(T)}});
    json_["accessors"].push_back({{"bufferView", json_["bufferViews"].size() - 1},
                                  {"componentType", component},
                                  {"count", count},
                                  {"type", type}});
    bin_.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
    return int(json_["accessors"].size()) - 1;
  }

  Json json_;
  std::string bin_;
};

}  // namespace

std::string WriteGlb(const std::vector<GlbMesh>& meshes) {
  Writer writer;
  for (const GlbMesh& mesh : meshes) {
    for ([[maybe_unused]] const uint32_t index : mesh.indices) assert(index < mesh.positions.size());
    if (!mesh.indices.empty()) writer.Add(mesh);
  }
  return writer.Finish();
}

}  // namespace halfshade
