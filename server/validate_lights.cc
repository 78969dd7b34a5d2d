#include <algorithm>
#include <cmath>

#include "renderer/status.h"
#include "server/validate_field.h"

namespace halfshade {
namespace {

// Edges may be off a right angle, and the direction off the normal, by this much.
constexpr double kAngleTolerance = 1e-3;
// Of the distance to the receivers: a shorter edge counts as 0.
constexpr double kThinEdge = 1e-6;
constexpr double kLeastDistanceM = 1e-6;

// Some unit vector at right angles to a unit vector.
glm::dvec3 AnyPerpendicular(const glm::dvec3& direction) {
  const glm::dvec3 axis = std::abs(direction.x) < 0.5 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
  return glm::normalize(glm::cross(direction, axis));
}

// Right-handed axes around the normal: u keeps its direction, v follows.
void SetAxes(const glm::dvec3& u, const glm::dvec3& normal, AreaLight* light) {
  light->normal_ws = normal;
  light->axis_u_ws = glm::normalize(u - normal * glm::dot(u, normal));
  light->axis_v_ws = glm::cross(normal, light->axis_u_ws);
}

absl::StatusOr<glm::dvec3> CheckDirection(const std::string& field, const v1::AreaLight& light) {
  ASSIGN_OR_RETURN(const glm::dvec3 direction, CheckVec3(field + ".direction", light.direction()));
  const double length = glm::length(direction);
  if (std::abs(length - 1) > kAngleTolerance) {
    return FieldError(field + ".direction", "length " + NumberText(length) + "; must be a unit vector within 1e-3");
  }
  return direction / length;
}

// cosine / distance^2 of the light as seen from a point; the cosine is kept from vanishing for points beside the light.
double Falloff(const AreaLight& light, const glm::dvec3& point_ws) {
  const glm::dvec3 to_point = point_ws - light.center_ws;
  const double distance = std::max(glm::length(to_point), kLeastDistanceM);
  constexpr double kLeastCosine = 0.1;
  return std::max(glm::dot(to_point, light.normal_ws) / distance, kLeastCosine) / (distance * distance);
}

}  // namespace

void ResolveLight(const v1::AreaLight& asked, const glm::dvec3& target_ws, AreaLight* light) {
  const double suiting = std::min(M_PI / Falloff(*light, target_ws), kBrightest);
  const double distance = std::max(glm::length(target_ws - light->center_ws), kLeastDistanceM);
  const double area = light->width_m * light->height_m;
  for (double* edge : {&light->width_m, &light->height_m}) {
    if (*edge < kThinEdge * distance) *edge = 0;
  }
  if (light->width_m > 0 && light->height_m > 0) {
    if (!asked.has_radiance()) light->radiance = glm::vec3(float(suiting / area));
  } else if (!asked.has_intensity()) {
    const bool is_thin_rectangle = area > 0 && asked.has_radiance();
    light->intensity =
        is_thin_rectangle ? glm::min(glm::dvec3(light->radiance) * area, kBrightest) : glm::dvec3(suiting);
  }
}

absl::StatusOr<AreaLight> CheckLight(const std::string& field, const v1::AreaLight& light) {
  AreaLight result;
  if (!light.has_center()) return FieldError(field + ".center", "missing");
  ASSIGN_OR_RETURN(result.center_ws, CheckVec3(field + ".center", light.center()));
  ASSIGN_OR_RETURN(const glm::dvec3 u, CheckVec3(field + ".edge_u", light.edge_u()));
  ASSIGN_OR_RETURN(const glm::dvec3 v, CheckVec3(field + ".edge_v", light.edge_v()));
  result.width_m = LengthOf(u);
  result.height_m = LengthOf(v);
  const bool has_u = result.width_m > 0;
  const bool has_v = result.height_m > 0;
  result.is_two_sided = light.two_sided();
  if (light.has_radiance()) {
    ASSIGN_OR_RETURN(result.radiance, CheckRgb(field + ".radiance", light.radiance()));
  }
  if (light.has_intensity()) {
    ASSIGN_OR_RETURN(result.intensity, CheckRgb(field + ".intensity", light.intensity()));
  }
  if ((!has_u || !has_v) && !light.has_direction()) {
    return FieldError(field + ".direction",
                      std::string("missing; needed because ") + (has_u ? "edge_v" : "edge_u") + " has length 0");
  }
  glm::dvec3 direction(0);
  if (light.has_direction()) {
    ASSIGN_OR_RETURN(direction, CheckDirection(field, light));
  }
  if (has_u && has_v) {
    const glm::dvec3 unit_u = UnitOf(u), unit_v = UnitOf(v);
    const double cosine = glm::dot(unit_u, unit_v);
    if (std::abs(cosine) > kAngleTolerance) {
      return FieldError(field + ".edge_v",
                        "cosine " + NumberText(cosine) + " to edge_u; must be at right angles within 1e-3");
    }
    glm::dvec3 normal = glm::normalize(glm::cross(unit_u, unit_v));
    if (light.has_direction()) {
      if (glm::dot(direction, normal) < 0) normal = -normal;
      if (glm::length(direction - normal) > kAngleTolerance) {
        return FieldError(field + ".direction", "must be + or - normalize(cross(edge_u, edge_v)) within 1e-3");
      }
    }
    SetAxes(unit_u, normal, &result);
    return result;
  }
  if (has_u || has_v) {
    const glm::dvec3 edge = UnitOf(has_u ? u : v);
    if (std::abs(glm::dot(edge, direction)) > kAngleTolerance) {
      return FieldError(field + ".direction", "must be at right angles to the light's edge within 1e-3");
    }
    SetAxes(has_u ? edge : glm::cross(edge, direction), direction, &result);
    return result;
  }
  SetAxes(AnyPerpendicular(direction), direction, &result);
  return result;
}

}  // namespace halfshade
