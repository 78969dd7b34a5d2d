#include <bit>
#include <cmath>
#include <cstring>

#include "renderer/plan/choose_method.h"
#include "renderer/status.h"
#include "server/validate.h"
#include "server/validate_field.h"

namespace halfshade {
namespace {

static_assert(std::endian::native == std::endian::little, "points are copied from the wire as they are");

constexpr size_t kPointBytes = 3 * sizeof(float);
// A normal may be as long as this, either way: as a light's direction.
constexpr double kUnitTolerance = 1e-3;

// Packed x, y, z. `bytes` is a whole number of points.
std::vector<glm::vec3> Unpack(const std::string& bytes) {
  std::vector<glm::vec3> points(bytes.size() / kPointBytes);
  if (!bytes.empty()) std::memcpy(points.data(), bytes.data(), bytes.size());
  return points;
}

std::string Indexed(const char* field, size_t index) { return std::string(field) + "[" + std::to_string(index) + "]"; }

absl::Status CheckWholePoints(const char* field, const std::string& bytes) {
  if (bytes.size() % kPointBytes == 0) return absl::OkStatus();
  return FieldError(field, std::to_string(bytes.size()) + " bytes; must be a multiple of 12");
}

// What a query does not look at must not refuse it.
v1::RenderRequest LooksAt(const v1::RenderRequest& request) {
  v1::RenderRequest looked_at = request;
  looked_at.clear_camera();
  looked_at.set_width(1);
  looked_at.set_height(1);
  looked_at.clear_samples();
  looked_at.clear_outputs();
  looked_at.add_outputs()->set_kind(v1::OUTPUT_KIND_VISIBILITY);
  looked_at.mutable_outputs(0)->set_encoding(v1::ENCODING_RAW_F32);
  looked_at.clear_shading();
  looked_at.clear_ground();
  return looked_at;
}

}  // namespace

absl::Status CheckQueryFields(const v1::QueryVisibilityRequest& query, const Limits& limits) {
  RETURN_IF_ERROR(CheckRenderFields(LooksAt(query.request()), limits));
  if (query.points().empty()) return FieldError("points", "missing");
  RETURN_IF_ERROR(CheckWholePoints("points", query.points()));
  RETURN_IF_ERROR(CheckWholePoints("normals", query.normals()));
  if (!query.normals().empty() && query.normals().size() != query.points().size()) {
    return FieldError("normals", std::to_string(query.normals().size() / kPointBytes) +
                                     "; must be none, or one for each of " +
                                     std::to_string(query.points().size() / kPointBytes) + " points");
  }
  const std::vector<glm::vec3> points = Unpack(query.points());
  for (size_t i = 0; i < points.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      const std::string field = Indexed("points", i) + "." + "xyz"[axis];
      RETURN_IF_ERROR(CheckFinite(field, points[i][axis]));
      RETURN_IF_ERROR(CheckRange(field, points[i][axis], -kLargestLengthM, kLargestLengthM));
    }
  }
  const std::vector<glm::vec3> normals = Unpack(query.normals());
  for (size_t i = 0; i < normals.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      RETURN_IF_ERROR(CheckFinite(Indexed("normals", i) + "." + "xyz"[axis], normals[i][axis]));
    }
    const double length = LengthOf(glm::dvec3(normals[i]));
    if (!(std::abs(length - 1) <= kUnitTolerance)) {
      return FieldError(Indexed("normals", i), "length " + NumberText(length) + "; must be a unit vector within 1e-3");
    }
  }
  const uint64_t lights = uint64_t(std::max(1, query.request().lights_size()));
  if (const uint64_t bytes = points.size() * lights * sizeof(float); bytes > limits.render_reply_bytes) {
    return absl::FailedPreconditionError("points: " + std::to_string(points.size()) + " for " + std::to_string(lights) +
                                         " lights are a reply of " + std::to_string(bytes) + " bytes; at most " +
                                         std::to_string(limits.render_reply_bytes) + ": ask for fewer points a call");
  }
  return absl::OkStatus();
}

absl::StatusOr<ValidatedQuery> ValidateQuery(const v1::QueryVisibilityRequest& query, const FlatScene& scene,
                                             const Limits& limits, const Machine& machine) {
  RETURN_IF_ERROR(CheckQueryFields(query, limits));
  ASSIGN_OR_RETURN(ValidatedRender render, ValidateRender(LooksAt(query.request()), scene, limits, machine));
  ValidatedQuery result;
  result.request = std::move(render.request);
  result.points = {Unpack(query.points()), Unpack(query.normals())};
  result.request.outputs.clear();  // certificates are of pictures
  result.request.certify.reset();
  ASSIGN_OR_RETURN(const Pose pose, BuildPose(scene, result.request.scene_index, result.request.node_overrides));
  RETURN_IF_ERROR(SettleMethod(scene, pose, result.points.points_ws.size(), &result.request));
  return result;
}

}  // namespace halfshade
