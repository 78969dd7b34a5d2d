#include "renderer/scene_loader/scene_loader.h"

#include <exception>
#include <utility>

#include "renderer/scene_loader/build_scene.h"
#include "renderer/scene_loader/check_data.h"
#include "renderer/scene_loader/container.h"
#include "renderer/scene_loader/tinygltf.h"
#include "renderer/scene_loader/validate_gltf.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

// tinygltf is given no URI and no bytes, so it has nothing to open; and if it tried, it could not.
tinygltf::FsCallbacks NoFiles() {
  tinygltf::FsCallbacks callbacks{};
  callbacks.FileExists = [](const std::string&, void*) { return false; };
  callbacks.ExpandFilePath = [](const std::string& path, void*) { return path; };
  callbacks.ReadWholeFile = [](std::vector<unsigned char>*, std::string*, const std::string&, void*) { return false; };
  callbacks.WriteWholeFile = [](std::string*, const std::string&, const std::vector<unsigned char>&, void*) {
    return false;
  };
  return callbacks;
}

// What tinygltf does not need, it does not get.
void Strip(Json& json) {
  if (json.is_object()) {
    json.erase("extensions");
    json.erase("extras");
  }
  if (json.is_structured()) {
    for (Json& element : json) Strip(element);
  }
}

// Moves what tinygltf does not read, or not as we do, out of its way.
void KeepForBuild(Gltf* gltf) {
  Json& json = gltf->json;
  gltf->materials = json.value("materials", Json::array());
  gltf->textures = json.value("textures", Json::array());
  if (json.contains("animations")) gltf->animations = std::move(json["animations"]);
  const Place root(json, "");
  if (root.HasExtension("KHR_lights_punctual")) {
    gltf->lights = root.Extension("KHR_lights_punctual").json().value("lights", Json::array());
  }
  for (size_t i = 0; i < gltf->Count("nodes"); ++i) {
    Json& node = json["nodes"][i];
    if (node.contains("extensions")) gltf->node_extensions[i] = std::move(node["extensions"]);
  }
}

absl::StatusOr<tinygltf::Model> ParseModel(Json json) {
  Strip(json);
  for (const char* name : {"buffers", "images", "extensionsUsed", "extensionsRequired", "animations"}) json.erase(name);
  const std::string text = json.dump(-1, ' ', true, Json::error_handler_t::replace);
  json = nullptr;
  tinygltf::TinyGLTF loader;
  loader.SetFsCallbacks(NoFiles());
  loader.SetImageLoader([](tinygltf::Image*, const int, std::string*, std::string*, int, int, const unsigned char*, int,
                           void*) { return true; },
                        nullptr);
  tinygltf::Model model;
  std::string error, warning;
  try {
    if (!loader.LoadASCIIFromString(&model, &error, &warning, text.data(), unsigned(text.size()), "")) {
      return absl::InvalidArgumentError("/: " + error.substr(0, error.find('\n')));
    }
  } catch (const std::exception& exception) {
    return absl::InvalidArgumentError(std::string("/: ") + exception.what());
  }
  return model;
}

}  // namespace

absl::StatusOr<FlatScene> LoadGltf(const std::string& root, const FileMap& files, const SceneLoadLimits& limits) {
  uint64_t size = root.size();
  for (const auto& [uri, bytes] : files) size += bytes->size();
  if (size > limits.max_scene_bytes) {
    return absl::InvalidArgumentError("/: " + std::to_string(size) + " bytes with all files; at most " +
                                      std::to_string(limits.max_scene_bytes));
  }
  ASSIGN_OR_RETURN(const GltfContainer container, OpenContainer(root, limits));
  ASSIGN_OR_RETURN(Gltf gltf, ValidateGltf(container, files, limits));
  KeepForBuild(&gltf);
  ASSIGN_OR_RETURN(const tinygltf::Model model, ParseModel(std::move(gltf.json)));
  const GltfData data{&model, &gltf.buffers};
  RETURN_IF_ERROR(CheckSparseIndices(data));
  RETURN_IF_ERROR(CheckJoints(data));
  ASSIGN_OR_RETURN(FlatScene scene, BuildFlatScene(data, limits, &gltf));
  RETURN_IF_ERROR(CheckFloats(data));
  return scene;
}

}  // namespace halfshade
