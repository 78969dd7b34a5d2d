// Images to files' bytes. Runs on the encode pool, never on a GL thread; thread-safe. The same image gives the same
// bytes. output_format.h says what each kind becomes.
#pragma once

#include <absl/status/statusor.h>

#include <string>
#include <vector>

#include "renderer/renderer.h"
#include "server/output_format.h"

namespace halfshade {

struct EncodedOutput {
  std::string bytes;
  // Of the pixels as given to the encoder: sample type, little-endian, [row][column][channel].
  std::string pixel_sha256;
  double encode_ms = 0;
  double digest_ms = 0;
};

// images[i] by formats[i]. Images that have a layer become one multi-layer EXR: the first of them carries it, the
// others have no bytes. Every image is freed when it is encoded. Errors: what `stop` returns, which is asked every few
// rows; INVALID_ARGUMENT for whole numbers too large for the encoding; INTERNAL for a NaN in an image or an encoder
// that fails.
absl::StatusOr<std::vector<EncodedOutput>> Encode(std::vector<RenderedImage> images,
                                                  const std::vector<OutputFormat>& formats, const StopCheck& stop);

}  // namespace halfshade
