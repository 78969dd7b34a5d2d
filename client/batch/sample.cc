#include "client/batch/sample.h"

#include <absl/strings/match.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <glm/glm.hpp>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>

#include "client/batch/batch_file.h"
#include "renderer/status.h"
#include "server/digest.h"
#include "server/scene_name.h"

namespace halfshade {
namespace {

using Json = nlohmann::ordered_json;
using Range = std::pair<double, double>;

absl::Status Fault(const std::string& place, const std::string& fault) {
  return absl::InvalidArgumentError(absl::StrCat(place.empty() ? "/" : place, ": ", fault));
}

// Sines differ by a bit or two between machines.
double NineDigits(double value) { return std::strtod(absl::StrFormat("%.9g", value).c_str(), nullptr); }

Json ToJson(const glm::dvec3& v) { return {{"x", NineDigits(v.x)}, {"y", NineDigits(v.y)}, {"z", NineDigits(v.z)}}; }

// Expands one line. `place` is a JSON pointer into the template.
class Drawing {
 public:
  Drawing(uint64_t seed, uint64_t index) : prefix_(absl::StrCat(seed, "\n", index, "\n")) {}

  absl::StatusOr<Json> Expand(const Json& value, const std::string& place) const {
    if (value.is_object()) {
      for (const auto& [key, argument] : value.items()) {
        if (!key.empty() && key[0] == '$') return Draw(value, key, place);
      }
    }
    if (!value.is_structured()) return value;
    Json result = value;
    for (const auto& [key, element] : value.items()) {
      Json& target = value.is_object() ? result[key] : result[std::stoul(key)];
      ASSIGN_OR_RETURN(target, Expand(element, absl::StrCat(place, "/", key)));
    }
    return result;
  }

 private:
  // In [0, 1), of 53 bits; the same for the same place.
  double Unit(const std::string& place) const {
    const std::string digits = Sha256Hex(prefix_ + place).substr(0, 16);
    return std::ldexp(double(std::strtoull(digits.c_str(), nullptr, 16) >> 11), -53);
  }

  static absl::StatusOr<Range> ReadRange(const Json& value, const std::string& place) {
    if (value.is_array() && value.size() == 2 && value[0].is_number() && value[1].is_number()) {
      const Range range = {value[0].get<double>(), value[1].get<double>()};
      if (range.first <= range.second) return range;
    }
    return Fault(place, "must be [a, b], two numbers with a <= b");
  }

  absl::StatusOr<Json> Draw(const Json& value, const std::string& key, const std::string& place) const {
    const std::string at = absl::StrCat(place, "/", key);
    if (key == "$light") return DrawLight(value, at);
    if (value.size() != 1) return Fault(place, key + " stands with other keys");
    const Json& argument = value.at(key);
    if (key == "$hemisphere") {
      ASSIGN_OR_RETURN(const Placement placement, Place(argument, at, {}));
      return ToJson(placement.position);
    }
    if (key == "$choice") {
      if (!argument.is_array() || argument.empty()) return Fault(at, "must be a list of at least one");
      const auto chosen = std::min(size_t(Unit(at) * double(argument.size())), argument.size() - 1);
      return Expand(argument[chosen], absl::StrCat(at, "/", chosen));
    }
    if (key != "$uniform" && key != "$log" && key != "$integer") {
      return Fault(at, "no such draw; there are $uniform, $log, $integer, $choice, $hemisphere and $light");
    }
    ASSIGN_OR_RETURN(const Range range, ReadRange(argument, at));
    const auto [low, high] = range;
    if (key == "$uniform") return NineDigits(Between(range, at));
    if (key == "$log") {
      if (low <= 0) return Fault(at, "must be over 0");
      return NineDigits(low * std::pow(high / low, Unit(at)));
    }
    constexpr double kExact = 9007199254740992;  // 2^53
    if (low != std::floor(low) || high != std::floor(high) || std::max(-low, high) > kExact) {
      return Fault(at, "must be whole numbers up to 2^53");
    }
    return int64_t(std::min(low + std::floor(Unit(at) * (high - low + 1)), high));
  }

  double Between(const Range& range, const std::string& place) const {
    return range.first + Unit(place) * (range.second - range.first);
  }

  struct Placement {
    glm::dvec3 position{}, target{};
  };

