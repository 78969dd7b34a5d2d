#include "renderer/scene_loader/decode_image.h"

#include <gtest/gtest.h>

#include "tests/renderer/scene_loader/png.h"
#include "tests/support/status_matchers.h"

namespace halfshade {
namespace {

using testing::HasSubstr;

TEST(DecodeImageTest, TheHeaderTellsTheSizeBeforeAnythingIsDecoded) {
  const ImageHeader header = ReadImageHeader(MakePng(7, 5).substr(0, 40));
  EXPECT_EQ(header.format, ImageFormat::kPng);
  EXPECT_EQ(header.width, 7u);
  EXPECT_EQ(header.height, 5u);
}

TEST(DecodeImageTest, APngDecodesToItsTexels) {
  const auto image = DecodeImage({"/images/0", MakePng(7, 5), 7, 5}, 1000);
  ASSERT_OK(image);
  EXPECT_EQ(image->width, 7);
  EXPECT_EQ(image->height, 5);
  EXPECT_EQ(image->texels, std::vector<uint8_t>(7 * 5 * 4, 0));
}

TEST(DecodeImageTest, ThePixelCapHoldsOnBothSides) {
  EXPECT_OK(DecodeImage({"/images/0", MakePng(7, 5), 7, 5}, 35));
  EXPECT_THAT(DecodeImage({"/images/0", MakePng(7, 5), 7, 5}, 34),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("/images/0: 35 pixels; at most 34")));
}

TEST(DecodeImageTest, AnEdgeThatNoTextureHasIsRefused) {
  EXPECT_OK(DecodeImage({"x", MakePng(ImageHeader::kMaxEdge, 1), 0, 0}, 1 << 20));
  EXPECT_EQ(DecodeImage({"x", MakePng(ImageHeader::kMaxEdge + 1, 1), 0, 0}, 1 << 20).status().code(),
            absl::StatusCode::kInvalidArgument);
}

TEST(DecodeImageTest, APngThatInflatesToFarMoreThanItsSizeIsRefused) {
  const std::string bomb = MakePng(1, 1, 64 << 20);
  ASSERT_LT(bomb.size(), 100000u);
  EXPECT_THAT(DecodeImage({"x", bomb, 1, 1}, 1000),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("does not decode")));
}

TEST(DecodeImageTest, BrokenBytesAreRefusedAtEveryLength) {
  const std::string png = MakePng(16, 16);
  for (size_t size = 0; size < png.size() - 12; ++size) {
    EXPECT_EQ(DecodeImage({"x", png.substr(0, size), 0, 0}, 1000).status().code(), absl::StatusCode::kInvalidArgument)
        << size;
  }
}

TEST(DecodeImageTest, OtherFormatsAreRefusedByName) {
  for (const char* bytes : {"", "GIF89a______", "RIFF____WEBPVP8 ", "#?RADIANCE\n", "BM__________"}) {
    EXPECT_EQ(ReadImageHeader(bytes).format, ImageFormat::kUnknown) << bytes;
    EXPECT_THAT(DecodeImage({"/images/3", bytes, 0, 0}, 1000),
                StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("/images/3: neither a PNG nor a JPEG")));
  }
}

}  // namespace
}  // namespace halfshade
