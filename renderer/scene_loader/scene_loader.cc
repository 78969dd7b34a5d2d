#include "renderer/scene_loader/scene_loader.h"

#include <cstdlib>
#include <exception>
#include <nlohmann/json.hpp>

#include "renderer/scene_loader/build_scene.h"
#include "renderer/scene_loader/container.h"
#include "renderer/scene_loader/tinygltf.h"
#include "renderer/scene_loader/validate_gltf.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

// tinygltf sees no URI of the file: each buffer is "buffer<i>" and comes from the validated bytes; nothing else can be opened.
constexpr char kBufferPrefix[] = "buffer";

const std::string* FindBuffer(const std::string& path, const std::vector<std::string>& buffers) {
  const size_t at = path.rfind(kBufferPrefix);
  if (at == std::string::npos) return nullptr;
  const size_t index = std::strtoull(path.c_str() + at + sizeof(kBufferPrefix) - 1, nullptr, 10);
  return index < buffers.size() ? &buffers[index] : nullptr;
}

tinygltf::FsCallbacks BufferCallbacks(std::vector<std::string>* buffers) {
  tinygltf::FsCallbacks callbacks{};
  callbacks.FileExists = [](const std::string& path, void* user) {
    return FindBuffer(path, *static_cast<std::vector<std::string>*>(user)) != nullptr;
  };
  callbacks.ExpandFilePath = [](const std::string& path, void*) { return path; };
  callbacks.ReadWholeFile = [](std::vector<unsigned char>* out, std::string*, const std::string& path, void* user) {
    const std::string* bytes = FindBuffer(path, *static_cast<std::vector<std::string>*>(user));
    if (bytes == nullptr) return false;
    out->assign(bytes->begin(), bytes->end());
    return true;
  };
  callbacks.WriteWholeFile = [](std::string*, const std::string&, const std::vector<unsigned char>&, void*) {
    return false;
  };
  callbacks.user_data = buffers;
  return callbacks;
}

// What tinygltf does not need, it does not get: extensions, extras, images (they stay encoded), the URIs of buffers.
void Strip(nlohmann::json& json) {
  if (json.is_object()) {
    json.erase("extensions");
    json.erase("extras");
  }
  if (json.is_structured()) {
    for (auto& element : json) Strip(element);
  }
}

absl::StatusOr<tinygltf::Model> ParseModel(ValidGltf& valid) {
  Strip(valid.json);
  for (const char* name : {"images", "extensionsUsed", "extensionsRequired", "skins", "animations"}) valid.json.erase(name);
  if (valid.json.contains("nodes")) {
    for (auto& node : valid.json["nodes"]) node.erase("skin");
  }
  for (size_t i = 0; i < valid.buffers.size(); ++i) {
    valid.json["buffers"][i]["uri"] = kBufferPrefix + std::to_string(i);
    // tinygltf wants the file to be no longer than byteLength says.
    valid.buffers[i].resize(valid.json["buffers"][i]["byteLength"].get<size_t>());
  }
  const std::string text = valid.json.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
  tinygltf::TinyGLTF loader;
  loader.SetFsCallbacks(BufferCallbacks(&valid.buffers));
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
  if (root.size() > limits.max_scene_bytes) {
    return absl::InvalidArgumentError("/: " + std::to_string(root.size()) + " bytes; at most " +
                                      std::to_string(limits.max_scene_bytes));
  }
  ASSIGN_OR_RETURN(const GltfContainer container, OpenContainer(root, limits));
  ASSIGN_OR_RETURN(ValidGltf valid, ValidateGltf(container, files, limits));
  const uint32_t animations = valid.json.contains("animations") ? uint32_t(valid.json["animations"].size()) : 0;
  ASSIGN_OR_RETURN(const tinygltf::Model model, ParseModel(valid));
  ASSIGN_OR_RETURN(FlatScene scene,
                   BuildFlatScene(model, std::move(valid.images), std::move(valid.warnings), limits));
  scene.animation_count = animations;
  return scene;
}

}  // namespace halfshade