  // `others`: keys that are somebody else's.
  absl::StatusOr<Placement> Place(const Json& value, const std::string& place,
                                  const std::set<std::string>& others) const {
    if (!value.is_object()) return Fault(place, "must be an object");
    Placement result;
    std::optional<Range> radius;
    Range elevation_deg = {0, 90}, azimuth_deg = {0, 360};
    for (const auto& [key, argument] : value.items()) {
      const std::string at = absl::StrCat(place, "/", key);
      if (key == "target") {
        if (!argument.is_array() || argument.size() != 3) return Fault(at, "must be three numbers");
        for (int i = 0; i < 3; ++i) {
          if (!argument[size_t(i)].is_number()) return Fault(at, "must be three numbers");
          result.target[i] = argument[size_t(i)].get<double>();
        }
      } else if (key == "radius") {
        ASSIGN_OR_RETURN(radius, ReadRange(argument, at));
      } else if (key == "elevation_deg") {
        ASSIGN_OR_RETURN(elevation_deg, ReadRange(argument, at));
      } else if (key == "azimuth_deg") {
        ASSIGN_OR_RETURN(azimuth_deg, ReadRange(argument, at));
      } else if (!others.contains(key)) {
        return Fault(at, "no such key");
      }
    }
    if (!radius || radius->first <= 0) return Fault(place + "/radius", "must be [a, b] with 0 < a <= b");
    if (elevation_deg.first < -90 || elevation_deg.second > 90) {
      return Fault(place + "/elevation_deg", "must lie within -90 to 90");
    }
    // Equal areas of a sphere lie between equal steps of height.
    const Range heights = {std::sin(elevation_deg.first * M_PI / 180), std::sin(elevation_deg.second * M_PI / 180)};
    const double height = Between(heights, place + "/elevation_deg");
    const double azimuth = Between(azimuth_deg, place + "/azimuth_deg") * M_PI / 180;
    const double level = std::sqrt(std::max(0.0, 1 - height * height));
    result.position = result.target + Between(*radius, place + "/radius") *
                                          glm::dvec3(level * std::sin(azimuth), height, level * std::cos(azimuth));
    return result;
  }

  absl::StatusOr<Json> DrawLight(const Json& value, const std::string& place) const {
    const Json& argument = value.at("$light");
    ASSIGN_OR_RETURN(const Placement placement, Place(argument, place, {"width_m", "height_m"}));
    Json light = {{"center", ToJson(placement.position)}};
    const glm::dvec3 normal = glm::normalize(placement.target - placement.position);
    glm::dvec3 u = glm::cross(glm::dvec3(0, 1, 0), normal);
    // Straight above the target every direction is level.
    u = glm::length(u) < 1e-6 ? glm::dvec3(1, 0, 0) : glm::normalize(u);
    const glm::dvec3 v = glm::cross(normal, u);  // so that cross(u, v) is the normal
    for (const auto& [key, name, axis] :
         {std::tuple("width_m", "edgeU", u), std::tuple("height_m", "edgeV", glm::normalize(v))}) {
      const std::string at = absl::StrCat(place, "/", key);
      if (!argument.contains(key)) return Fault(at, "missing");
      ASSIGN_OR_RETURN(const Range range, ReadRange(argument[key], at));
      if (range.first <= 0) return Fault(at, "must be over 0");
      light[name] = ToJson(axis * Between(range, at));
    }
    // What else the line says of this light.
    Json rest = value;
    rest.erase("$light");
    ASSIGN_OR_RETURN(rest, Expand(rest, place.substr(0, place.rfind('/'))));
    light.update(rest);
    return light;
  }

  const std::string prefix_;  // of what a draw depends on
};

}  // namespace

struct LineSampler::Template {
  Json line;
  std::string id;
  std::string folder;
};

LineSampler::LineSampler(std::unique_ptr<Template> parsed) : template_(std::move(parsed)) {}
LineSampler::LineSampler(LineSampler&&) noexcept = default;
LineSampler::~LineSampler() = default;

absl::StatusOr<LineSampler> LineSampler::Create(const std::string& text, const std::string& folder) {
  auto parsed = std::make_unique<Template>();
  ASSIGN_OR_RETURN(parsed->line, ParseLineJson(text));
  const auto id = parsed->line.find("id");
  if (id == parsed->line.end() || !id->is_string()) return Fault("/id", "must be a string");
  parsed->id = id->get<std::string>();
  parsed->folder = folder;
  LineSampler sampler(std::move(parsed));
  RETURN_IF_ERROR(sampler.Line(0, 0).status());
  return sampler;
}

absl::StatusOr<std::string> LineSampler::Line(uint64_t seed, uint64_t index) const {
  ASSIGN_OR_RETURN(Json line, Drawing(seed, index).Expand(template_->line, ""));
  line["id"] = absl::StrFormat("%s-%06d", template_->id, index);
  ASSIGN_OR_RETURN(const BatchLine read, ReadBatchLine(line.dump(), template_->folder));
  line["scene"] = read.request.scene();
  return line.dump();
}

}  // namespace halfshade
