#include "server/samples.h"

#include <Imath/half.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "renderer/image/srgb.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

using Half = Imath::half;

// Up to here every whole number has a sample of its own.
float LargestInteger(SampleType type) {
  switch (type) {
    case SampleType::kUint8:
      return 255;
    case SampleType::kUint16:
      return 65535;
    case SampleType::kHalf:
      return 2048;
    case SampleType::kFloat:
      break;
  }
  return 16777216;
}

absl::Status CheckValues(const float* values, size_t count, const OutputFormat& format) {
  if (std::any_of(values, values + count, [](float value) { return std::isnan(value); })) {
    return absl::InternalError("encode: the image holds a NaN");
  }
  if (format.transfer != Transfer::kInteger) return absl::OkStatus();
  const float largest = LargestInteger(format.sample);
  const float found = *std::max_element(values, values + count);
  if (found <= largest) return absl::OkStatus();
  return absl::InvalidArgumentError("outputs: the number " + std::to_string(uint64_t(std::min(found, 1e18f))) +
                                    " in an OBJECT_ID; this encoding holds up to " + std::to_string(uint64_t(largest)) +
                                    ", ask for EXR_FLOAT or RAW_F32");
}

template <typename Code>
Code ToCode(float unit) {
  constexpr float kMax = float(Code(-1));
  return Code(std::lround(std::clamp(unit, 0.0f, 1.0f) * kMax));
}

template <typename Code>
Code ToInteger(float value) {
  return Code(std::lround(std::max(value, 0.0f)));
}

// Every value of the pixels' first channels.
template <typename Sample, typename Function>
void ForEach(const float* pixels, size_t count, int stride, size_t channels, std::byte* out, Function to_sample) {
  auto* samples = reinterpret_cast<Sample*>(out);
  for (size_t i = 0; i < count; ++i) {
    const float* pixel = pixels + i * size_t(stride);
    for (size_t c = 0; c < channels; ++c) *samples++ = to_sample(pixel[c]);
  }
}

void ToSrgb(const float* pixels, size_t count, int stride, size_t channels, std::byte* out) {
  auto* codes = reinterpret_cast<uint8_t*>(out);
  for (size_t i = 0; i < count; ++i) {
    const float* pixel = pixels + i * size_t(stride);
    const bool has_alpha = channels == 4;
    const float scale = has_alpha && pixel[3] > 0 ? 1 / pixel[3] : 1;
    for (size_t c = 0; c < 3; ++c) *codes++ = LinearToSrgb8(pixel[c] * scale);
    if (has_alpha) *codes++ = ToCode<uint8_t>(pixel[3]);
  }
}

}  // namespace

absl::Status ConvertRows(const Image& image, const OutputFormat& format, int begin, int end, std::byte* out) {
  const size_t row = size_t(image.width()) * size_t(image.channels());
  const float* pixels = image.data() + size_t(begin) * row;
  const size_t count = size_t(end - begin) * size_t(image.width());
  const size_t channels = format.channels.size();
  const int stride = image.channels();
  RETURN_IF_ERROR(CheckValues(pixels, size_t(end - begin) * row, format));
  switch (format.sample) {
    case SampleType::kFloat:
      ForEach<float>(pixels, count, stride, channels, out, [](float value) { return value; });
      break;
    case SampleType::kHalf:
      ForEach<Half>(pixels, count, stride, channels, out, [](float value) { return Half(value); });
      break;
    case SampleType::kUint16:
      if (format.transfer == Transfer::kInteger) {
        ForEach<uint16_t>(pixels, count, stride, channels, out, ToInteger<uint16_t>);
      } else if (format.transfer == Transfer::kSigned) {
        ForEach<uint16_t>(pixels, count, stride, channels, out, [](float n) { return ToCode<uint16_t>(n / 2 + 0.5f); });
      } else {
        ForEach<uint16_t>(pixels, count, stride, channels, out, ToCode<uint16_t>);
      }
      break;
    case SampleType::kUint8:
      ToSrgb(pixels, count, stride, channels, out);
      break;
  }
  return absl::OkStatus();
}

}  // namespace halfshade
