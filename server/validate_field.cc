#include "server/validate_field.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "renderer/status.h"

namespace halfshade {

absl::Status FieldError(const std::string& field, const std::string& fault) {
  return absl::InvalidArgumentError(field + ": " + fault);
}

absl::Status NotAvailable(const std::string& field, const std::string& what) {
  return absl::UnimplementedError(field + ": " + what + " is not available in this version");
}

std::string NumberText(double value) {
  if (std::isnan(value)) return "nan";
  char text[40];
  const auto end = std::to_chars(text, text + sizeof(text), value).ptr;
  return std::string(text, end);
}

double LengthOf(const glm::dvec3& v) { return std::hypot(v.x, v.y, v.z); }

glm::dvec3 UnitOf(const glm::dvec3& v) {
  return glm::normalize(v / std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}));
}

absl::Status CheckFinite(const std::string& field, double value) {
  if (std::isfinite(value)) return absl::OkStatus();
  return FieldError(field, NumberText(value) + "; must be finite");
}

absl::Status CheckRange(const std::string& field, double value, double low, double high) {
  if (value >= low && value <= high) return absl::OkStatus();
  return FieldError(field, NumberText(value) + "; must be " + NumberText(low) + " to " + NumberText(high));
}

absl::Status CheckLength(const std::string& field, double value) {
  RETURN_IF_ERROR(CheckFinite(field, value));
  return CheckRange(field, value, kSmallestLengthM, kLargestLengthM);
}

absl::StatusOr<glm::dvec3> CheckVec3(const std::string& field, const v1::Vec3& value) {
  const double components[3] = {value.x(), value.y(), value.z()};
  for (int i = 0; i < 3; ++i) {
    const std::string name = field + "." + "xyz"[i];
    RETURN_IF_ERROR(CheckFinite(name, components[i]));
    RETURN_IF_ERROR(CheckRange(name, components[i], -kLargestLengthM, kLargestLengthM));
  }
  return glm::dvec3(components[0], components[1], components[2]);
}

absl::StatusOr<glm::vec3> CheckRgb(const std::string& field, const v1::Rgb& value) {
  const float components[3] = {value.r(), value.g(), value.b()};
  for (int i = 0; i < 3; ++i) {
    const std::string name = field + "." + "rgb"[i];
    RETURN_IF_ERROR(CheckFinite(name, components[i]));
    if (components[i] < 0) return FieldError(name, NumberText(components[i]) + "; must not be negative");
    if (components[i] > kBrightest) {
      return FieldError(name, NumberText(components[i]) + "; must be at most " + NumberText(kBrightest));
    }
  }
  return glm::vec3(components[0], components[1], components[2]);
}

}  // namespace halfshade
