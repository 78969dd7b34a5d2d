// Extensions of nodes, materials and the root; animations.
#include <array>
#include <limits>

#include "renderer/scene_loader/validate_gltf.h"
#include "renderer/scene_loader/validate_parts.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

constexpr int64_t kFloat = 5126;
constexpr const char* kInstancing = "EXT_mesh_gpu_instancing";
constexpr const char* kLights = "KHR_lights_punctual";
constexpr double kMaxTextureCoordinate = 1e6;  // beyond, a float tells no texels apart

bool IsSmallNormalized(const Json& accessor) {
  const int64_t component = accessor["componentType"].get<int64_t>();
  return (component == 5120 || component == 5122) && accessor.value("normalized", false);
}

absl::Status CheckInstancing(const Gltf& gltf, const Place& node, Warnings* warnings) {
  if (!node.Member("extensions").Member(kInstancing).json().is_object()) {
    return node.Extension(kInstancing).Fault("must be an object");
  }
  const Place place = node.Extension(kInstancing);
  ASSIGN_OR_RETURN(const Place attributes, place.Object("attributes"));
  if (!node.Has("mesh")) warnings->Add(place.pointer(), "without a mesh nothing is drawn");
  int64_t count = 0;
  for (const auto& [name, index] : attributes.json().items()) {
    ASSIGN_OR_RETURN(const Place accessor, gltf.Follow(attributes, name, "accessors"));
    const int64_t own_count = accessor.json()["count"].get<int64_t>();
    if (count == 0) count = own_count;
    if (own_count != count) {
      return attributes.FaultAt(name, accessor.pointer() + " has a count of " + std::to_string(own_count) +
                                          "; another attribute has " + std::to_string(count));
    }
    if (count > int64_t(kMaxElements)) {
      return attributes.FaultAt(name, accessor.pointer() + " has " + std::to_string(count) + " instances; at most " +
                                          std::to_string(kMaxElements));
    }
    const bool is_rotation = name == "ROTATION";
    if (!is_rotation && name != "TRANSLATION" && name != "SCALE") continue;
    const bool is_float = accessor.json()["componentType"] == kFloat;
    if (accessor.json()["type"] != (is_rotation ? "VEC4" : "VEC3") ||
        !(is_float || (is_rotation && IsSmallNormalized(accessor.json())))) {
      return attributes.FaultAt(
          name, accessor.pointer() + (is_rotation ? " must be VEC4 of floats or of normalized bytes or shorts"
                                                  : " must be VEC3 of floats"));
    }
  }
  return absl::OkStatus();
}

absl::Status CheckNodeLight(const Gltf& gltf, const Place& node) {
  const Place place = node.Member("extensions").Member(kLights);
  if (!place.json().is_object()) return place.Fault("must be an object");
  const Place root(gltf.json, "");
  const size_t lights = root.HasExtension(kLights) && root.Extension(kLights).Has("lights")
                            ? root.Extension(kLights).Member("lights").size()
                            : 0;
  ASSIGN_OR_RETURN(const int64_t light, place.Integer("light", 0, std::numeric_limits<int32_t>::max()));
  if (uint64_t(light) < lights) return absl::OkStatus();
  return place.FaultAt(
      "light", std::to_string(light) + "; /extensions/KHR_lights_punctual/lights has " + std::to_string(lights));
}

absl::Status CheckLight(const Place& light, Warnings* warnings) {
  ASSIGN_OR_RETURN(const std::string type, light.Text("type"));
  constexpr double kLargest = 1e15;
  RETURN_IF_ERROR(light.CheckNumbers("color", 3, 0, kLargest));
  RETURN_IF_ERROR(light.CheckNumber("intensity", 0, kLargest));
  if (type != "point" && type != "spot" && type != "directional") {
    warnings->Add(light.Member("type").pointer(), Quoted(type) + "; no such light; left out");
  }
  return absl::OkStatus();
}

// How many components a channel has, 0 for a path that is none of glTF's.
int64_t WidthOf(const std::string& path) {
  return path == "rotation" ? 4 : path == "translation" || path == "scale" ? 3 : path == "weights" ? 1 : 0;
}

absl::Status CheckSampler(const Gltf& gltf, const Place& sampler) {
  if (!sampler.json().is_object()) return sampler.Fault("must be an object");
  ASSIGN_OR_RETURN(const Place input, gltf.Follow(sampler, "input", "accessors"));
  RETURN_IF_ERROR(gltf.Follow(sampler, "output", "accessors").status());
  if (input.json()["type"] != "SCALAR" || input.json()["componentType"] != kFloat) {
    return sampler.FaultAt("input", input.pointer() + " must be SCALAR of floats");
  }
  if (!sampler.Has("interpolation")) return absl::OkStatus();
  ASSIGN_OR_RETURN(const std::string name, sampler.Text("interpolation"));
  if (name == "STEP" || name == "LINEAR" || name == "CUBICSPLINE") return absl::OkStatus();
  return sampler.FaultAt("interpolation", Quoted(name) + "; must be STEP, LINEAR or CUBICSPLINE");
}

