#include <limits>

#include "renderer/scene_loader/validate_gltf.h"
#include "renderer/scene_loader/validate_parts.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

constexpr int64_t kFloat = 5126;
constexpr int64_t kTriangles = 4;
// Beyond it a normal map is a plane of edges; a float of it still has a length.
constexpr double kMaxNormalScale = 1e6;
constexpr double kMaxMorphWeight = 1e6;
constexpr double kMaxEmission = 1e15;

absl::Status CheckTextureInfo(const Place& owner, const char* key, Gltf* gltf) {
  if (!owner.Has(key)) return absl::OkStatus();
  ASSIGN_OR_RETURN(const Place info, owner.Object(key));
  RETURN_IF_ERROR(gltf->Follow(info, "index", "textures").status());
  RETURN_IF_ERROR(info.IntegerOr("texCoord", 0, 1 << 20, 0).status());
  return CheckTextureTransform(info);
}

absl::Status CheckPbr(const Place& material, Gltf* gltf) {
  if (!material.Has("pbrMetallicRoughness")) return absl::OkStatus();
  ASSIGN_OR_RETURN(const Place pbr, material.Object("pbrMetallicRoughness"));
  RETURN_IF_ERROR(pbr.CheckNumbers("baseColorFactor", 4, 0, 1));
  RETURN_IF_ERROR(pbr.CheckNumber("metallicFactor", 0, 1));
  RETURN_IF_ERROR(pbr.CheckNumber("roughnessFactor", 0, 1));
  RETURN_IF_ERROR(CheckTextureInfo(pbr, "baseColorTexture", gltf));
  return CheckTextureInfo(pbr, "metallicRoughnessTexture", gltf);
}

absl::Status CheckMaterial(const Place& material, Gltf* gltf) {
  constexpr double kLargest = std::numeric_limits<float>::max();
  RETURN_IF_ERROR(CheckPbr(material, gltf));
  for (const char* key : {"normalTexture", "occlusionTexture", "emissiveTexture"}) {
    RETURN_IF_ERROR(CheckTextureInfo(material, key, gltf));
  }
  if (material.Has("normalTexture")) {
    RETURN_IF_ERROR(material.Member("normalTexture").CheckNumber("scale", -kMaxNormalScale, kMaxNormalScale));
  }
  if (material.Has("occlusionTexture")) {
    RETURN_IF_ERROR(material.Member("occlusionTexture").CheckNumber("strength", 0, 1));
  }
  RETURN_IF_ERROR(material.CheckNumbers("emissiveFactor", 3, 0, 1));
  RETURN_IF_ERROR(material.CheckFlag("doubleSided"));
  if (material.Has("alphaMode")) {
    ASSIGN_OR_RETURN(const std::string mode, material.Text("alphaMode"));
    if (mode != "OPAQUE" && mode != "MASK" && mode != "BLEND") {
      return material.FaultAt("alphaMode", Quoted(mode) + "; must be OPAQUE, MASK or BLEND");
    }
    if (mode == "BLEND") {
      gltf->warnings.Add(material.Member("alphaMode").pointer(),
                         "BLEND hides alpha's share of the light, and is drawn where alpha is at least .5");
    }
  }
  if (material.HasExtension("KHR_materials_emissive_strength")) {
    RETURN_IF_ERROR(
        material.Extension("KHR_materials_emissive_strength").CheckNumber("emissiveStrength", 0, kMaxEmission));
  }
  return material.CheckNumber("alphaCutoff", 0, kLargest);
}

// The accessor that `attributes` names: its elements are as many as `count`, and aligned as vertices must be.
absl::StatusOr<Place> CheckAttribute(const Gltf& gltf, const Place& attributes, const std::string& name,
                                     int64_t count) {
  ASSIGN_OR_RETURN(const Place accessor, gltf.Follow(attributes, name, "accessors"));
  const int64_t own_count = accessor.json()["count"].get<int64_t>();
  if (own_count != count) {
    return attributes.FaultAt(name, accessor.pointer() + " has a count of " + std::to_string(own_count) +
                                        "; POSITION has " + std::to_string(count));
  }
  if (accessor.json().value("byteOffset", int64_t(0)) % 4 != 0) {
    return attributes.FaultAt(name, accessor.pointer() + " is not aligned to four bytes");
  }
  return accessor;
}

