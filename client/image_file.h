// Reads images that `halfshade render` writes.
#pragma once

#include <absl/status/statusor.h>

#include <optional>
#include <string>

#include "renderer/image/image.h"

namespace halfshade {

struct ImageSize {
  int width = 0;
  int height = 0;
};

struct ImageFile {
  Image image;
  bool is_srgb = false;  // 8 bit: code / 255, still sRGB. Else linear: 16 bit as code / 65535, floats as they are.
};

// .f32 and .f16: no header, so that their size comes from elsewhere and their channels from the file's length.
bool IsRawImage(const std::string& path);

// By extension .png .exr .jpg .jpeg .tif .tiff, .f32 .f16 (`raw_size` is needed). Channels in the file's order, alpha
// as the file holds it. NOT_FOUND where it is absent or no regular file; INVALID_ARGUMENT, beginning with the path, for
// an extension that is none of these or a file that cannot be read as what its extension says.
absl::StatusOr<ImageFile> ReadImageFile(const std::string& path, const std::optional<ImageSize>& raw_size);

}  // namespace halfshade
