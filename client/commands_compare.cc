// halfshade compare
#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "client/commands.h"
#include "client/exit_code.h"
#include "client/image_file.h"
#include "client/session.h"
#include "renderer/image/compare.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

struct Figure {
  const char* name;
  std::optional<double> value;
  const char* set;
  uint64_t samples;
};

std::vector<Figure> FiguresOf(const ImageError& error) {
  const auto all = [&](const char* name, const std::optional<double>& value) {
    return Figure{name, value, "all", error.samples_all};
  };
  return {{"mae_shadowed", error.mae_shadowed, "shadowed", error.samples_shadowed},
          {"mae_penumbra", error.mae_penumbra, "penumbra", error.samples_penumbra},
          all("mae_all", error.mae_all),
          all("rmse_all", error.rmse_all),
          all("psnr_all", error.psnr_all),
          all("ssim_all", error.ssim_all),
          all("p999", error.p999),
          all("max", error.max)};
}

// As proto3 JSON has it: null where there is none, "Infinity" where numbers end.
nlohmann::json JsonOf(const std::optional<double>& value) {
  if (!value) return nullptr;
  if (std::isinf(*value)) return "Infinity";
  return *value;
}

std::string ToJsonText(const ImageError& error) {
  nlohmann::ordered_json json;
  for (const Figure& figure : FiguresOf(error)) json[figure.name] = JsonOf(figure.value);
  json["samples"] = {
      {"shadowed", error.samples_shadowed}, {"penumbra", error.samples_penumbra}, {"all", error.samples_all}};
  return json.dump(2) + "\n";
}

std::string ToText(const ImageError& error) {
  std::string text;
  for (const Figure& figure : FiguresOf(error)) {
    const std::string value = figure.value ? absl::StrFormat("%.6g", *figure.value) : "-";
    absl::StrAppendFormat(&text, "%-13s %-12s %s, %d samples\n", figure.name, value, figure.set, figure.samples);
  }
  return text;
}

ImageSize SizeOf(const Image& image) { return {image.width(), image.height()}; }

}  // namespace

absl::Status RunCompare(const GlobalFlags& global, const CompareCommand& command) {
  std::optional<ImageSize> raw_size;
  if (!command.size.empty()) {
    ASSIGN_OR_RETURN(const auto size, ReadSize("--size", command.size));
    raw_size = ImageSize{int(size.first), int(size.second)};
  }
  if (IsRawImage(command.reference) && IsRawImage(command.tested) && !raw_size) {
    return UsageError("compare: .f32 and .f16 have no header; give --size WIDTHxHEIGHT");
  }
  // A file with a header tells the size of one without.
  const bool reads_tested_first = IsRawImage(command.reference) && !IsRawImage(command.tested);
  ImageFile reference, tested;
  for (const bool is_first : {true, false}) {
    const bool is_tested = is_first == reads_tested_first;
    ImageFile& file = is_tested ? tested : reference;
    ASSIGN_OR_RETURN(file, ReadImageFile(is_tested ? command.tested : command.reference, raw_size));
    if (!raw_size) raw_size = SizeOf(file.image);
  }
  if (reference.is_srgb != tested.is_srgb) {
    return absl::InvalidArgumentError(absl::StrCat(reference.is_srgb ? command.reference : command.tested,
                                                   ": 8 bit sRGB; the other image is linear: compare like with like"));
  }
  ImageFile mask;
  if (!command.mask.empty()) {
    ASSIGN_OR_RETURN(mask, ReadImageFile(command.mask, raw_size));
  }
  ASSIGN_OR_RETURN(const ImageError error,
                   Compare(reference.image, tested.image, command.mask.empty() ? nullptr : &mask.image));
  return Print(global.wants_json ? ToJsonText(error) : ToText(error));
}

}  // namespace halfshade
