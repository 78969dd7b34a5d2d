#include "renderer/scene_loader/validate_gltf.h"

#include <algorithm>
#include <exception>
#include <map>
#include <set>

#include "renderer/scene_loader/validate_parts.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

// Extensions that we implement; every other one is refused by name where it is required.
const std::set<std::string>& SupportedExtensions() {
  static const auto& extensions = *new std::set<std::string>{"EXT_mesh_gpu_instancing",
                                                             "EXT_meshopt_compression",
                                                             "KHR_draco_mesh_compression",
                                                             "KHR_lights_punctual",
                                                             "KHR_materials_emissive_strength",
                                                             "KHR_materials_unlit",
                                                             "KHR_mesh_quantization",
                                                             "KHR_texture_basisu",
                                                             "KHR_texture_transform"};
  return extensions;
}

// The properties of glTF 2.0, by top-level array. A name, extensions and extras may stand everywhere.
const std::map<std::string, std::set<std::string>>& KnownProperties() {
  static const auto& properties = *new std::map<std::string, std::set<std::string>>{
      {"accessors",
       {"bufferView", "byteOffset", "componentType", "normalized", "count", "type", "max", "min", "sparse"}},
      {"animations", {"channels", "samplers"}},
      {"bufferViews", {"buffer", "byteOffset", "byteLength", "byteStride", "target"}},
      {"buffers", {"uri", "byteLength"}},
      {"cameras", {"orthographic", "perspective", "type"}},
      {"images", {"uri", "mimeType", "bufferView"}},
      {"materials",
       {"pbrMetallicRoughness", "normalTexture", "occlusionTexture", "emissiveTexture", "emissiveFactor", "alphaMode",
        "alphaCutoff", "doubleSided"}},
      {"meshes", {"primitives", "weights"}},
      {"nodes", {"camera", "children", "skin", "matrix", "mesh", "rotation", "scale", "translation", "weights"}},
      {"samplers", {"magFilter", "minFilter", "wrapS", "wrapT"}},
      {"scenes", {"nodes"}},
      {"skins", {"inverseBindMatrices", "skeleton", "joints"}},
      {"textures", {"sampler", "source"}}};
  return properties;
}

absl::Status ParseJson(const std::string& text, Json* json) {
  try {
    *json = Json::parse(text);
  } catch (const Json::exception& exception) {
    // "[json.exception.parse_error.101] parse error at line 1, column 5: ..." of which a user needs what follows "] ".
    const std::string what = exception.what();
    const size_t bracket = what.find("] ");
    return absl::InvalidArgumentError("JSON: not well-formed: " +
                                      Quoted(what.substr(bracket == std::string::npos ? 0 : bracket + 2), 200));
  }
  if (!json->is_object()) return absl::InvalidArgumentError("JSON: /: must be an object");
  return absl::OkStatus();
}

void WarnOfUnknownProperties(const Place& place, const std::set<std::string>& known, Warnings* warnings) {
  for (const auto& [key, value] : place.json().items()) {
    if (!known.contains(key) && key != "name" && key != "extensions" && key != "extras") {
      warnings->Add(place.Member(key).pointer(), "is no property of glTF 2.0; ignored");
    }
  }
}

absl::Status CheckAsset(const Place& root, Gltf* gltf) {
  ASSIGN_OR_RETURN(const Place asset, root.Object("asset"));
  WarnOfUnknownProperties(asset, {"copyright", "generator", "version", "minVersion"}, &gltf->warnings);
  ASSIGN_OR_RETURN(const std::string version, asset.Text("version"));
  if (!version.starts_with("2.") || version.size() < 3) {
    return asset.FaultAt("version", Quoted(version) + "; only 2.0 is supported");
  }
  if (!asset.Has("minVersion")) return absl::OkStatus();
  ASSIGN_OR_RETURN(const std::string min_version, asset.Text("minVersion"));
  if (min_version == "2.0") return absl::OkStatus();
  return asset.FaultAt("minVersion", Quoted(min_version) + "; only 2.0 is supported");
}

absl::Status CheckTopLevel(const Place& root, Gltf* gltf) {
  std::set<std::string> known = {"asset", "scene", "extensionsUsed", "extensionsRequired"};
  size_t total = 0;
  for (const auto& [name, properties] : KnownProperties()) {
    known.insert(name);
    if (!root.Has(name)) continue;
    ASSIGN_OR_RETURN(const Place array, root.Array(name));
    if (array.size() == 0) gltf->warnings.Add(array.pointer(), "empty; glTF asks to leave it out");
    total += array.size();
    if (total > kMaxElements) {
      return array.Fault("the file has over " + std::to_string(kMaxElements) + " elements, the limit");
    }
    for (size_t i = 0; i < array.size(); ++i) {
      const Place element = array.Element(i);
      if (!element.json().is_object()) return element.Fault("must be an object");
      if (element.Has("name")) RETURN_IF_ERROR(element.Text("name").status());
      WarnOfUnknownProperties(element, properties, &gltf->warnings);
    }
  }
  WarnOfUnknownProperties(root, known, &gltf->warnings);
  return absl::OkStatus();
}

absl::Status CheckExtensions(const Place& root, Gltf* gltf) {
  for (const char* key : {"extensionsRequired", "extensionsUsed"}) {
    if (!root.Has(key)) continue;
    ASSIGN_OR_RETURN(const Place list, root.Array(key));
    for (size_t i = 0; i < list.size(); ++i) {
      const Place place = list.Element(i);
      if (!place.json().is_string()) return place.Fault("must be a string");
      const std::string name = place.json().get<std::string>();
      if (SupportedExtensions().contains(name)) continue;
      if (key == std::string("extensionsRequired")) return place.Fault(Quoted(name) + " is not supported");
      gltf->warnings.Add(place.pointer(), Quoted(name) + " is not supported; the scene is drawn without it");
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<Gltf> ValidateGltf(const GltfContainer& container, const FileMap& files, const SceneLoadLimits& limits) {
  Gltf gltf;
  RETURN_IF_ERROR(ParseJson(container.json, &gltf.json));
  if (container.trailing_bytes > 0) {
    gltf.warnings.Add("GLB", std::to_string(container.trailing_bytes) + " bytes after the end are ignored");
  }
  const Place root(gltf.json, "");
  RETURN_IF_ERROR(CheckAsset(root, &gltf));
  RETURN_IF_ERROR(CheckTopLevel(root, &gltf));
  RETURN_IF_ERROR(CheckExtensions(root, &gltf));
  RETURN_IF_ERROR(ValidateData(limits, &gltf));
  RETURN_IF_ERROR(ValidateMeshes(&gltf));
  RETURN_IF_ERROR(ValidateNodes(&gltf));
  RETURN_IF_ERROR(ResolveBytes(container, files, &gltf));
  RETURN_IF_ERROR(Decompress(limits, &gltf));
  return gltf;
}

}  // namespace halfshade
