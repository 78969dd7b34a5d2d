// Pictures as the server encodes them, read back.
#include "client/image_file.h"

#include <gtest/gtest.h>

#include <cmath>

#include "renderer/image/srgb.h"
#include "server/encode.h"
#include "tests/client/temporary_folder.h"
#include "tests/support/status_matchers.h"

namespace halfshade {
namespace {

using absl::StatusCode;
using testing::HasSubstr;

Image Ramp(int channels) {
  Image image(6, 5, channels);
  for (size_t i = 0; i < image.size(); ++i) image.data()[i] = float(i) / 256;
  return image;
}

std::string Encoded(OutputKind kind, const Image& image, Encoding encoding, bool has_alpha = false) {
  return (*Encode({{kind, image}}, {*FormatOf(kind, encoding, image.channels(), has_alpha)},
                  [] { return absl::OkStatus(); }))[0]
      .bytes;
}

TEST(ImageFileTest, ReadsWhatTheServerWritesInEveryFormat) {
  const TemporaryFolder folder;
  const Image visibility = Ramp(2);
  // Multiples of 1/256 below 1/4: exact in half and float, and within half a code in 16 bits.
  const auto expect = [&](const std::string& name, Encoding encoding, float bound) {
    const auto read =
        ReadImageFile(folder.Write(name, Encoded(OutputKind::kVisibility, visibility, encoding)), ImageSize{6, 5});
    ASSERT_OK(read);
    EXPECT_FALSE(read->is_srgb);
    ASSERT_EQ(read->image.width(), 6);
    ASSERT_EQ(read->image.height(), 5);
    ASSERT_EQ(read->image.channels(), 2);
    for (size_t i = 0; i < visibility.size(); ++i) {
      EXPECT_NEAR(read->image.data()[i], visibility.data()[i], bound) << name;
    }
  };
  expect("a.exr", Encoding::kExrHalf, 0);
  expect("b.EXR", Encoding::kExrFloat, 0);
  expect("c.f32", Encoding::kRawF32, 0);
  expect("d.f16", Encoding::kRawF16, 0);
  expect("e.png", Encoding::kPng, 0.51f / 65535);
  expect("f.tif", Encoding::kTiff, 0.51f / 65535);
}

TEST(ImageFileTest, ColoursOf8BitsAreSrgbCodesAndTheirAlphaIsNotMultipliedIn) {
  const TemporaryFolder folder;
  Image frame(1, 1, 4);
  for (int c = 0; c < 4; ++c) frame.at(0, 0, c) = c < 3 ? 0.1f : 0.5f;
  for (const char* name : {"a.png", "a.tif"}) {
    const Encoding encoding = std::string(name) == "a.png" ? Encoding::kPng : Encoding::kTiff;
    const auto read =
        ReadImageFile(folder.Write(name, Encoded(OutputKind::kFrame, frame, encoding, true)), std::nullopt);
    ASSERT_OK(read);
    EXPECT_TRUE(read->is_srgb);
    ASSERT_EQ(read->image.channels(), 4);
    EXPECT_EQ(std::lround(read->image.at(0, 0, 1) * 255), LinearToSrgb8(0.2f));
    EXPECT_EQ(std::lround(read->image.at(0, 0, 3) * 255), 128);
  }
}

TEST(ImageFileTest, FilesThatAreNotThereOrNotPicturesAreNamed) {
  const TemporaryFolder folder;
  EXPECT_THAT(ReadImageFile(folder / "none.png", std::nullopt).status(),
              StatusIs(StatusCode::kNotFound, HasSubstr("none.png: No such file")));
  EXPECT_THAT(ReadImageFile(folder.Write("text.png", "hello"), std::nullopt).status(),
              StatusIs(StatusCode::kInvalidArgument, HasSubstr("text.png: ")));
  EXPECT_THAT(ReadImageFile(folder.Write("a.bmp", "hello"), std::nullopt).status(),
              StatusIs(StatusCode::kInvalidArgument, HasSubstr("a.bmp: has none of the extensions")));
  const std::string cut = Encoded(OutputKind::kFrame, Ramp(4), Encoding::kExrFloat);
  EXPECT_THAT(ReadImageFile(folder.Write("cut.exr", cut.substr(0, cut.size() - 20)), std::nullopt).status(),
              StatusIs(StatusCode::kInvalidArgument, HasSubstr("cut.exr: ")));
}

TEST(ImageFileTest, RawFilesNeedASizeThatTheirLengthFits) {
  const TemporaryFolder folder;
  const std::string path = folder.Write("a.f32", std::string(6 * 5 * 4 * 3, '\0'));
  EXPECT_EQ(ReadImageFile(path, ImageSize{6, 5})->image.channels(), 3);
  EXPECT_THAT(ReadImageFile(path, ImageSize{7, 5}).status(),
              StatusIs(StatusCode::kInvalidArgument,
                       HasSubstr("360 bytes are no whole number of channels of 7 x 5 samples of 4 bytes")));
  EXPECT_THAT(ReadImageFile(folder.Write("empty.f16", ""), ImageSize{6, 5}).status(),
              StatusIs(StatusCode::kInvalidArgument, HasSubstr("0 bytes")));
  EXPECT_THAT(ReadImageFile(path, std::nullopt).status(),
              StatusIs(StatusCode::kInvalidArgument, HasSubstr("no header")));
}

}  // namespace
}  // namespace halfshade
