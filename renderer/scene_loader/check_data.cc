#include "renderer/scene_loader/check_data.h"

#include <cmath>
#include <map>
#include <string>

#include "renderer/scene_loader/tinygltf.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

absl::Status AccessorFault(size_t accessor, const std::string& what) {
  return absl::InvalidArgumentError("/accessors/" + std::to_string(accessor) + what);
}

absl::Status CheckElement(const AccessorReader& reader, size_t accessor, size_t element) {
  for (int c = 0; c < reader.components(); ++c) {
    if (!std::isfinite(reader.Float(element, c))) {
      return AccessorFault(accessor, ": element " + std::to_string(element) + " is not finite");
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status CheckSparseIndices(const GltfData& data) {
  for (size_t i = 0; i < data.model->accessors.size(); ++i) {
    const AccessorReader reader(data, int(i));
    for (size_t k = 0; k < reader.sparse_count(); ++k) {
      const uint32_t index = reader.SparseIndex(k);
      if (index >= reader.count()) {
        return AccessorFault(i, "/sparse/indices: element " + std::to_string(k) + " is " + std::to_string(index) +
                                    "; the accessor has " + std::to_string(reader.count()));
      }
      if (k > 0 && index <= reader.SparseIndex(k - 1)) {
        return AccessorFault(i, "/sparse/indices: element " + std::to_string(k) + " does not increase");
      }
    }
  }
  return absl::OkStatus();
}

absl::Status CheckFloats(const GltfData& data) {
  for (size_t i = 0; i < data.model->accessors.size(); ++i) {
    const AccessorReader reader(data, int(i));
    if (!reader.is_float()) continue;
    const bool has_base = data.model->accessors[i].bufferView >= 0;
    for (size_t k = 0; k < (has_base ? reader.count() : reader.sparse_count()); ++k) {
      RETURN_IF_ERROR(CheckElement(reader, i, has_base ? k : reader.SparseIndex(k)));
    }
  }
  return absl::OkStatus();
}

absl::Status CheckJoints(const GltfData& data) {
  struct Largest {
    uint32_t joint = 0;
    std::string pointer{};
  };
  std::map<int, Largest> largest_of_mesh;
  for (const tinygltf::Node& node : data.model->nodes) {
    if (node.skin < 0 || node.mesh < 0) continue;
    const auto [entry, is_new] = largest_of_mesh.try_emplace(node.mesh);
    Largest& largest = entry->second;
    const std::vector<tinygltf::Primitive>& primitives = data.model->meshes[size_t(node.mesh)].primitives;
    for (size_t p = 0; is_new && p < primitives.size(); ++p) {
      for (const auto& [name, accessor] : primitives[p].attributes) {
        if (!name.starts_with("JOINTS_")) continue;
        const uint32_t joint = AccessorReader(data, accessor).LargestIndex();
        if (joint < largest.joint) continue;
        largest = {joint, "/meshes/" + std::to_string(node.mesh) + "/primitives/" + std::to_string(p) + "/attributes/" +
                              name + " (/accessors/" + std::to_string(accessor) + ")"};
      }
    }
    const size_t joints = data.model->skins[size_t(node.skin)].joints.size();
    if (largest.joint >= joints && !largest.pointer.empty()) {
      return absl::InvalidArgumentError(largest.pointer + ": joint " + std::to_string(largest.joint) +
                                        "; the skin has " + std::to_string(joints));
    }
  }
  return absl::OkStatus();
}

}  // namespace halfshade
