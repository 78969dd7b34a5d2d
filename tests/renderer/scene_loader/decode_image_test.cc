#include "renderer/scene_loader/decode_image.h"

#include <gtest/gtest.h>

#include "renderer/scene_loader/image_header.h"
#include "server/encode.h"
#include "tests/support/status_matchers.h"

namespace halfshade {
namespace {

std::string Png(int width, int height) {
  return Encode({OutputKind::kFrame, Image(width, height, 4)}, Encoding::kPng)->bytes;
}

TEST(DecodeImageTest, TheHeaderTellsTheSizeBeforeAnythingIsDecoded) {
  const ImageHeader header = ReadImageHeader(Png(7, 5));
  EXPECT_EQ(header.format, ImageFormat::kPng);
  EXPECT_EQ(header.width, 7u);
  EXPECT_EQ(header.height, 5u);
}

TEST(DecodeImageTest, ThePixelCapHoldsOnBothSides) {
  EXPECT_OK(DecodeImage({"/images/0", Png(7, 5), 7, 5}, 35));
  EXPECT_THAT(DecodeImage({"/images/0", Png(7, 5), 7, 5}, 34),
              StatusIs(absl::StatusCode::kInvalidArgument, testing::HasSubstr("/images/0: 35 pixels; at most 34")));
}

TEST(DecodeImageTest, BrokenBytesAreRefusedAtEveryLength) {
  const std::string png = Png(16, 16);
  for (size_t size = 0; size < png.size() - 12; ++size) {
    EXPECT_EQ(DecodeImage({"x", png.substr(0, size), 0, 0}, 1000).status().code(), absl::StatusCode::kInvalidArgument) << size;
  }
}

}  // namespace
}  // namespace halfshade
