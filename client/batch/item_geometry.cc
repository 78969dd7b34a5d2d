#include "client/batch/item_geometry.h"

#include <cmath>
#include <glm/glm.hpp>

#include "renderer/request.h"
#include "renderer/status.h"
#include "server/validate_field.h"

namespace halfshade {
namespace {

using Json = nlohmann::ordered_json;

constexpr uint32_t kDefaultWidth = 1280, kDefaultHeight = 720;

template <typename Matrix>
Json ColumnMajor(const Matrix& matrix) {
  Json numbers = Json::array();
  for (int column = 0; column < Matrix::length(); ++column) {
    for (int row = 0; row < Matrix::col_type::length(); ++row) numbers.push_back(matrix[column][row]);
  }
  return numbers;
}

// From orthonormal axes and an origin, all in the world.
Json FromWorld(const glm::dvec3& x, const glm::dvec3& y, const glm::dvec3& z, const glm::dvec3& origin) {
  const glm::dmat3 rotation = glm::transpose(glm::dmat3(x, y, z));
  glm::dmat4 result(rotation);
  result[3] = glm::dvec4(-(rotation * origin), 1);
  return ColumnMajor(result);
}

Json ToJson(const Camera& camera, double width, double height) {
  const double pixels = camera.is_orthographic ? height / camera.ortho_height_m : height / (2 * camera.tan_half_fovy);
  return {{"type", camera.is_orthographic ? "orthographic" : "perspective"},
          {"cameraFromWorld", FromWorld(camera.right_ws, -camera.up_ws, camera.forward_ws, camera.eye_ws)},
          {"pixelFromCamera", ColumnMajor(glm::dmat3(pixels, 0, 0, 0, pixels, 0, width / 2, height / 2, 1))}};
}

Json ToJson(const AreaLight& light) {
  const auto rgb = [](const glm::vec3& color) { return Json{color.r, color.g, color.b}; };
  return {{"lightFromWorld", FromWorld(light.axis_u_ws, light.axis_v_ws, light.normal_ws, light.center_ws)},
          {"widthM", light.width_m},
          {"heightM", light.height_m},
          {"radiance", rgb(light.radiance)},
          {"intensity", rgb(light.intensity)},
          {"twoSided", light.is_two_sided}};
}

}  // namespace

absl::StatusOr<Json> ItemGeometry(const v1::RenderRequest& request) {
  Json result = {{"camera", nullptr}, {"lights", nullptr}};
  if (!request.camera().has_look_at()) return result;  // and what a light is resolved by is the camera's target
  const double width = request.width() == 0 ? kDefaultWidth : request.width();
  const double height = request.height() == 0 ? kDefaultHeight : request.height();
  v1::RenderRequest with_near = request;
  // Near plane and scene do not matter to what is said here.
  if (!request.camera().look_at().has_near_m()) with_near.mutable_camera()->mutable_look_at()->set_near_m(1);
  with_near.mutable_camera()->mutable_look_at()->clear_far_m();
  ASSIGN_OR_RETURN(const Camera camera, ResolveCamera(with_near, FlatScene{}, {}, Box3d{}, width / height));
  result["camera"] = ToJson(camera, width, height);
  if (request.lights().empty()) return result;
  result["lights"] = Json::array();
  for (int i = 0; i < request.lights_size(); ++i) {
    ASSIGN_OR_RETURN(AreaLight light, CheckLight("lights[" + std::to_string(i) + "]", request.lights(i)));
    ResolveLight(request.lights(i), camera.target_ws, &light);
    result["lights"].push_back(ToJson(light));
  }
  return result;
}

}  // namespace halfshade
