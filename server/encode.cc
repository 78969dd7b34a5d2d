#include "server/encode.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <chrono>
#include <cstring>
#include <map>
#include <mutex>
#include <optional>

#include "renderer/status.h"
#include "server/digest.h"
#include "server/samples.h"

namespace halfshade {
namespace {

static_assert(std::endian::native == std::endian::little, "raw files and digests are little-endian");

// zlib's level. Frames of soft shadows at 1280x720 (bunny, plant, colonnade): level 1 is about twice as fast as the
// usual 6 and 27 to 33 % larger, 0.20 to 0.27 MB; level 3 is 6 to 8 % smaller than 1 and a fifth slower. A service
// waits for its encoder more often than for its network.
constexpr int kPngLevel = 1;
// The same trade for EXR and TIFF. A frame of the bunny at 1280x720, CPU ms and MB: half 23 / .43 (level 4, the
// default: 34 / .33), float 72 / 2.81 (97 / 2.77); piz is slower and larger, no compression 9 / 7.4 and 20 / 14.8.
constexpr char kZip[] = "zip:1";
constexpr int kJpegQuality = 95;
// Rows that are converted, digested and encoded at a time: a multiple of the 16 of EXR's zip, few enough to stop soon.
constexpr int kStripRows = 64;

class Stopwatch {
 public:
  double Milliseconds() const {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start_).count();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

// Where OpenImageIO writes: straight into a string, which may be sought in (EXR writes its table of offsets last).
class StringOutput final : public OIIO::Filesystem::IOProxy {
 public:
  explicit StringOutput(std::string* bytes) : IOProxy("", Write), bytes_(bytes) {}
  const char* proxytype() const override { return "string"; }
  size_t write(const void* data, size_t size) override {
    const size_t written = pwrite(data, size, m_pos);
    m_pos += int64_t(written);
    return written;
  }
  size_t pwrite(const void* data, size_t size, int64_t offset) override {
    if (offset < 0) return 0;
    if (bytes_->size() < size_t(offset) + size) bytes_->resize(size_t(offset) + size);
    std::memcpy(bytes_->data() + offset, data, size);
    return size;
  }
  size_t size() const override { return bytes_->size(); }

 private:
  std::string* bytes_;
};

// An image on its way into a file, alone or as a layer.
struct Part {
  const Image* image;
  const OutputFormat* format;
  EncodedOutput* out;
  std::optional<LightGrid> grid{};  // of a soft shadow map
  Sha256 sha{};
  std::vector<std::byte> strip{};

