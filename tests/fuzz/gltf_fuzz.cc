// A glTF or GLB, and the images that it carries.
#include <cstdint>

#include "renderer/scene_loader/decode_image.h"
#include "renderer/scene_loader/scene_loader.h"
#include "tests/fuzz/flat_scene_use.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace halfshade;
  const std::string root(reinterpret_cast<const char*>(data), size);
  const std::string zeros(4096, '\0');
  SceneLoadLimits limits;
  limits.max_scene_bytes = 16 << 20;
  limits.max_triangles = 20000;
  limits.max_texture_pixels = 1 << 16;
  const auto scene = LoadGltf(root, {{"buffer.bin", &zeros}, {"image.png", &root}}, limits);
  if (!scene.ok()) {
    Require(absl::IsInvalidArgument(scene.status()));
    return 0;
  }
  UseLoadedScene(*scene);
  for (const EncodedImage& image : scene->images) (void)DecodeImage(image, limits.max_texture_pixels).ok();
  return 0;
}
