// Float images to the samples that an encoder is given.
#pragma once

#include <absl/status/status.h>

#include <cstddef>

#include "renderer/image/image.h"
#include "server/output_format.h"

namespace halfshade {

// Rows [begin, end) of the image's first format.channels.size() channels, in format's sample type, native byte order,
// [row][column][channel], to `out`, which holds (end - begin) rows. Requires image.channels() >= that many.
// INTERNAL for a NaN; INVALID_ARGUMENT for a whole number that the sample type does not hold exactly (over 65535, in
// half floats over 2048).
absl::Status ConvertRows(const Image& image, const OutputFormat& format, int begin, int end, std::byte* out);

}  // namespace halfshade
