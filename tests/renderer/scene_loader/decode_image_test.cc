#include "renderer/scene_loader/decode_image.h"

#include <gtest/gtest.h>
#include <malloc.h>

#include <algorithm>
#include <string>

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

// Found by image_fuzz: stb_image 2.27 writes beyond its table of 257.
TEST(DecodeImageTest, AJpegWhoseHuffmanTableHasOver256CodesIsNone) {
  const auto table = [](size_t codes) {
    std::string counts(16, '\0');
    for (char& count : counts) {
      count = char(std::min<size_t>(codes, 255));
      codes -= std::min<size_t>(codes, 255);
    }
    return counts;
  };
  // SOI, an APP0 that holds what looks like a table, the table, a frame of one 8 x 8 component.
  const auto jpeg = [&](size_t in_app, size_t codes, const std::string& between) {
    const size_t length = 19 + codes;
    std::string bytes("\xff\xd8\xff\xe0\x00\x18\xff\xc4\x00\x13\x00", 11);
    bytes += table(in_app) + '\0' + between;
    bytes += std::string("\xff\xc4") + char(length >> 8) + char(length & 255) + '\0' + table(codes);
    bytes += std::string(codes, '\1');
    bytes += std::string("\xff\xc0\x00\x0b\x08\x00\x08\x00\x08\x01\x01\x11\x00", 13);
    return bytes;
  };
  EXPECT_EQ(ReadImageHeader(jpeg(0, 1, "")).format, ImageFormat::kJpeg);
  EXPECT_EQ(ReadImageHeader(jpeg(999, 1, "")).format, ImageFormat::kJpeg) << "what an APP0 holds is no table";
  for (const size_t codes : {257, 511, 4080}) {
    EXPECT_EQ(ReadImageHeader(jpeg(0, codes, "")).format, ImageFormat::kUnknown) << codes;
    EXPECT_EQ(ReadImageHeader(jpeg(0, codes, "junk")).format, ImageFormat::kUnknown) << codes;
    EXPECT_EQ(ReadImageHeader(jpeg(0, codes, "\xff\xff")).format, ImageFormat::kUnknown) << codes;
  }
}

// An 8 x 8 JPEG of one component: parts to leave out or to put together wrongly.
constexpr char kBaseline = '\xc0', kProgressive = '\xc2';
std::string Frame(char kind) {
  return std::string("\xff") + kind + std::string("\x00\x0b\x08\x00\x08\x00\x08\x01\x01\x11\x00", 11);
}
std::string Quantization(char id) { return std::string("\xff\xdb\x00\x43", 4) + id + std::string(64, '\1'); }
// One code, a zero, for a value of 0: of DC and of AC.
std::string Huffman(char id) {
  const std::string code = '\1' + std::string(16, '\0');
  return std::string("\xff\xc4\x00\x26", 4) + id + code + char(id | 0x10) + code;
}
std::string Scan(char first_coefficient) {
  return std::string("\xff\xda\x00\x08\x01\x01\x00", 7) + first_coefficient + std::string("\x3f\x00", 2) +
         std::string(64, '\0');
}
std::string Jpeg(const std::string& parts) { return "\xff\xd8" + parts + "\xff\xd9"; }

// stb_image makes all of these grey. A frame of Motion JPEG has no Huffman tables.
TEST(DecodeImageTest, AJpegWithoutTablesOrScanIsRefusedByName) {
  EXPECT_OK(DecodeImage({"x", Jpeg(Huffman(0) + Quantization(0) + Frame(kBaseline) + Scan(0)), 0, 0}, 64));
  const std::string padded = "padding" + Huffman(0) + Quantization(0) + Frame(kBaseline) + Scan(0);
  EXPECT_OK(DecodeImage({"x", Jpeg(Quantization(0) + padded), 0, 0}, 64)) << "what stands behind padding counts";
  const auto refusal = [](const std::string& parts) {
    return DecodeImage({"/images/2", Jpeg(parts), 0, 0}, 64).status();
  };
  const auto says = [](const char* what) {
    return StatusIs(absl::StatusCode::kInvalidArgument,
                    HasSubstr(std::string("/images/2: does not decode: a JPEG without ") + what));
  };
  EXPECT_THAT(refusal(Quantization(0) + Frame(kBaseline) + Scan(0)), says("Huffman tables"));
  EXPECT_THAT(refusal(Huffman(0) + Frame(kBaseline) + Scan(0)), says("quantization tables"));
  EXPECT_THAT(refusal(Huffman(0) + Quantization(0) + Frame(kProgressive)), says("a scan"));
}

// Found by gltf_fuzz: stb_image 2.27 takes the tables and blocks that a JPEG does not give from memory as it finds it.
TEST(DecodeImageTest, WhatAJpegDoesNotGiveIsZero) {
  const std::string other_tables = Jpeg(Huffman(1) + Quantization(1) + Frame(kBaseline) + Scan(0));
  const std::string no_first_coefficients = Jpeg(Huffman(0) + Quantization(0) + Frame(kProgressive) + Scan(1));
  for (const std::string& bytes : {other_tables, no_first_coefficients}) {
    for (const int fill : {0x01, 0x41, 0xfe}) {
      mallopt(M_PERTURB, fill);
      const auto image = DecodeImage({"x", bytes, 0, 0}, 64);
      mallopt(M_PERTURB, 0);
      ASSERT_OK(image);
      for (size_t i = 0; i < image->texels.size(); ++i) ASSERT_EQ(image->texels[i], i % 4 == 3 ? 255 : 128) << fill;
    }
  }
}

}  // namespace
}  // namespace halfshade