// What integers may stand for floats beside KHR_mesh_quantization, which allows signed ones and what is not normalized.
enum class Normalized : uint8_t { kNone, kUnsigned };

// An attribute of floats, or of the integers that may stand for them.
absl::Status CheckType(const Gltf& gltf, const Place& attributes, const std::string& name, const Place& accessor,
                       const char* type, Normalized allowed) {
  const Json& json = accessor.json();
  if (json["type"] != type) {
    return attributes.FaultAt(name,
                              accessor.pointer() + " is " + json["type"].get<std::string>() + "; must be " + type);
  }
  const int64_t component = json["componentType"].get<int64_t>();
  const bool is_small = component != kFloat && ComponentBytes(component) < 4;
  const bool is_unsigned = component == 5121 || component == 5123;
  const bool is_quantized = is_small && gltf.Uses("KHR_mesh_quantization");
  const bool is_normalized = is_unsigned && allowed == Normalized::kUnsigned && json.value("normalized", false);
  if (component == kFloat || is_quantized || is_normalized) return absl::OkStatus();
  return attributes.FaultAt(
      name, accessor.pointer() + " has componentType " + std::to_string(component) +
                (allowed == Normalized::kUnsigned ? "; must be float or a normalized unsigned byte or short"
                                                  : "; must be float, or KHR_mesh_quantization be used"));
}

absl::Status CheckTargets(const Place& primitive, int64_t count, Gltf* gltf) {
  if (!primitive.Has("targets")) return absl::OkStatus();
  ASSIGN_OR_RETURN(const Place targets, primitive.Array("targets"));
  for (size_t i = 0; i < targets.size(); ++i) {
    const Place target = targets.Element(i);
    if (!target.json().is_object()) return target.Fault("must be an object");
    for (const auto& [name, index] : target.json().items()) {
      ASSIGN_OR_RETURN(const Place accessor, CheckAttribute(*gltf, target, name, count));
      if (name == "POSITION" || name == "NORMAL" || name == "TANGENT") {
        RETURN_IF_ERROR(CheckType(*gltf, target, name, accessor, "VEC3", Normalized::kNone));
      }
    }
  }
  return absl::OkStatus();
}

absl::Status CheckIndices(const Place& primitive, int64_t mode, Gltf* gltf) {
  if (!primitive.Has("indices")) return absl::OkStatus();
  ASSIGN_OR_RETURN(const Place accessor, gltf->Follow(primitive, "indices", "accessors"));
  const int64_t component = accessor.json()["componentType"].get<int64_t>();
  if (accessor.json()["type"] != "SCALAR" || (component != 5121 && component != 5123 && component != 5125)) {
    return primitive.FaultAt("indices", accessor.pointer() + " must be SCALAR of unsigned integers");
  }
  // tinygltf asks so too.
  const bool is_compressed =
      gltf->Uses("KHR_draco_mesh_compression") && primitive.HasExtension("KHR_draco_mesh_compression");
  if (!accessor.Has("bufferView") && !is_compressed)
    return primitive.FaultAt("indices", accessor.pointer() + " has no bufferView");
  const int64_t count = accessor.json()["count"].get<int64_t>();
  if (mode == kTriangles && count % 3 != 0) {
    gltf->warnings.Add(primitive.Member("indices").pointer(),
                       std::to_string(count) + " indices; triangles take three each, what is left over is not drawn");
  }
  return absl::OkStatus();
}