absl::Status CheckOutput(const Gltf& gltf, const Place& sampler, const std::string& path) {
  ASSIGN_OR_RETURN(const Place output, gltf.Follow(sampler, "output", "accessors"));
  const std::string type = path == "weights" ? "SCALAR" : path == "rotation" ? "VEC4" : "VEC3";
  const int64_t component = output.json()["componentType"].get<int64_t>();
  const bool may_be_small = path == "rotation" || path == "weights";
  const bool is_small = may_be_small && ComponentBytes(component) < 4 && output.json().value("normalized", false);
  if (output.json()["type"] != type || (component != kFloat && !is_small)) {
    return sampler.FaultAt("output", output.pointer() + " must be " + type +
                                         (may_be_small ? " of floats or normalized integers" : " of floats"));
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status CheckTextureTransform(const Place& info) {
  if (!info.HasExtension("KHR_texture_transform")) return absl::OkStatus();
  const Place place = info.Extension("KHR_texture_transform");
  RETURN_IF_ERROR(place.CheckNumbers("offset", 2, -kMaxTextureCoordinate, kMaxTextureCoordinate));
  RETURN_IF_ERROR(place.CheckNumbers("scale", 2, -kMaxTextureCoordinate, kMaxTextureCoordinate));
  RETURN_IF_ERROR(place.CheckNumber("rotation", -kMaxTextureCoordinate, kMaxTextureCoordinate));
  return place.IntegerOr("texCoord", 0, 1 << 20, 0).status();
}

absl::Status CheckNodeExtensions(const Gltf& gltf, const Place& node, Warnings* warnings) {
  if (!node.Has("extensions") || !node.Member("extensions").json().is_object()) return absl::OkStatus();
  const Place extensions = node.Member("extensions");
  if (extensions.Has(kInstancing)) RETURN_IF_ERROR(CheckInstancing(gltf, node, warnings));
  return extensions.Has(kLights) ? CheckNodeLight(gltf, node) : absl::OkStatus();
}

absl::Status CheckLights(const Gltf& gltf, Warnings* warnings) {
  const Place root(gltf.json, "");
  if (!root.HasExtension(kLights)) return absl::OkStatus();
  ASSIGN_OR_RETURN(const Place lights, root.Extension(kLights).Array("lights"));
  if (lights.size() > kMaxElements) {
    return lights.Fault(std::to_string(lights.size()) + "; at most " + std::to_string(kMaxElements));
  }
  for (size_t i = 0; i < lights.size(); ++i) {
    if (!lights.Element(i).json().is_object()) return lights.Element(i).Fault("must be an object");
    RETURN_IF_ERROR(CheckLight(lights.Element(i), warnings));
  }
  return absl::OkStatus();
}

absl::Status CheckAnimation(const Gltf& gltf, const Place& animation, Warnings* warnings) {
  ASSIGN_OR_RETURN(const Place samplers, animation.Array("samplers"));
  for (size_t i = 0; i < samplers.size(); ++i) RETURN_IF_ERROR(CheckSampler(gltf, samplers.Element(i)));
  ASSIGN_OR_RETURN(const Place channels, animation.Array("channels"));
  for (size_t i = 0; i < channels.size(); ++i) {
    const Place channel = channels.Element(i);
    if (!channel.json().is_object()) return channel.Fault("must be an object");
    ASSIGN_OR_RETURN(const int64_t sampler, channel.Integer("sampler", 0, std::numeric_limits<int32_t>::max()));
    if (uint64_t(sampler) >= samplers.size()) {
      return channel.FaultAt("sampler",
                             std::to_string(sampler) + "; the animation has " + std::to_string(samplers.size()));
    }
    ASSIGN_OR_RETURN(const Place target, channel.Object("target"));
    RETURN_IF_ERROR(gltf.CheckOptionalIndex(target, "node", "nodes"));
    ASSIGN_OR_RETURN(const std::string path, target.Text("path"));
    if (WidthOf(path) == 0) {
      warnings->Add(target.Member("path").pointer(), Quoted(path) + "; no such path; the channel is left out");
      continue;
    }
    RETURN_IF_ERROR(CheckOutput(gltf, samplers.Element(size_t(sampler)), path));
  }
  return absl::OkStatus();
}

}  // namespace halfshade
