#include "server/encode.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <vector>

#include "renderer/image/srgb.h"
#include "renderer/status.h"
#include "server/digest.h"

namespace halfshade {
namespace {

static_assert(std::endian::native == std::endian::little, "raw files are little-endian");

// zlib's level. Frames of soft shadows at 1280x720 (bunny, plant, colonnade): level 1 is about twice as fast as the
// usual 6 and 27 to 33 % larger, 0.20 to 0.27 MB; level 3 is 6 to 8 % smaller than 1 and a fifth slower. A service
// waits for its encoder more often than for its network.
constexpr int kPngLevel = 1;

class Stopwatch {
 public:
  double Milliseconds() const {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start_).count();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

std::vector<uint8_t> FrameToSrgb8(const Image& image) {
  std::vector<uint8_t> pixels(size_t(image.width()) * image.height() * 3);
  for (size_t i = 0; i < pixels.size() / 3; ++i) {
    for (size_t c = 0; c < 3; ++c) pixels[3 * i + c] = LinearToSrgb8(image.data()[4 * i + c]);
  }
  return pixels;
}

std::vector<uint16_t> ToUnorm16(const Image& image) {
  std::vector<uint16_t> values(image.size());
  for (size_t i = 0; i < image.size(); ++i) {
    values[i] = uint16_t(std::lround(std::clamp(image.data()[i], 0.0f, 1.0f) * 65535.0f));
  }
  return values;
}

uint64_t Channels(OutputKind kind, int lights) {
  switch (kind) {
    case OutputKind::kFrame:
      return 4;
    case OutputKind::kNormal:
    case OutputKind::kAlbedo:
    case OutputKind::kPosition:
      return 3;
    case OutputKind::kDepth:
    case OutputKind::kObjectId:
      return 1;
    default:
      return uint64_t(lights);
  }
}

template <typename Sample>
absl::Status WritePng(const Image& image, const std::vector<Sample>& samples, EncodedImage2D* out) {
  const Stopwatch digest_watch;
  out->pixel_sha256 = Sha256Hex(samples.data(), samples.size() * sizeof(Sample));
  out->digest_ms = digest_watch.Milliseconds();
  const auto type = sizeof(Sample) == 1 ? OIIO::TypeDesc::UINT8 : OIIO::TypeDesc::UINT16;
  OIIO::ImageSpec spec(image.width(), image.height(), out->channels, type);
  spec.attribute("png:compressionLevel", kPngLevel);
  if (sizeof(Sample) == 2) spec.attribute("oiio:ColorSpace", "linear");
  try {
    std::vector<unsigned char> bytes;
    OIIO::Filesystem::IOVecOutput sink(bytes);
    const auto png = OIIO::ImageOutput::create("out.png");
    if (png == nullptr) return absl::InternalError("encode: OpenImageIO has no PNG writer");
    png->set_ioproxy(&sink);
    if (!png->open("out.png", spec) || !png->write_image(type, samples.data()) || !png->close()) {
      return absl::InternalError("encode: " + png->geterror());
    }
    out->bytes.assign(bytes.begin(), bytes.end());
  } catch (const std::exception& error) {
    return absl::InternalError(std::string("encode: ") + error.what());
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<EncodedImage2D> Encode(const RenderedImage& rendered, Encoding encoding) {
  const Image& image = rendered.image;
  if (std::any_of(image.data(), image.data() + image.size(), [](float value) { return std::isnan(value); })) {
    return absl::InternalError("encode: the image holds a NaN");
  }
  const Stopwatch watch;
  EncodedImage2D result;
  result.channels = image.channels();
  if (encoding == Encoding::kRawF32) {
    const Stopwatch digest_watch;
    result.pixel_sha256 = Sha256Hex(image.data(), image.size() * sizeof(float));
    result.digest_ms = digest_watch.Milliseconds();
    result.bytes.assign(reinterpret_cast<const char*>(image.data()), image.size() * sizeof(float));
  } else if (rendered.kind == OutputKind::kFrame) {
    result.channels = 3;
    RETURN_IF_ERROR(WritePng(image, FrameToSrgb8(image), &result));
  } else {
    RETURN_IF_ERROR(WritePng(image, ToUnorm16(image), &result));
  }
  result.encode_ms = watch.Milliseconds() - result.digest_ms;
  return result;
}

uint64_t UncompressedBytes(OutputKind kind, Encoding encoding, int width, int height, int lights) {
  const uint64_t pixels = uint64_t(width) * uint64_t(height);
  if (encoding == Encoding::kRawF32) return pixels * 4 * Channels(kind, lights);
  return pixels * (kind == OutputKind::kFrame ? 3 : 2 * uint64_t(lights));
}

}  // namespace halfshade
