#include "client/image_file.h"

#include <Imath/half.h>
#include <OpenImageIO/imageio.h>
#include <absl/strings/ascii.h>
#include <absl/strings/str_cat.h>

#include <algorithm>
#include <cstring>
#include <filesystem>

#include "client/input_file.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

std::string ExtensionOf(const std::string& path) {
  return absl::AsciiStrToLower(std::filesystem::path(path).extension().string());
}

absl::Status Unreadable(const std::string& path, const std::string& why) {
  return absl::InvalidArgumentError(absl::StrCat(path, ": ", why));
}

absl::StatusOr<Image> ReadRaw(const std::string& path, const ImageSize& size) {
  ASSIGN_OR_RETURN(const std::string bytes, ReadInputFile(path));
  const bool is_half = ExtensionOf(path) == ".f16";
  const size_t sample = is_half ? sizeof(uint16_t) : sizeof(float);
  const size_t plane = size_t(size.width) * size_t(size.height) * sample;
  if (bytes.empty() || bytes.size() % plane != 0) {
    return Unreadable(path, absl::StrCat(bytes.size(), " bytes are no whole number of channels of ", size.width, " x ",
                                         size.height, " samples of ", sample, " bytes"));
  }
  Image image(size.width, size.height, int(bytes.size() / plane));
  if (!is_half) {
    std::memcpy(image.data(), bytes.data(), bytes.size());
    return image;
  }
  for (size_t i = 0; i < image.size(); ++i) {
    uint16_t bits = 0;
    std::memcpy(&bits, bytes.data() + i * sample, sample);
    Imath::half value;
    value.setBits(bits);
    image.data()[i] = value;
  }
  return image;
}

// OpenImageIO throws, and returns null with a message.
absl::StatusOr<ImageFile> ReadWithHeader(const std::string& path) {
  RETURN_IF_ERROR(CheckInputFile(path));
  try {
    OIIO::ImageSpec config;
    config.attribute("oiio:UnassociatedAlpha", 1);
    const auto file = OIIO::ImageInput::open(path, &config);
    if (file == nullptr) return Unreadable(path, OIIO::geterror());
    const OIIO::ImageSpec& spec = file->spec();
    ImageFile result{Image(spec.width, spec.height, spec.nchannels), spec.format == OIIO::TypeDesc::UINT8};
    if (!file->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, result.image.data())) {
      return Unreadable(path, file->geterror());
    }
    return result;
  } catch (const std::exception& error) {
    return Unreadable(path, error.what());
  }
}

}  // namespace

bool IsRawImage(const std::string& path) {
  const std::string extension = ExtensionOf(path);
  return extension == ".f32" || extension == ".f16";
}

absl::StatusOr<ImageFile> ReadImageFile(const std::string& path, const std::optional<ImageSize>& raw_size) {
  if (IsRawImage(path)) {
    if (!raw_size) return Unreadable(path, "has no header that tells its size");
    ASSIGN_OR_RETURN(Image image, ReadRaw(path, *raw_size));
    return ImageFile{std::move(image), false};
  }
  constexpr const char* kExtensions[] = {".png", ".exr", ".jpg", ".jpeg", ".tif", ".tiff"};
  if (std::find(std::begin(kExtensions), std::end(kExtensions), ExtensionOf(path)) == std::end(kExtensions)) {
    return Unreadable(path, "has none of the extensions .png .exr .jpg .tif .f32 .f16");
  }
  return ReadWithHeader(path);
}

}  // namespace halfshade
