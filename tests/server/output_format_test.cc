#include "server/output_format.h"

#include <gtest/gtest.h>

#include <map>

#include "server/report_to_proto.h"
#include "tests/support/status_matchers.h"

namespace halfshade {
namespace {

using absl::StatusCode;
using testing::HasSubstr;
using Strings = std::vector<std::string>;

constexpr Encoding kAllEncodings[] = {Encoding::kPng,  Encoding::kExrHalf, Encoding::kExrFloat, Encoding::kJpeg,
                                      Encoding::kTiff, Encoding::kRawF32,  Encoding::kRawF16};

// The table of output_format.h: PNG, EXR_HALF, EXR_FLOAT, JPEG, TIFF, RAW_F32, RAW_F16; c colour, u share, s direction,
// i integer in the integer types, h half, f float, - refused.
TEST(OutputFormatTest, EveryKindInEveryEncodingIsWhatTheTableSays) {
  const std::map<OutputKind, std::string> table = {
      {OutputKind::kFrame, "chfccfh"},    {OutputKind::kAlbedo, "chfccfh"},        {OutputKind::kVisibility, "uhf-ufh"},
      {OutputKind::kNormal, "shf-sfh"},   {OutputKind::kObjectId, "ihf-ifh"},      {OutputKind::kDepth, "-hf-ffh"},
      {OutputKind::kPosition, "-hf-ffh"}, {OutputKind::kPenumbraWidth, "-hf-ffh"},
  };
  for (const auto& [kind, row] : table) {
    for (size_t i = 0; i < row.size(); ++i) {
      SCOPED_TRACE(ShortName(ToProto(kind)) + " " + ShortName(ToProto(kAllEncodings[i])));
      const auto format = FormatOf(kind, kAllEncodings[i], 2, false);
      if (row[i] == '-') {
        EXPECT_THAT(format, StatusIs(StatusCode::kInvalidArgument, HasSubstr("ask for EXR_FLOAT")));
        continue;
      }
      ASSERT_OK(format);
      EXPECT_EQ(format->encoding, kAllEncodings[i]);
      const SampleType sample = row[i] == 'c'   ? SampleType::kUint8
                                : row[i] == 'h' ? SampleType::kHalf
                                : row[i] == 'f' ? SampleType::kFloat
                                                : SampleType::kUint16;
      EXPECT_EQ(format->sample, sample);
      const Transfer transfer = kind == OutputKind::kObjectId ? Transfer::kInteger
                                : row[i] == 'c'               ? Transfer::kSrgb
                                : row[i] == 's'               ? Transfer::kSigned
                                                              : Transfer::kLinear;
      EXPECT_EQ(format->transfer, transfer);
    }
  }
}

TEST(OutputFormatTest, ChannelsAreNamed) {
  const auto names = [](OutputKind kind) { return FormatOf(kind, Encoding::kExrFloat, 2, false)->channels; };
  EXPECT_EQ(names(OutputKind::kFrame), Strings({"R", "G", "B", "A"}));
  EXPECT_EQ(names(OutputKind::kVisibility), Strings({"visibility.0", "visibility.1"}));
  EXPECT_EQ(names(OutputKind::kPenumbraWidth), Strings({"penumbra_width.0", "penumbra_width.1"}));
  EXPECT_EQ(names(OutputKind::kDepth), Strings({"Z"}));
  EXPECT_EQ(names(OutputKind::kNormal), Strings({"N.x", "N.y", "N.z"}));
  EXPECT_EQ(names(OutputKind::kPosition), Strings({"P.x", "P.y", "P.z"}));
  EXPECT_EQ(names(OutputKind::kObjectId), Strings({"id"}));
  EXPECT_EQ(names(OutputKind::kAlbedo), Strings({"albedo.R", "albedo.G", "albedo.B"}));
}

TEST(OutputFormatTest, AFramesAlphaIsKeptWhereItSaysSomethingAndRefusedWhereItWouldBeLost) {
  for (const Encoding encoding : {Encoding::kPng, Encoding::kTiff}) {
    EXPECT_EQ(FormatOf(OutputKind::kFrame, encoding, 1, false)->channels.size(), 3u);
    EXPECT_EQ(FormatOf(OutputKind::kFrame, encoding, 1, true)->channels.size(), 4u);
    EXPECT_EQ(FormatOf(OutputKind::kAlbedo, encoding, 1, true)->channels.size(), 3u);
  }
  EXPECT_THAT(FormatOf(OutputKind::kFrame, Encoding::kJpeg, 1, true),
              StatusIs(StatusCode::kInvalidArgument, HasSubstr("JPEG holds no alpha")));
  EXPECT_EQ(FormatOf(OutputKind::kFrame, Encoding::kJpeg, 1, false)->channels.size(), 3u);
  EXPECT_EQ(FormatOf(OutputKind::kAlbedo, Encoding::kJpeg, 1, true)->channels.size(), 3u);
}

TEST(OutputFormatTest, PngHoldsFourLightsAndTheOthersMore) {
  EXPECT_OK(FormatOf(OutputKind::kVisibility, Encoding::kPng, 4, false));
  EXPECT_THAT(FormatOf(OutputKind::kVisibility, Encoding::kPng, 5, false),
              StatusIs(StatusCode::kInvalidArgument, HasSubstr("the request has 5 lights")));
  EXPECT_EQ(FormatOf(OutputKind::kVisibility, Encoding::kTiff, 5, false)->channels.size(), 5u);
  EXPECT_EQ(FormatOf(OutputKind::kVisibility, Encoding::kRawF16, 64, false)->channels.size(), 64u);
}

TEST(OutputFormatTest, ALayerTakesThePlaceOfTheKindsOwnPrefix) {
  const auto names = [](OutputKind kind) {
    OutputFormat format = *FormatOf(kind, Encoding::kExrHalf, 1, false);
    EXPECT_OK(SetLayer("key", &format));
    EXPECT_EQ(format.layer, "key");
    return format.channels;
  };
  EXPECT_EQ(names(OutputKind::kFrame), Strings({"key.R", "key.G", "key.B", "key.A"}));
  EXPECT_EQ(names(OutputKind::kVisibility), Strings({"key.0"}));
  EXPECT_EQ(names(OutputKind::kNormal), Strings({"key.x", "key.y", "key.z"}));
  EXPECT_EQ(names(OutputKind::kDepth), Strings({"key.Z"}));
}

TEST(OutputFormatTest, ALayerNeedsExrAndAName) {
  OutputFormat png = *FormatOf(OutputKind::kFrame, Encoding::kPng, 1, false);
  EXPECT_THAT(SetLayer("key", &png), StatusIs(StatusCode::kInvalidArgument, HasSubstr("only EXR_HALF and EXR_FLOAT")));
  OutputFormat exr = *FormatOf(OutputKind::kFrame, Encoding::kExrHalf, 1, false);
  for (const std::string& name : {std::string(64, 'a'), std::string("a"), std::string("a.B_9-z")}) {
    OutputFormat format = exr;
    EXPECT_OK(SetLayer(name, &format)) << name;
  }
  for (const std::string& name : {std::string(65, 'a'), std::string("a b"), std::string("a/b"), std::string(".a"),
                                  std::string("a."), std::string("\xc3\xa4"), std::string("a\0b", 3)}) {
    EXPECT_THAT(SetLayer(name, &exr), StatusIs(StatusCode::kInvalidArgument, HasSubstr("must be 1 to 64"))) << name;
  }
}

TEST(OutputFormatTest, UncompressedBytesCountWhatTheEncoderGets) {
  const auto bytes = [](OutputKind kind, Encoding encoding) {
    return UncompressedBytes(*FormatOf(kind, encoding, 2, false), 10, 10);
  };
  EXPECT_EQ(bytes(OutputKind::kFrame, Encoding::kPng), 300u);
  EXPECT_EQ(bytes(OutputKind::kFrame, Encoding::kRawF32), 1600u);
  EXPECT_EQ(bytes(OutputKind::kFrame, Encoding::kExrHalf), 800u);
  EXPECT_EQ(bytes(OutputKind::kVisibility, Encoding::kPng), 400u);
  EXPECT_EQ(bytes(OutputKind::kVisibility, Encoding::kRawF32), 800u);
  EXPECT_EQ(bytes(OutputKind::kDepth, Encoding::kTiff), 400u);
  EXPECT_EQ(UncompressedBytes(*FormatOf(OutputKind::kFrame, Encoding::kRawF32, 1, false), 16384, 16384), 4ull << 30);
}

TEST(OutputNamesTest, KindsAndEncodingsGoOverTheWireAndBack) {
  for (int i = 1; i < v1::OutputKind_ARRAYSIZE; ++i) EXPECT_EQ(ToProto(*FromProto(v1::OutputKind(i))), i);
  for (int i = 1; i < v1::Encoding_ARRAYSIZE; ++i) EXPECT_EQ(ToProto(*FromProto(v1::Encoding(i))), i);
  EXPECT_EQ(FromProto(v1::OUTPUT_KIND_UNSPECIFIED), OutputKind::kFrame);
  EXPECT_EQ(FromProto(v1::ENCODING_UNSPECIFIED), Encoding::kPng);
  EXPECT_EQ(FromProto(v1::OutputKind(10)), std::nullopt);
  EXPECT_EQ(FromProto(v1::Encoding(8)), std::nullopt);
  EXPECT_EQ(ShortName(v1::OUTPUT_KIND_OBJECT_ID), "OBJECT_ID");
  EXPECT_EQ(ShortName(v1::ENCODING_EXR_HALF), "EXR_HALF");
}

}  // namespace
}  // namespace halfshade
