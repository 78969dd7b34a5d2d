// A PNG or JPEG.
#include <cstdint>

#include "renderer/scene_loader/decode_image.h"
#include "tests/fuzz/flat_scene_use.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace halfshade;
  constexpr uint64_t kMaxPixels = 1 << 18;
  const auto image = DecodeImage({"image", std::string(reinterpret_cast<const char*>(data), size), 0, 0}, kMaxPixels);
  if (image.ok()) {
    Require(image->width > 0 && image->height > 0 && uint64_t(image->width) * uint64_t(image->height) <= kMaxPixels &&
            image->texels.size() == size_t(image->width) * size_t(image->height) * 4);
  } else {
    Require(absl::IsInvalidArgument(image.status()));
  }
  return 0;
}
