#include "client/batch/item_geometry.h"

#include <gtest/gtest.h>

#include <glm/glm.hpp>

#include "tests/support/status_matchers.h"

namespace halfshade {
namespace {

using Json = nlohmann::ordered_json;

void Set(v1::Vec3* vector, double x, double y, double z) {
  vector->set_x(x);
  vector->set_y(y);
  vector->set_z(z);
}

template <typename Matrix>
Matrix FromColumns(const Json& numbers) {
  Matrix matrix;
  for (int i = 0; i < Matrix::length() * Matrix::length(); ++i) {
    matrix[i / Matrix::length()][i % Matrix::length()] = numbers[size_t(i)].get<double>();
  }
  return matrix;
}

// 5 m over the origin, looking down, the picture's upper edge to -z: 200 x 100 pixels.
v1::RenderRequest FromAbove() {
  v1::RenderRequest request;
  request.set_width(200);
  request.set_height(100);
  v1::LookAt* camera = request.mutable_camera()->mutable_look_at();
  Set(camera->mutable_eye(), 0, 5, 0);
  Set(camera->mutable_target(), 0, 0, 0);
  Set(camera->mutable_up(), 0, 0, -1);
  return request;
}

void ExpectPixel(const Json& camera, const glm::dvec3& point_ws, const glm::dvec2& pixel, double depth_m) {
  const glm::dvec3 point = FromColumns<glm::dmat4>(camera["cameraFromWorld"]) * glm::dvec4(point_ws, 1);
  const glm::dmat3 pixel_from_camera = FromColumns<glm::dmat3>(camera["pixelFromCamera"]);
  const bool is_perspective = camera["type"] == "perspective";
  const glm::dvec3 seen = pixel_from_camera * (is_perspective ? point / point.z : glm::dvec3(point.x, point.y, 1));
  EXPECT_NEAR(seen.x, pixel.x, 1e-9);
  EXPECT_NEAR(seen.y, pixel.y, 1e-9);
  EXPECT_NEAR(seen.z, 1, 1e-9);
  EXPECT_NEAR(point.z, depth_m, 1e-9);
}

TEST(ItemGeometryTest, APerspectiveCameraProjectsByItsMatrices) {
  v1::RenderRequest request = FromAbove();
  request.mutable_camera()->mutable_look_at()->set_fovy_deg(90);
  const auto geometry = ItemGeometry(request);
  ASSERT_OK(geometry);
  const Json& camera = (*geometry)["camera"];
  EXPECT_EQ(camera["type"], "perspective");
  // 90 degrees: on the floor the picture is 10 m high and 20 m wide.
  ExpectPixel(camera, {0, 0, 0}, {100, 50}, 5);
  ExpectPixel(camera, {-10, 0, -5}, {0, 0}, 5);
  ExpectPixel(camera, {10, 0, 5}, {200, 100}, 5);
  ExpectPixel(camera, {1, 4, 0}, {150, 50}, 1);
  EXPECT_TRUE((*geometry)["lights"].is_null());
}

TEST(ItemGeometryTest, AnOrthographicCameraProjectsByItsMatrices) {
  v1::RenderRequest request = FromAbove();
  request.mutable_camera()->mutable_look_at()->set_ortho_height_m(4);
  const auto geometry = ItemGeometry(request);
  ASSERT_OK(geometry);
  const Json& camera = (*geometry)["camera"];
  EXPECT_EQ(camera["type"], "orthographic");
  ExpectPixel(camera, {0, 0, 0}, {100, 50}, 5);
  ExpectPixel(camera, {-4, 3, -2}, {0, 0}, 2);
}

TEST(ItemGeometryTest, ALightIsAsTheServerMakesIt) {
  v1::RenderRequest request = FromAbove();
  v1::AreaLight* light = request.add_lights();
  Set(light->mutable_center(), 1, 4, 2);
  Set(light->mutable_edge_u(), 2, 0, 0);
  Set(light->mutable_edge_v(), 0, 0, 3);
  Set(light->mutable_direction(), 0, -1, 0);
  light->mutable_radiance()->set_g(7);
  const auto geometry = ItemGeometry(request);
  ASSERT_OK(geometry);
  const Json& seen = (*geometry)["lights"][0];
  const glm::dmat4 light_from_world = FromColumns<glm::dmat4>(seen["lightFromWorld"]);
  const glm::dvec4 below = light_from_world * glm::dvec4(1, 0, 2, 1);
  EXPECT_NEAR(glm::length(below - glm::dvec4(0, 0, 4, 1)), 0, 1e-12) << "z is the distance along its direction";
  const glm::dvec4 corner = light_from_world * glm::dvec4(2, 4, 3.5, 1);
  EXPECT_NEAR(std::abs(corner.x), 1, 1e-12);
  EXPECT_NEAR(std::abs(corner.y), 1.5, 1e-12);
  EXPECT_NEAR(glm::determinant(glm::dmat3(light_from_world)), 1, 1e-12) << "right-handed";
  EXPECT_EQ(seen["widthM"], 2);
  EXPECT_EQ(seen["heightM"], 3);
  EXPECT_EQ(seen["radiance"], Json({0, 7, 0}));
  EXPECT_EQ(seen["twoSided"], false);
}

TEST(ItemGeometryTest, WhatTheServerChoosesIsNull) {
  v1::RenderRequest request;
  request.add_lights();
  EXPECT_EQ(*ItemGeometry(request), Json({{"camera", nullptr}, {"lights", nullptr}}));
  request.mutable_camera()->set_index(0);
  EXPECT_EQ(*ItemGeometry(request), Json({{"camera", nullptr}, {"lights", nullptr}}));
  EXPECT_TRUE((*ItemGeometry(FromAbove()))["lights"].is_null());
}

}  // namespace
}  // namespace halfshade
