#include "server/encode.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <limits>

#include "renderer/scene_loader/decode_image.h"
#include "server/digest.h"
#include "tests/support/status_matchers.h"

namespace halfshade {
namespace {

RenderedImage Frame() {
  RenderedImage rendered{OutputKind::kFrame, Image(3, 2, 4)};
  for (int i = 0; i < 24; ++i) rendered.image.data()[i] = float(i) / 20;
  return rendered;
}

TEST(EncodeTest, AFramesPngReadsBackAsItsSrgbBytesWithRowZeroOnTop) {
  RenderedImage rendered = Frame();
  rendered.image.at(1, 0, 0) = 0.5f;  // sRGB 188
  const auto encoded = Encode(rendered, Encoding::kPng);
  ASSERT_OK(encoded);
  EXPECT_EQ(encoded->channels, 3);
  const auto decoded = DecodeImage({"png", encoded->bytes, 0, 0}, 100);
  ASSERT_OK(decoded);
  ASSERT_EQ(decoded->width, 3);
  ASSERT_EQ(decoded->height, 2);
  EXPECT_EQ(decoded->texels[4], 188);
  EXPECT_EQ(decoded->texels[3], 255) << "no alpha";
}

TEST(EncodeTest, TheSameImageGivesTheSameBytes) {
  EXPECT_EQ(Encode(Frame(), Encoding::kPng)->bytes, Encode(Frame(), Encoding::kPng)->bytes);
}

TEST(EncodeTest, RawIsTheFloatsAndTheDigestIsTheirs) {
  const RenderedImage rendered = Frame();
  const auto encoded = Encode(rendered, Encoding::kRawF32);
  ASSERT_OK(encoded);
  ASSERT_EQ(encoded->bytes.size(), 24 * sizeof(float));
  EXPECT_EQ(std::memcmp(encoded->bytes.data(), rendered.image.data(), encoded->bytes.size()), 0);
  EXPECT_EQ(encoded->pixel_sha256, Sha256Hex(encoded->bytes));
}

TEST(EncodeTest, VisibilitysPngHas16BitsAChannelPerLightAndADigestOfItsRoundedValues) {
  RenderedImage rendered{OutputKind::kVisibility, Image(2, 1, 2)};
  const float values[] = {0, 1, 0.5f, 1.5f};
  std::copy(std::begin(values), std::end(values), rendered.image.data());
  const auto encoded = Encode(rendered, Encoding::kPng);
  ASSERT_OK(encoded);
  EXPECT_EQ(encoded->channels, 2);
  EXPECT_EQ(encoded->bytes[24], 16) << "IHDR's bit depth";
  EXPECT_EQ(encoded->bytes[25], 4) << "IHDR's colour type: two channels";
  const uint16_t samples[] = {0, 65535, 32768, 65535};
  EXPECT_EQ(encoded->pixel_sha256, Sha256Hex(samples, sizeof(samples)));
}

TEST(EncodeTest, APngTellsNeitherTimeNorMaker) {
  const auto encoded = Encode(Frame(), Encoding::kPng);
  ASSERT_OK(encoded);
  for (const char* chunk : {"tIME", "tEXt", "iTXt", "zTXt"}) {
    EXPECT_EQ(encoded->bytes.find(chunk), std::string::npos) << chunk;
  }
}

TEST(EncodeTest, WhatIsBrighterThanWhiteIsWhiteEvenIfInfinite) {
  RenderedImage rendered{OutputKind::kFrame, Image(1, 1, 4)};
  rendered.image.data()[0] = 7;
  rendered.image.data()[1] = std::numeric_limits<float>::infinity();
  rendered.image.data()[2] = -1;
  const auto encoded = Encode(rendered, Encoding::kPng);
  ASSERT_OK(encoded);
  const uint8_t samples[] = {255, 255, 0};
  EXPECT_EQ(encoded->pixel_sha256, Sha256Hex(samples, sizeof(samples)));
}

TEST(EncodeTest, ANanIsInternal) {
  RenderedImage rendered = Frame();
  rendered.image.data()[7] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THAT(Encode(rendered, Encoding::kPng), StatusIs(absl::StatusCode::kInternal, testing::HasSubstr("NaN")));
}

TEST(UncompressedBytesTest, CountsWhatTheEncoderGets) {
  EXPECT_EQ(UncompressedBytes(OutputKind::kFrame, Encoding::kPng, 10, 10, 2), 300u);
  EXPECT_EQ(UncompressedBytes(OutputKind::kFrame, Encoding::kRawF32, 10, 10, 2), 1600u);
  EXPECT_EQ(UncompressedBytes(OutputKind::kVisibility, Encoding::kPng, 10, 10, 2), 400u);
  EXPECT_EQ(UncompressedBytes(OutputKind::kVisibility, Encoding::kRawF32, 10, 10, 2), 800u);
}

}  // namespace
}  // namespace halfshade
