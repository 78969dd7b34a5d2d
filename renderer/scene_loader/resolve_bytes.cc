#include "renderer/scene_loader/validate_parts.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

absl::StatusOr<std::string_view> ResolveUri(const Place& owner, const FileMap& files, Gltf* gltf) {
  RETURN_IF_ERROR(owner.Text("uri").status());
  const Place place = owner.Member("uri");
  const auto& uri = place.json().get_ref<const std::string&>();
  if (IsDataUri(uri)) {
    gltf->decoded.emplace_back();
    if (!DecodeDataUri(uri, &gltf->decoded.back())) return place.Fault("a malformed data URI");
    return gltf->decoded.back();
  }
  std::string path;
  if (!PercentDecode(uri, &path)) return place.Fault(Quoted(uri) + ": a malformed percent escape");
  const auto file = files.find(path);
  if (file == files.end()) return place.Fault(Quoted(uri) + " is not among the files uploaded with the scene");
  return *file->second;
}

absl::Status ResolveBuffer(const GltfContainer& container, const FileMap& files, size_t index, Gltf* gltf) {
  const Place buffer = gltf->At("buffers", index);
  const size_t length = buffer.json()["byteLength"].get<size_t>();
  std::string_view bytes;
  if (buffer.Has("uri")) {
    ASSIGN_OR_RETURN(bytes, ResolveUri(buffer, files, gltf));
  } else if (index == 0 && container.bin != nullptr) {
    bytes = {container.bin, container.bin_size};
    constexpr size_t kPadding = 3;
    if (bytes.size() > length + kPadding) {
      gltf->warnings.Add(buffer.pointer(), std::to_string(bytes.size() - length) + " more bytes in the BIN chunk");
    }
  } else if (gltf->Uses("EXT_meshopt_compression") && IsMeshoptFallback(buffer)) {
    gltf->buffers.emplace_back();  // every view of it is decompressed instead (decompress.cc)
    return absl::OkStatus();
  } else {
    return buffer.Fault("has no uri, and the file has no BIN chunk for it");
  }
  if (bytes.size() < length) {
    return buffer.FaultAt("byteLength",
                          std::to_string(length) + "; there are " + std::to_string(bytes.size()) + " bytes");
  }
  gltf->buffers.push_back(bytes.substr(0, length));
  return absl::OkStatus();
}

absl::Status ResolveImage(const FileMap& files, const Place& image, Gltf* gltf) {
  if (image.Has("uri") == image.Has("bufferView")) return image.Fault("must have a uri or a bufferView, and not both");
  if (image.Has("uri")) {
    ASSIGN_OR_RETURN(const std::string_view bytes, ResolveUri(image, files, gltf));
    gltf->images.push_back(bytes);
    return absl::OkStatus();
  }
  ASSIGN_OR_RETURN(const Place view, gltf->Follow(image, "bufferView", "bufferViews"));
  const std::string_view buffer = gltf->buffers[view.json()["buffer"].get<size_t>()];
  if (buffer.empty()) return image.FaultAt("bufferView", "must not be a compressed view");
  gltf->images.push_back(
      buffer.substr(view.json().value("byteOffset", size_t(0)), view.json()["byteLength"].get<size_t>()));
  return absl::OkStatus();
}

}  // namespace

absl::Status ResolveBytes(const GltfContainer& container, const FileMap& files, Gltf* gltf) {
  for (size_t i = 0; i < gltf->Count("buffers"); ++i) RETURN_IF_ERROR(ResolveBuffer(container, files, i, gltf));
  for (size_t i = 0; i < gltf->Count("images"); ++i) RETURN_IF_ERROR(ResolveImage(files, gltf->At("images", i), gltf));
  return absl::OkStatus();
}

}  // namespace halfshade
