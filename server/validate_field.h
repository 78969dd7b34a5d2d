// Checks of single fields, and the pieces of server/validate.
#pragma once

#include <absl/status/statusor.h>

#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "halfshade/v1/render.pb.h"
#include "renderer/request.h"
#include "renderer/scene/flat_scene.h"

namespace halfshade {

// INVALID_ARGUMENT "<field>: <fault>".
absl::Status FieldError(const std::string& field, const std::string& fault);
// UNIMPLEMENTED "<field>: <what> is not available in this version".
absl::Status NotAvailable(const std::string& field, const std::string& what);

// Numbers for people: shortest form that reads back, "nan", "inf".
std::string NumberText(double value);

// Lengths and coordinates of a request, metres: above, a double no longer resolves a metre; below, GL's floats
// underflow.
inline constexpr double kSmallestLengthM = 1e-15;
inline constexpr double kLargestLengthM = 1e15;
// Colours: times the largest exposure, 2^32, still a float.
inline constexpr double kBrightest = 1e28;

// Without under- or overflow of the squares. UnitOf requires v != 0.
double LengthOf(const glm::dvec3& v);
glm::dvec3 UnitOf(const glm::dvec3& v);

absl::Status CheckFinite(const std::string& field, double value);
absl::Status CheckRange(const std::string& field, double value, double low, double high);
// kSmallestLengthM to kLargestLengthM.
absl::Status CheckLength(const std::string& field, double value);
absl::StatusOr<glm::dvec3> CheckVec3(const std::string& field, const v1::Vec3& value);
// Each component 0 to kBrightest.
absl::StatusOr<glm::vec3> CheckRgb(const std::string& field, const v1::Rgb& value);

absl::Status CheckCameraFields(const v1::Camera& camera);
// near_m and far_m follow from the scene's bounds where the request has none.
absl::StatusOr<Camera> ResolveCamera(const v1::RenderRequest& request, const FlatScene& scene,
                                     const std::vector<NodeOverride>& overrides, const Box3d& bounds_ws, double aspect);
// What needs no scene: which node is meant is left to ResolveNodeOverrides.
absl::Status CheckNodeOverrideFields(const v1::RenderRequest& request);
// The nodes found; each may be named once.
absl::StatusOr<std::vector<NodeOverride>> ResolveNodeOverrides(const v1::RenderRequest& request,
                                                               const FlatScene& scene);
absl::StatusOr<AreaLight> CheckLight(const std::string& field, const v1::AreaLight& light);
// What the camera's target decides. Edges below 1e-6 of the distance to it become 0, so that a rectangle becomes a line
// or a point of the same power. Power that `asked` leaves out: a white surface at target_ws that faces the light
// reflects 1.
void ResolveLight(const v1::AreaLight& asked, const glm::dvec3& target_ws, AreaLight* light);
// Sets method and method_reason.
absl::Status CheckMethod(const v1::Method& method, RenderRequest* result);

}  // namespace halfshade
