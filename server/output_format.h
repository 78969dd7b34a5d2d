// What each kind of image becomes in each encoding: sample type, transfer, channels and their names. Pure.
//
//   kind        PNG               TIFF      JPEG     EXR_HALF, RAW_F16   EXR_FLOAT, RAW_F32   channels in EXR
//   FRAME       8 bit sRGB        as PNG    8 bit    half, linear        float, linear        R G B A
//   ALBEDO      8 bit sRGB        as PNG    8 bit    half, linear        float, linear        albedo.R .G .B
//   VISIBILITY  16 bit linear     as PNG    -        half                float                visibility.0 .1 ...
//   NORMAL      16 bit n/2 + 1/2  as PNG    -        half                float                N.x .y .z
//   OBJECT_ID   16 bit integer    as PNG    -        half                float                id
//   DEPTH       -                 float     -        half                float                Z
//   POSITION    -                 float     -        half                float                P.x .y .z
//   SOFT_SHADOW_MAP  as POSITION                                                              light.visibility .z
//
// "-": refused; JPEG would bend data, PNG has no form for metres. A FRAME has its alpha in EXR and RAW always, in PNG
// and TIFF where the request's alpha says something (a shadow catcher), and then unassociated: colour divided by
// alpha before it becomes sRGB. Half floats round to nearest even; beyond 65504 they are infinite.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <string>
#include <vector>

#include "renderer/request.h"

namespace halfshade {

// The wire's numbers.
enum class Encoding : uint8_t { kPng = 1, kExrHalf, kExrFloat, kJpeg, kTiff, kRawF32, kRawF16 };

enum class SampleType : uint8_t { kUint8, kUint16, kHalf, kFloat };

enum class Transfer : uint8_t {
  kLinear,   // floats as they are; [0,1] to the codes of an integer type, clamped
  kSrgb,     // linear colour to sRGB codes, clamped; a fourth channel is alpha
  kSigned,   // [-1,1] to the codes of an integer type: n/2 + 1/2
  kInteger,  // whole numbers as they are
};

struct OutputFormat {
  Encoding encoding = Encoding::kPng;
  SampleType sample = SampleType::kUint8;
  Transfer transfer = Transfer::kSrgb;
  std::vector<std::string> channels{"R", "G", "B"};  // names; the image's first channels, in order
  std::string layer{};                               // EXR alone; "": a file of its own
};

// `lights`: channels of VISIBILITY. `has_alpha`: a FRAME's alpha says something. INVALID_ARGUMENT with the fault and
// what to ask for instead; the caller puts the field before it.
absl::StatusOr<OutputFormat> FormatOf(OutputKind kind, Encoding encoding, int lights, bool has_alpha);
// Names the layer; it takes the place of the kind's own prefix in the channels' names ("key": key.0, key.R, key.Z).
// INVALID_ARGUMENT for a layer outside EXR, or a name that is not 1 to 64 of A-Z a-z 0-9 _ - . with no dot at its ends.
absl::Status SetLayer(const std::string& layer, OutputFormat* format);

bool IsExr(Encoding encoding);
size_t SampleBytes(SampleType type);
// What the encoder will be given: known before drawing.
uint64_t UncompressedBytes(const OutputFormat& format, int width, int height);

}  // namespace halfshade