absl::Status CheckPrimitive(const Place& primitive, Gltf* gltf) {
  if (!primitive.json().is_object()) return primitive.Fault("must be an object");
  ASSIGN_OR_RETURN(const Place attributes, primitive.Object("attributes"));
  for (const auto& [name, index] : attributes.json().items()) {
    RETURN_IF_ERROR(gltf->Follow(attributes, name, "accessors").status());
  }
  RETURN_IF_ERROR(gltf->CheckOptionalIndex(primitive, "material", "materials"));
  ASSIGN_OR_RETURN(const int64_t mode, primitive.IntegerOr("mode", 0, 6, kTriangles));
  if (mode < kTriangles) gltf->warnings.Add(primitive.pointer() + "/mode", "points and lines are not drawn");
  RETURN_IF_ERROR(CheckIndices(primitive, mode, gltf));
  if (!attributes.Has("POSITION")) {
    gltf->warnings.Add(attributes.pointer(), "without POSITION nothing is drawn");
    return absl::OkStatus();
  }
  ASSIGN_OR_RETURN(const Place position, gltf->Follow(attributes, "POSITION", "accessors"));
  const int64_t count = position.json()["count"].get<int64_t>();
  for (const auto& [name, index] : attributes.json().items()) {
    ASSIGN_OR_RETURN(const Place accessor, CheckAttribute(*gltf, attributes, name, count));
    if (name == "POSITION" || name == "NORMAL") {
      RETURN_IF_ERROR(CheckType(*gltf, attributes, name, accessor, "VEC3", Normalized::kNone));
    } else if (name == "TANGENT") {
      RETURN_IF_ERROR(CheckType(*gltf, attributes, name, accessor, "VEC4", Normalized::kNone));
    } else if (name.starts_with("TEXCOORD_")) {
      RETURN_IF_ERROR(CheckType(*gltf, attributes, name, accessor, "VEC2", Normalized::kUnsigned));
    } else if (name.starts_with("JOINTS_")) {
      const int64_t component = accessor.json()["componentType"].get<int64_t>();
      if (accessor.json()["type"] != "VEC4" || (component != 5121 && component != 5123)) {
        return attributes.FaultAt(name, accessor.pointer() + " must be VEC4 of unsigned bytes or shorts");
      }
    } else if (name.starts_with("WEIGHTS_")) {
      RETURN_IF_ERROR(CheckType(*gltf, attributes, name, accessor, "VEC4", Normalized::kUnsigned));
    } else if (name == "COLOR_0") {
      const bool has_alpha = accessor.json()["type"] == "VEC4";
      RETURN_IF_ERROR(CheckType(*gltf, attributes, name, accessor, has_alpha ? "VEC4" : "VEC3", Normalized::kUnsigned));
    }
  }
  if (gltf->Uses("KHR_draco_mesh_compression")) RETURN_IF_ERROR(CheckDracoPrimitive(primitive, gltf));
  return CheckTargets(primitive, count, gltf);
}

}  // namespace

absl::Status CheckWeights(const Place& owner) {
  if (!owner.Has("weights")) return absl::OkStatus();
  ASSIGN_OR_RETURN(const Place weights, owner.Array("weights"));
  return owner.CheckNumbers("weights", weights.size(), -kMaxMorphWeight, kMaxMorphWeight);
}

absl::Status ValidateMeshes(Gltf* gltf) {
  for (size_t i = 0; i < gltf->Count("materials"); ++i) {
    RETURN_IF_ERROR(CheckMaterial(gltf->At("materials", i), gltf));
  }
  size_t total = 0;
  for (size_t i = 0; i < gltf->Count("meshes"); ++i) {
    ASSIGN_OR_RETURN(const Place primitives, gltf->At("meshes", i).Array("primitives"));
    if (primitives.size() == 0) return primitives.Fault("must not be empty");
    total += primitives.size();
    if (total > kMaxElements) {
      return primitives.Fault("the file has over " + std::to_string(kMaxElements) + " primitives, the limit");
    }
    for (size_t k = 0; k < primitives.size(); ++k) RETURN_IF_ERROR(CheckPrimitive(primitives.Element(k), gltf));
    RETURN_IF_ERROR(CheckWeights(gltf->At("meshes", i)));
  }
  return absl::OkStatus();
}

}  // namespace halfshade
