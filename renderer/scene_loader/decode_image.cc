#include "renderer/scene_loader/decode_image.h"

#include <limits>
#include <memory>
#include <string>

#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STBI_ONLY_PNG
#define STBI_ONLY_JPEG
#define STBI_NO_STDIO
#include <stb/stb_image.h>

#include "renderer/scene_loader/image_header.h"

namespace halfshade {

absl::StatusOr<Rgba8Image> DecodeImage(const EncodedImage& image, uint64_t max_pixels) {
  const ImageHeader header = ReadImageHeader(image.bytes);
  const uint64_t pixels = uint64_t(header.width) * header.height;
  if (header.format == ImageFormat::kUnknown || pixels == 0) {
    return absl::InvalidArgumentError(image.name + ": neither a PNG nor a JPEG");
  }
  if (pixels > max_pixels || image.bytes.size() > size_t(std::numeric_limits<int>::max())) {
    return absl::InvalidArgumentError(image.name + ": " + std::to_string(pixels) + " pixels; at most " +
                                      std::to_string(max_pixels));
  }
  int width = 0, height = 0, channels = 0;
  const std::unique_ptr<stbi_uc, void (*)(void*)> texels(
      stbi_load_from_memory(reinterpret_cast<const stbi_uc*>(image.bytes.data()), int(image.bytes.size()), &width,
                            &height, &channels, 4),
      stbi_image_free);
  if (texels == nullptr) {
    return absl::InvalidArgumentError(image.name + ": does not decode: " + stbi_failure_reason());
  }
  Rgba8Image result;
  result.width = width;
  result.height = height;
  result.texels.assign(texels.get(), texels.get() + size_t(width) * size_t(height) * 4);
  return result;
}

}  // namespace halfshade