  size_t PixelBytes() const { return format->channels.size() * SampleBytes(format->sample); }
};

OIIO::TypeDesc TypeOf(SampleType type) {
  switch (type) {
    case SampleType::kUint8:
      return OIIO::TypeDesc::UINT8;
    case SampleType::kUint16:
      return OIIO::TypeDesc::UINT16;
    case SampleType::kHalf:
      return OIIO::TypeDesc::HALF;
    case SampleType::kFloat:
      break;
  }
  return OIIO::TypeDesc::FLOAT;
}

const char* FileName(Encoding encoding) {
  switch (encoding) {
    case Encoding::kPng:
      return "out.png";
    case Encoding::kJpeg:
      return "out.jpg";
    case Encoding::kTiff:
      return "out.tif";
    default:
      return "out.exr";
  }
}

// Each exact, with spaces between.
std::string NumbersText(const double* values, int count) {
  std::string text;
  for (int i = 0; i < count; ++i) {
    char number[32];
    const auto end = std::to_chars(number, number + sizeof(number), values[i]).ptr;
    if (i > 0) text += ' ';
    text.append(number, end);
  }
  return text;
}

OIIO::ImageSpec SpecOf(const std::vector<Part>& parts) {
  const OutputFormat& first = *parts[0].format;
  OIIO::ImageSpec spec(parts[0].image->width(), parts[0].image->height(), 0, TypeOf(first.sample));
  spec.channelnames.clear();
  for (const Part& part : parts) {
    for (const std::string& name : part.format->channels) {
      spec.channelnames.push_back(name);
      if (parts.size() > 1) spec.channelformats.push_back(TypeOf(part.format->sample));
    }
  }
  spec.nchannels = int(spec.channelnames.size());
  const bool has_alpha = first.transfer == Transfer::kSrgb && spec.nchannels == 4;
  spec.alpha_channel = has_alpha ? 3 : -1;
  spec.z_channel = -1;
  // Pixels come as the file is to hold them.
  spec.attribute("oiio:UnassociatedAlpha", 1);
  if (first.encoding == Encoding::kPng) {
    spec.attribute("png:compressionLevel", kPngLevel);
    // To the other formats a colour space says nothing, and makes OpenImageIO 2.4 write an EXIF directory after which a
    // TIFF's header points to the wrong one.
    if (first.transfer != Transfer::kSrgb) spec.attribute("oiio:ColorSpace", "linear");
  }
  // "Unknown", in place of the time of writing, which TIFF and EXR get else: the same image gives the same bytes.
  if (first.encoding == Encoding::kTiff || IsExr(first.encoding)) {
    spec.attribute("DateTime", "0000:00:00 00:00:00");
    spec.attribute("compression", kZip);
  }
  for (const Part& part : parts) {
    if (part.grid && IsExr(first.encoding)) {
      spec.attribute("light_from_world", NumbersText(&part.grid->light_from_world[0][0], 16));
      spec.attribute("light_window", NumbersText(&part.grid->window[0], 4));
    }
  }
  if (first.encoding == Encoding::kJpeg) spec.attribute("compression", "jpeg:" + std::to_string(kJpegQuality));
  return spec;
}

// Converts and digests rows [begin, end) of every part; the digest's time goes to the part.
absl::Status TakeStrip(std::vector<Part>& parts, int begin, int end) {
  for (Part& part : parts) {
    part.strip.resize(size_t(end - begin) * size_t(part.image->width()) * part.PixelBytes());
    RETURN_IF_ERROR(ConvertRows(*part.image, *part.format, begin, end, part.strip.data()));
    const Stopwatch watch;
    part.sha.Add(part.strip.data(), part.strip.size());
    part.out->digest_ms += watch.Milliseconds();
  }
  return absl::OkStatus();
}

// The parts' strips pixel by pixel.
std::vector<std::byte> Interleave(const std::vector<Part>& parts) {
  size_t total = 0;
  for (const Part& part : parts) total += part.strip.size();
  std::vector<std::byte> pixels(total);
  std::byte* to = pixels.data();
  const size_t count = parts[0].strip.size() / parts[0].PixelBytes();
  for (size_t i = 0; i < count; ++i) {
    for (const Part& part : parts) {
      const size_t size = part.PixelBytes();
      std::memcpy(to, part.strip.data() + i * size, size);
      to += size;
    }
  }
  return pixels;
}

// Calls write(begin, end) on one strip after the other.
template <typename WriteStrip>
absl::Status ForEachStrip(std::vector<Part>& parts, const StopCheck& stop, WriteStrip write) {
  const int height = parts[0].image->height();
  for (int begin = 0; begin < height; begin += kStripRows) {
    RETURN_IF_ERROR(stop());
    const int end = std::min(height, begin + kStripRows);
    RETURN_IF_ERROR(TakeStrip(parts, begin, end));
    RETURN_IF_ERROR(write(begin, end));
  }
  return absl::OkStatus();
}

absl::Status WriteRaw(std::vector<Part>& parts, const StopCheck& stop) {
  std::string& bytes = parts[0].out->bytes;
  bytes.reserve(UncompressedBytes(*parts[0].format, parts[0].image->width(), parts[0].image->height()));
  return ForEachStrip(parts, stop, [&](int, int) {
    bytes.append(reinterpret_cast<const char*>(parts[0].strip.data()), parts[0].strip.size());
    return absl::OkStatus();
  });
}

// An encoder keeps to its own thread: the encode pool has one for each CPU that the process may use.
void LimitEncoderThreads() {
  static std::once_flag once;
  std::call_once(once, [] {
    OIIO::attribute("threads", 1);
    OIIO::attribute("exr_threads", -1);  // no pool of OpenEXR's own
  });
}

absl::Status WriteFile(std::vector<Part>& parts, const StopCheck& stop) {
  LimitEncoderThreads();
  const char* name = FileName(parts[0].format->encoding);
  const OIIO::ImageSpec spec = SpecOf(parts);
  StringOutput sink(&parts[0].out->bytes);
  const auto file = OIIO::ImageOutput::create(name, &sink);
  if (file == nullptr || !file->supports("ioproxy")) {
    return absl::InternalError(std::string("encode: OpenImageIO has no writer for ") + name);
  }
  const auto failed = [&] { return absl::InternalError("encode: " + file->geterror()); };
  if (!file->open(name, spec)) return failed();
  RETURN_IF_ERROR(ForEachStrip(parts, stop, [&](int begin, int end) {
    // Several parts have sample types of their own, and "unknown" is each channel's own.
    const bool is_ok = parts.size() == 1 ? file->write_scanlines(begin, end, 0, spec.format, parts[0].strip.data())
                                         : file->write_scanlines(begin, end, 0, OIIO::TypeDesc(OIIO::TypeDesc::UNKNOWN),
                                                                 Interleave(parts).data());
    return is_ok ? absl::OkStatus() : failed();
  }));
  return file->close() ? absl::OkStatus() : failed();
}

absl::Status EncodeFile(std::vector<Part> parts, const StopCheck& stop) {
  const Stopwatch watch;
  const Encoding encoding = parts[0].format->encoding;
  try {
    const bool is_raw = encoding == Encoding::kRawF32 || encoding == Encoding::kRawF16;
    RETURN_IF_ERROR(is_raw ? WriteRaw(parts, stop) : WriteFile(parts, stop));
  } catch (const std::exception& error) {
    return absl::InternalError(std::string("encode: ") + error.what());
  }
  double digest_ms = 0;
  for (Part& part : parts) {
    part.out->pixel_sha256 = part.sha.FinishHex();
    digest_ms += part.out->digest_ms;
  }
  parts[0].out->encode_ms = watch.Milliseconds() - digest_ms;
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<std::vector<EncodedOutput>> Encode(std::vector<RenderedImage> images,
                                                  const std::vector<OutputFormat>& formats, const StopCheck& stop) {
  // Which images share a file, by that file's first.
  std::map<size_t, std::vector<size_t>> files;
  std::optional<size_t> first_layer;
  for (size_t i = 0; i < images.size(); ++i) {
    const bool is_layer = !formats[i].layer.empty();
    if (is_layer && !first_layer) first_layer = i;
    files[is_layer ? *first_layer : i].push_back(i);
  }
  std::vector<EncodedOutput> outputs(images.size());
  for (const auto& [first, members] : files) {
    std::vector<Part> parts;
    for (const size_t i : members) parts.push_back({&images[i].image, &formats[i], &outputs[i], images[i].grid});
    RETURN_IF_ERROR(EncodeFile(std::move(parts), stop));
    for (const size_t i : members) images[i].image = Image();
  }
  return outputs;
}

}  // namespace halfshade
