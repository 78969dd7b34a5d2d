// Encoded images, read back by OpenImageIO: types, names, values, digests, and both sides of each limit.
#include "server/encode.h"

#include <Imath/half.h>
#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "renderer/image/srgb.h"
#include "server/digest.h"
#include "tests/support/status_matchers.h"

namespace halfshade {
namespace {

using absl::StatusCode;
using testing::HasSubstr;
using Strings = std::vector<std::string>;

absl::Status GoOn() { return absl::OkStatus(); }

constexpr float kInfinity = std::numeric_limits<float>::infinity();

OutputFormat Format(OutputKind kind, Encoding encoding, int lights = 1, bool has_alpha = false) {
  return *FormatOf(kind, encoding, lights, has_alpha);
}

absl::StatusOr<EncodedOutput> EncodeOne(OutputKind kind, const Image& image, const OutputFormat& format) {
  auto outputs = Encode({{kind, image}}, {format}, &GoOn);
  if (!outputs.ok()) return outputs.status();
  return std::move(outputs->front());
}

// A file as it stands: no alpha multiplied in, no colour transformed.
struct Decoded {
  OIIO::ImageSpec spec;
  std::vector<float> values;  // integers as code / largest code

  float at(int x, int y, int c) const { return values[size_t((y * spec.width + x) * spec.nchannels + c)]; }
  float Named(const std::string& channel, int x, int y) const {
    const auto found = std::find(spec.channelnames.begin(), spec.channelnames.end(), channel);
    EXPECT_NE(found, spec.channelnames.end()) << channel;
    return at(x, y, int(found - spec.channelnames.begin()));
  }
};

Decoded Decode(const std::string& bytes, const char* name) {
  Decoded decoded;
  OIIO::Filesystem::IOMemReader reader(bytes.data(), bytes.size());
  void* proxy = &reader;
  OIIO::ImageSpec config;
  config.attribute("oiio:UnassociatedAlpha", 1);
  config.attribute("oiio:ioproxy", OIIO::TypeDesc::PTR, &proxy);
  const auto file = OIIO::ImageInput::create(name, /*do_open=*/false, &config, &reader);
  EXPECT_NE(file, nullptr) << OIIO::geterror();
  if (file == nullptr) return decoded;
  EXPECT_TRUE(file->open(name, decoded.spec, config)) << file->geterror();
  decoded.spec = file->spec();
  decoded.values.resize(size_t(decoded.spec.image_pixels()) * size_t(decoded.spec.nchannels));
  EXPECT_TRUE(file->read_image(0, 0, 0, -1, OIIO::TypeDesc::FLOAT, decoded.values.data())) << file->geterror();
  return decoded;
}

// Values that differ in every pixel and channel, more rows than one strip has.
Image Gradient(int width, int height, int channels, float scale = 1) {
  Image image(width, height, channels);
  for (size_t i = 0; i < image.size(); ++i) image.data()[i] = scale * float(i) / float(image.size());
  return image;
}

TEST(EncodeTest, AFramesPngAndTiffAreItsSrgbCodesWithRowZeroOnTop) {
  const Image image = Gradient(5, 130, 4);
  std::vector<uint8_t> codes;
  for (int y = 0; y < 130; ++y) {
    for (int x = 0; x < 5; ++x) {
      for (int c = 0; c < 3; ++c) codes.push_back(LinearToSrgb8(image.at(x, y, c)));
    }
  }
  for (const Encoding encoding : {Encoding::kPng, Encoding::kTiff}) {
    const auto encoded = EncodeOne(OutputKind::kFrame, image, Format(OutputKind::kFrame, encoding));
    ASSERT_OK(encoded);
    const Decoded decoded = Decode(encoded->bytes, encoding == Encoding::kPng ? "a.png" : "a.tif");
    EXPECT_EQ(decoded.spec.nchannels, 3);
    EXPECT_EQ(decoded.spec.format, OIIO::TypeDesc::UINT8);
    ASSERT_EQ(decoded.values.size(), codes.size());
    for (size_t i = 0; i < codes.size(); ++i) ASSERT_EQ(std::lround(decoded.values[i] * 255), codes[i]);
    EXPECT_EQ(encoded->pixel_sha256, Sha256Hex(codes.data(), codes.size()));
  }
}

TEST(EncodeTest, ACatchersPngAndTiffHaveUnassociatedAlpha) {
  Image image(2, 1, 4);
  const float pixels[] = {0.25f, 0.125f, 0, 0.5f, 0, 0, 0, 0};
  std::copy(std::begin(pixels), std::end(pixels), image.data());
  for (const Encoding encoding : {Encoding::kPng, Encoding::kTiff}) {
    const auto encoded = EncodeOne(OutputKind::kFrame, image, Format(OutputKind::kFrame, encoding, 1, true));
    ASSERT_OK(encoded);
    const Decoded decoded = Decode(encoded->bytes, encoding == Encoding::kPng ? "a.png" : "a.tif");
    ASSERT_EQ(decoded.spec.nchannels, 4);
    EXPECT_EQ(decoded.spec.alpha_channel, 3);
    const uint8_t codes[] = {188, 137, 0, 128, 0, 0, 0, 0};  // sRGB of 0.5 and 0.25
    for (int i = 0; i < 8; ++i) EXPECT_EQ(std::lround(decoded.values[size_t(i)] * 255), codes[i]) << i;
    EXPECT_EQ(encoded->pixel_sha256, Sha256Hex(codes, sizeof(codes)));
  }
}

TEST(EncodeTest, VisibilitysPngAndTiffAre16BitsAChannelPerLight) {
  // Two and four channels would be grey and colour with alpha: no value may be multiplied by another.
  for (const int lights : {1, 2, 3, 4, 5}) {
    Image image(3, 1, lights);
    for (size_t i = 0; i < image.size(); ++i) image.data()[i] = i == 0 ? 1.5f : 1 / float(1 + i);
    for (const Encoding encoding : {Encoding::kPng, Encoding::kTiff}) {
      if (encoding == Encoding::kPng && lights == 5) continue;
      const OutputFormat format = Format(OutputKind::kVisibility, encoding, lights);
      const auto encoded = EncodeOne(OutputKind::kVisibility, image, format);
      ASSERT_OK(encoded);
      const Decoded decoded = Decode(encoded->bytes, encoding == Encoding::kPng ? "a.png" : "a.tif");
      EXPECT_EQ(decoded.spec.format, OIIO::TypeDesc::UINT16);
      ASSERT_EQ(decoded.spec.nchannels, lights);
      std::vector<uint16_t> codes;
      for (size_t i = 0; i < image.size(); ++i) {
        codes.push_back(uint16_t(std::lround(std::min(1.0f, image.data()[i]) * 65535)));
        EXPECT_EQ(std::lround(decoded.values[i] * 65535), codes.back());
      }
      EXPECT_EQ(encoded->pixel_sha256, Sha256Hex(codes.data(), codes.size() * 2));
    }
  }
}

TEST(EncodeTest, NormalsOfAPngAreHalfPlusAHalf) {
  Image image(1, 1, 3);
  image.data()[0] = -1;
  image.data()[1] = 0;
  image.data()[2] = 1;
  const auto encoded = EncodeOne(OutputKind::kNormal, image, Format(OutputKind::kNormal, Encoding::kPng));
  ASSERT_OK(encoded);
  const uint16_t codes[] = {0, 32768, 65535};
  EXPECT_EQ(encoded->pixel_sha256, Sha256Hex(codes, sizeof(codes)));
  EXPECT_EQ(Decode(encoded->bytes, "a.png").spec.format, OIIO::TypeDesc::UINT16);
}

TEST(EncodeTest, NumbersOfObjectsAreExactOrRefused) {
  struct Case {
    Encoding encoding;
    float largest;
    const char* limit;
  };
  for (const Case& c : {Case{Encoding::kPng, 65535, "65535"}, Case{Encoding::kTiff, 65535, "65535"},
                        Case{Encoding::kExrHalf, 2048, "2048"}, Case{Encoding::kRawF16, 2048, "2048"},
                        Case{Encoding::kExrFloat, 16777216, "16777216"}}) {
    const OutputFormat format = Format(OutputKind::kObjectId, c.encoding);
    Image image(2, 1, 1);
    image.data()[0] = 7;
    image.data()[1] = c.largest;
    EXPECT_OK(EncodeOne(OutputKind::kObjectId, image, format));
    image.data()[1] = std::nextafter(c.largest, kInfinity) + 1;
    EXPECT_THAT(EncodeOne(OutputKind::kObjectId, image, format),
                StatusIs(StatusCode::kInvalidArgument, HasSubstr(std::string("holds up to ") + c.limit)));
  }
  Image image(2, 1, 1);
  image.data()[0] = 0;
  image.data()[1] = 300;
  const auto encoded = EncodeOne(OutputKind::kObjectId, image, Format(OutputKind::kObjectId, Encoding::kPng));
  ASSERT_OK(encoded);
  EXPECT_EQ(std::lround(Decode(encoded->bytes, "a.png").values[1] * 65535), 300);
}

TEST(EncodeTest, ExrHasNamedChannelsOfItsType) {
  struct Case {
    OutputKind kind;
    int channels;
  };
  for (const Case& c : {Case{OutputKind::kFrame, 4}, Case{OutputKind::kVisibility, 3}, Case{OutputKind::kDepth, 1},
                        Case{OutputKind::kNormal, 3}, Case{OutputKind::kPosition, 3}, Case{OutputKind::kAlbedo, 3},
                        Case{OutputKind::kObjectId, 1}}) {
    for (const Encoding encoding : {Encoding::kExrHalf, Encoding::kExrFloat}) {
      const Image image = c.kind == OutputKind::kObjectId ? Image(7, 70, 1) : Gradient(7, 70, c.channels, 3);
      const OutputFormat format = Format(c.kind, encoding, 3);
      const auto encoded = EncodeOne(c.kind, image, format);
      ASSERT_OK(encoded);
      const Decoded decoded = Decode(encoded->bytes, "a.exr");
      EXPECT_EQ(decoded.spec.format, encoding == Encoding::kExrHalf ? OIIO::TypeDesc::HALF : OIIO::TypeDesc::FLOAT);
      ASSERT_EQ(decoded.spec.nchannels, c.channels);
      for (int y = 0; y < 70; ++y) {
        for (int ch = 0; ch < c.channels; ++ch) {
          const float value = image.at(6, y, ch);
          ASSERT_EQ(decoded.Named(format.channels[size_t(ch)], 6, y),
                    encoding == Encoding::kExrHalf ? float(Imath::half(value)) : value);
        }
      }
    }
  }
}

TEST(EncodeTest, LayersShareOneExrWithATypeOfTheirOwn) {
  std::vector<RenderedImage> images = {{OutputKind::kFrame, Gradient(9, 70, 4)},
                                       {OutputKind::kVisibility, Gradient(9, 70, 2)},
                                       {OutputKind::kDepth, Gradient(9, 70, 1, 1000)},
                                       {OutputKind::kDepth, Gradient(9, 70, 1, 1000)}};
  std::vector<OutputFormat> formats = {
      Format(OutputKind::kFrame, Encoding::kExrHalf), Format(OutputKind::kVisibility, Encoding::kExrFloat, 2),
      Format(OutputKind::kDepth, Encoding::kRawF32), Format(OutputKind::kDepth, Encoding::kExrFloat)};
  ASSERT_OK(SetLayer("beauty", &formats[0]));
  ASSERT_OK(SetLayer("lights", &formats[1]));
  ASSERT_OK(SetLayer("beauty", &formats[3]));
  const auto outputs = Encode(images, formats, &GoOn);
  ASSERT_OK(outputs);
  EXPECT_EQ((*outputs)[1].bytes, "");
  EXPECT_EQ((*outputs)[3].bytes, "");
  EXPECT_EQ((*outputs)[2].bytes.size(), 9u * 70 * 4) << "an output without a layer is a file of its own";
  const Decoded decoded = Decode((*outputs)[0].bytes, "a.exr");
  EXPECT_EQ(decoded.spec.nchannels, 7);
  for (int y = 0; y < 70; ++y) {
    ASSERT_EQ(decoded.Named("beauty.G", 3, y), float(Imath::half(images[0].image.at(3, y, 1))));
    ASSERT_EQ(decoded.Named("lights.1", 8, y), images[1].image.at(8, y, 1));
    ASSERT_EQ(decoded.Named("beauty.Z", 0, y), images[3].image.at(0, y, 0));
  }
  for (size_t i = 0; i < 4; ++i) {
    EXPECT_EQ((*outputs)[i].pixel_sha256, EncodeOne(images[i].kind, images[i].image, formats[i])->pixel_sha256)
        << "a digest is of the output's own pixels";
  }
}

TEST(EncodeTest, TiffHoldsMetresAsFloats) {
  const Image image = Gradient(7, 70, 3, -1e6f);
  const auto encoded = EncodeOne(OutputKind::kPosition, image, Format(OutputKind::kPosition, Encoding::kTiff));
  ASSERT_OK(encoded);
  const Decoded decoded = Decode(encoded->bytes, "a.tif");
  EXPECT_EQ(decoded.spec.format, OIIO::TypeDesc::FLOAT);
  ASSERT_EQ(decoded.values.size(), image.size());
  EXPECT_EQ(std::memcmp(decoded.values.data(), image.data(), image.size() * sizeof(float)), 0);
}

TEST(EncodeTest, AJpegIsNearItsSrgbCodes) {
  Image image(64, 48, 4);
  for (int y = 0; y < 48; ++y) {
    for (int x = 0; x < 64; ++x) {
      for (int c = 0; c < 3; ++c) image.at(x, y, c) = float(x + y) / 112;
    }
  }
  const auto encoded = EncodeOne(OutputKind::kFrame, image, Format(OutputKind::kFrame, Encoding::kJpeg));
  ASSERT_OK(encoded);
  const Decoded decoded = Decode(encoded->bytes, "a.jpg");
  ASSERT_EQ(decoded.spec.nchannels, 3);
  float largest = 0;
  for (int y = 0; y < 48; ++y) {
    for (int x = 0; x < 64; ++x) {
      largest = std::max(largest, std::abs(decoded.at(x, y, 1) * 255 - float(LinearToSrgb8(image.at(x, y, 1)))));
    }
  }
  // Quality 95 divides the standard tables by 10: the lowest frequencies are quantised in steps of 1 to 2, which for a
  // smooth ramp leaves a few codes.
  EXPECT_LE(largest, 4);
  EXPECT_GT(encoded->bytes.size(), 500u);
  EXPECT_LT(encoded->bytes.size(), 64u * 48 * 3 / 2);
}

TEST(EncodeTest, RawIsTheFloatsAndTheDigestIsTheirs) {
  const Image image = Gradient(5, 70, 4);
  const auto encoded = EncodeOne(OutputKind::kFrame, image, Format(OutputKind::kFrame, Encoding::kRawF32));
  ASSERT_OK(encoded);
  ASSERT_EQ(encoded->bytes.size(), image.size() * sizeof(float));
  EXPECT_EQ(std::memcmp(encoded->bytes.data(), image.data(), encoded->bytes.size()), 0);
  EXPECT_EQ(encoded->pixel_sha256, Sha256Hex(encoded->bytes));
}

TEST(EncodeTest, HalvesRoundToNearestEven) {
  struct Case {
    float value;
    uint16_t bits;
  };
  // 1 + 2^-11 lies between 1 and the next half: a tie, to even. Largest half 65504; its tie with 65536 goes to
  // infinity.
  const Case cases[] = {{1, 0x3c00},
                        {1 + 0x1p-11f, 0x3c00},
                        {1 + 3 * 0x1p-11f, 0x3c02},
                        {1 + 0x1p-11f + 0x1p-20f, 0x3c01},
                        {-2, 0xc000},
                        {65504, 0x7bff},
                        {65519, 0x7bff},
                        {65520, 0x7c00},
                        {kInfinity, 0x7c00},
                        {0x1p-24f, 0x0001},
                        {0x1p-25f, 0x0000},
                        {3 * 0x1p-25f, 0x0002},
                        {-0.0f, 0x8000}};
  Image image(int(std::size(cases)), 1, 1);
  for (size_t i = 0; i < std::size(cases); ++i) image.data()[i] = cases[i].value;
  const auto encoded = EncodeOne(OutputKind::kDepth, image, Format(OutputKind::kDepth, Encoding::kRawF16));
  ASSERT_OK(encoded);
  ASSERT_EQ(encoded->bytes.size(), std::size(cases) * 2);
  for (size_t i = 0; i < std::size(cases); ++i) {
    uint16_t bits = 0;
    std::memcpy(&bits, encoded->bytes.data() + 2 * i, 2);
    EXPECT_EQ(bits, cases[i].bits) << cases[i].value;
  }
}

TEST(EncodeTest, TheSameImageGivesTheSameBytesInEveryEncoding) {
  const Image image = Gradient(33, 130, 4);
  for (int i = int(Encoding::kPng); i <= int(Encoding::kRawF16); ++i) {
    const OutputFormat format = Format(OutputKind::kFrame, Encoding(i));
    EXPECT_EQ(EncodeOne(OutputKind::kFrame, image, format)->bytes, EncodeOne(OutputKind::kFrame, image, format)->bytes);
  }
}

TEST(EncodeTest, FilesTellNoTime) {
  const auto png = EncodeOne(OutputKind::kFrame, Gradient(3, 2, 4), Format(OutputKind::kFrame, Encoding::kPng));
  for (const char* chunk : {"tIME", "tEXt", "iTXt", "zTXt"}) EXPECT_EQ(png->bytes.find(chunk), std::string::npos);
  for (const Encoding encoding : {Encoding::kTiff, Encoding::kExrHalf, Encoding::kJpeg}) {
    const auto encoded = EncodeOne(OutputKind::kFrame, Gradient(3, 2, 4), Format(OutputKind::kFrame, encoding));
    for (const char* word : {"202", ":20"}) EXPECT_EQ(encoded->bytes.find(word), std::string::npos) << word;
  }
}

TEST(EncodeTest, WhatIsBrighterThanWhiteIsWhiteEvenIfInfinite) {
  Image image(1, 1, 4);
  image.data()[0] = 7;
  image.data()[1] = kInfinity;
  image.data()[2] = -1;
  const auto encoded = EncodeOne(OutputKind::kFrame, image, Format(OutputKind::kFrame, Encoding::kPng));
  ASSERT_OK(encoded);
  const uint8_t samples[] = {255, 255, 0};
  EXPECT_EQ(encoded->pixel_sha256, Sha256Hex(samples, sizeof(samples)));
}

TEST(EncodeTest, ANanIsInternal) {
  Image image = Gradient(3, 2, 4);
  image.data()[7] = std::numeric_limits<float>::quiet_NaN();
  for (const Encoding encoding : {Encoding::kPng, Encoding::kExrFloat, Encoding::kRawF32}) {
    EXPECT_THAT(EncodeOne(OutputKind::kFrame, image, Format(OutputKind::kFrame, encoding)),
                StatusIs(StatusCode::kInternal, HasSubstr("NaN")));
  }
}

TEST(EncodeTest, StopsBetweenStripsWhenTold) {
  int asked = 0;
  const StopCheck stop = [&] { return ++asked < 3 ? absl::OkStatus() : absl::CancelledError("enough"); };
  for (const Encoding encoding : {Encoding::kPng, Encoding::kExrFloat, Encoding::kRawF32, Encoding::kTiff}) {
    asked = 0;
    EXPECT_THAT(Encode({{OutputKind::kFrame, Image(4, 1000, 4)}}, {Format(OutputKind::kFrame, encoding)}, stop),
                StatusIs(StatusCode::kCancelled, HasSubstr("enough")));
    EXPECT_EQ(asked, 3);
  }
}

}  // namespace
}  // namespace halfshade
