#include "server/output_format.h"

#include <algorithm>

namespace halfshade {
namespace {

constexpr size_t kMaxPngChannels = 4;
constexpr size_t kMaxLayerCharacters = 64;  // EXR holds names of 255, channel included

// What a kind's values are, which decides how an integer type may hold them.
enum class Content { kColour, kShare, kDirection, kIndex, kMetres };

Content ContentOf(OutputKind kind) {
  switch (kind) {
    case OutputKind::kFrame:
    case OutputKind::kAlbedo:
      return Content::kColour;
    case OutputKind::kNormal:
      return Content::kDirection;
    case OutputKind::kObjectId:
      return Content::kIndex;
    case OutputKind::kDepth:
    case OutputKind::kPosition:
    case OutputKind::kSoftShadowMap:
    case OutputKind::kPenumbraWidth:
      return Content::kMetres;
    case OutputKind::kVisibility:
      break;
  }
  return Content::kShare;
}

std::vector<std::string> ChannelsOf(OutputKind kind, int lights) {
  switch (kind) {
    case OutputKind::kFrame:
      return {"R", "G", "B", "A"};
    case OutputKind::kAlbedo:
      return {"albedo.R", "albedo.G", "albedo.B"};
    case OutputKind::kNormal:
      return {"N.x", "N.y", "N.z"};
    case OutputKind::kObjectId:
      return {"id"};
    case OutputKind::kDepth:
      return {"Z"};
    case OutputKind::kPosition:
      return {"P.x", "P.y", "P.z"};
    case OutputKind::kSoftShadowMap:
      return {"light.visibility", "light.z"};
    default:
      break;
  }
  const std::string name = kind == OutputKind::kPenumbraWidth ? "penumbra_width." : "visibility.";
  std::vector<std::string> names;
  for (int i = 0; i < lights; ++i) names.push_back(name + std::to_string(i));
  return names;
}

// PNG and TIFF: what is not metres becomes integers.
void SetIntegers(Content content, OutputFormat* format) {
  format->sample = content == Content::kColour ? SampleType::kUint8 : SampleType::kUint16;
  format->transfer = content == Content::kColour      ? Transfer::kSrgb
                     : content == Content::kDirection ? Transfer::kSigned
                     : content == Content::kIndex     ? Transfer::kInteger
                                                      : Transfer::kLinear;
}

void SetFloats(SampleType sample, Content content, OutputFormat* format) {
  format->sample = sample;
  format->transfer = content == Content::kIndex ? Transfer::kInteger : Transfer::kLinear;
}

bool IsLayerCharacter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-' || c == '.';
}

}  // namespace

bool IsExr(Encoding encoding) { return encoding == Encoding::kExrHalf || encoding == Encoding::kExrFloat; }

size_t SampleBytes(SampleType type) {
  switch (type) {
    case SampleType::kUint8:
      return 1;
    case SampleType::kUint16:
    case SampleType::kHalf:
      return 2;
    case SampleType::kFloat:
      break;
  }
  return 4;
}

absl::StatusOr<OutputFormat> FormatOf(OutputKind kind, Encoding encoding, int lights, bool has_alpha) {
  OutputFormat format{.encoding = encoding, .channels = ChannelsOf(kind, lights)};
  const Content content = ContentOf(kind);
  const bool keeps_alpha = kind == OutputKind::kFrame && has_alpha;
  const auto drop_alpha = [&] {
    if (kind == OutputKind::kFrame && !keeps_alpha) format.channels.pop_back();
  };
  switch (encoding) {
    case Encoding::kExrHalf:
    case Encoding::kRawF16:
      SetFloats(SampleType::kHalf, content, &format);
      break;
    case Encoding::kExrFloat:
    case Encoding::kRawF32:
      SetFloats(SampleType::kFloat, content, &format);
      break;
    case Encoding::kJpeg:
      if (content != Content::kColour) {
        return absl::InvalidArgumentError("JPEG holds colours (FRAME, ALBEDO); ask for EXR_FLOAT or RAW_F32");
      }
      if (keeps_alpha) return absl::InvalidArgumentError("JPEG holds no alpha; ask for PNG or EXR_HALF");
      drop_alpha();
      break;
    case Encoding::kTiff:
      if (content == Content::kMetres) {
        SetFloats(SampleType::kFloat, content, &format);
        break;
      }
      SetIntegers(content, &format);
      drop_alpha();
      break;
    case Encoding::kPng:
      if (content == Content::kMetres) {
        return absl::InvalidArgumentError("PNG holds no metres; ask for EXR_FLOAT, TIFF or RAW_F32");
      }
      if (kind == OutputKind::kVisibility && format.channels.size() > kMaxPngChannels) {
        return absl::InvalidArgumentError("PNG holds 4 channels, the request has " + std::to_string(lights) +
                                          " lights; ask for EXR_FLOAT, TIFF or RAW_F32");
      }
      SetIntegers(content, &format);
      drop_alpha();
      break;
  }
  return format;
}

absl::Status SetLayer(const std::string& layer, OutputFormat* format) {
  if (!IsExr(format->encoding)) return absl::InvalidArgumentError("only EXR_HALF and EXR_FLOAT have layers");
  if (layer.empty() || layer.size() > kMaxLayerCharacters || layer.front() == '.' || layer.back() == '.' ||
      !std::all_of(layer.begin(), layer.end(), IsLayerCharacter)) {
    return absl::InvalidArgumentError("must be 1 to " + std::to_string(kMaxLayerCharacters) +
                                      " of A-Z a-z 0-9 _ - . with no dot at its ends");
  }
  format->layer = layer;
  for (std::string& name : format->channels) name = layer + "." + name.substr(name.find('.') + 1);
  return absl::OkStatus();
}

uint64_t UncompressedBytes(const OutputFormat& format, int width, int height) {
  return uint64_t(width) * uint64_t(height) * format.channels.size() * SampleBytes(format.sample);
}

}  // namespace halfshade
