// DEPTH, POSITION, NORMAL, ALBEDO and OBJECT_ID against closed forms.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <set>

#include "renderer/math/camera.h"
#include "tests/renderer/shade/render_image.h"

namespace halfshade {
namespace {

constexpr double kUlp = 0x1p-23;

// The plane n.x = offset and a double-sided square of it around `center`, large enough to fill the view.
struct Plane {
  glm::dvec3 normal{0, 1, 0};
  glm::dvec3 center{0};
};

FlatScene SceneOf(const Plane& plane, double size) {
  const double slope = std::atan2(-plane.normal.x, plane.normal.y);
  GlbMesh square = MakeSquare({0, 0, 0}, size, slope);  // far places are the node's: in double
  square.world_from_mesh[3] = glm::dvec4(plane.center, 1);
  return MakeFlatScene({square});
}

RenderRequest Request(const Camera& camera, int width, int height) {
  RenderRequest request;
  request.camera = camera;
  request.width = width;
  request.height = height;
  return request;
}

struct Ray {
  glm::dvec3 origin, direction;  // 1 long along the camera's axis
};

// From the definition in request.h.
Ray RayOf(const Camera& camera, double x, double y, int width, int height) {
  const double aspect = double(width) / height;
  const double half = camera.is_orthographic ? camera.ortho_height_m / 2 : camera.tan_half_fovy;
  const glm::dvec3 across = (2 * (x + 0.5) / width - 1) * aspect * half * camera.right_ws +
                            (1 - 2 * (y + 0.5) / height) * half * camera.up_ws;
  if (camera.is_orthographic) return {camera.eye_ws + across, camera.forward_ws};
  return {camera.eye_ws, camera.forward_ws + across};
}

Camera Ortho(Camera camera, double height_m) {
  camera.is_orthographic = true;
  camera.ortho_height_m = height_m;
  camera.near_m = 0;
  return camera;
}

// Largest error of depth and position in ulps of the distances from the eye to the surface and from the mesh's origin
// to its corners, over the cosine under which the plane is seen: the error of a plane whose normal and offset are
// floats.
struct Errors {
  double depth_ulps = 0;
  double position_ulps = 0;
  int drawn = 0;
};

Errors MeasurePlane(const Plane& plane, const Camera& camera, double size, int width, int height) {
  const FlatScene scene = SceneOf(plane, size);
  const RenderRequest request = Request(camera, width, height);
  const Image depth = RenderImage(scene, request, OutputKind::kDepth);
  const Image position = RenderImage(scene, request, OutputKind::kPosition);
  Errors errors;
  if (depth.size() == 0 || position.size() == 0) return errors;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      if (depth.at(x, y, 0) == 0) continue;
      ++errors.drawn;
      const Ray ray = RayOf(camera, x, y, width, height);
      const double cosine = glm::dot(plane.normal, ray.direction);
      const double truth = glm::dot(plane.normal, plane.center - ray.origin) / cosine;
      const double ulp = kUlp * (glm::length(ray.direction) * std::abs(truth) + size / 2) / std::abs(cosine);
      errors.depth_ulps = std::max(errors.depth_ulps, std::abs(depth.at(x, y, 0) - truth) / ulp);
      const glm::dvec3 point = ray.origin + ray.direction * truth;
      for (int c = 0; c < 3; ++c) {
        // What no float can say is no error: half an ulp of the coordinate itself.
        const double rounding = 0.5 * kUlp * std::abs(point[c]);
        const double error = std::abs(position.at(x, y, c) - point[c]) - rounding;
        errors.position_ulps = std::max(errors.position_ulps, error / ulp);
      }
    }
  }
  return errors;
}

TEST(DataImageTest, DepthAndPositionOfAPlaneAreExactToUlpsNearAndFarInBothProjections) {
  for (const double slope_deg : {0.0, 20.0, 80.0, 89.0}) {
    for (const glm::dvec3& place : {glm::dvec3(0), glm::dvec3(1e6, 0, -3e6), glm::dvec3(0, 1e9, 0)}) {
      Plane plane;
      const double slope = slope_deg * M_PI / 180;
      plane.normal = {-std::sin(slope), std::cos(slope), 0};
      plane.center = place;
      const Camera camera = LookFrom(place + glm::dvec3(0.3, 2, 1.5), place);
      for (const Camera& view : {camera, Ortho(camera, 1.2)}) {
        const Errors errors = MeasurePlane(plane, view, 8, 61, 40);
        std::printf("slope %4.1f place %.0e %s: depth %.2f position %.2f ulps, %d pixels\n", slope_deg,
                    glm::length(place), view.is_orthographic ? "ortho" : "persp", errors.depth_ulps,
                    errors.position_ulps, errors.drawn);
        EXPECT_GT(errors.drawn, 100);
        // Corners, normal, offset and the mesh's matrix are each rounded to floats: half an ulp each, and the sum.
        EXPECT_LE(errors.depth_ulps, 3);
        EXPECT_LE(errors.position_ulps, 3);
      }
    }
  }
}

// Of a sphere of flat facets every pixel's point must lie in its facet's plane: at most the sagitta inside the sphere.
TEST(DataImageTest, PositionsOfASphereLieBetweenItsFacetsAndItself) {
  constexpr int kRings = 32;
  const glm::dvec3 center(1e5, 2, -1e5);
  const FlatScene scene = MakeFlatScene({MakeSphere(center, 1, kRings)});
  const Camera camera = LookFrom(center + glm::dvec3(2, 2, 3), center);
  RenderRequest request = Request(camera, 96, 96);
  const Image position = RenderImage(scene, request, OutputKind::kPosition);
  const Image depth = RenderImage(scene, request, OutputKind::kDepth);
  const Image normal = RenderImage(scene, request, OutputKind::kNormal);
  ASSERT_TRUE(position.size() && depth.size() && normal.size());
  const double sagitta = 1.01 * (1 - std::pow(std::cos(M_PI / kRings / 2), 2)) + 0x1p-23 * 1e5;
  int drawn = 0;
  double worst_normal = 0;
  for (int y = 0; y < 96; ++y) {
    for (int x = 0; x < 96; ++x) {
      const glm::dvec3 p(position.at(x, y, 0), position.at(x, y, 1), position.at(x, y, 2));
      const glm::dvec3 n(normal.at(x, y, 0), normal.at(x, y, 1), normal.at(x, y, 2));
      if (depth.at(x, y, 0) == 0) {
        EXPECT_EQ(p, glm::dvec3(0));
        EXPECT_EQ(n, glm::dvec3(0));
        continue;
      }
      ++drawn;
      const double radius = glm::length(p - center);
      EXPECT_LE(radius, 1 + 0x1p-23 * 1e5);
      EXPECT_GE(radius, 1 - sagitta);
      EXPECT_NEAR(glm::dot(p - camera.eye_ws, camera.forward_ws), depth.at(x, y, 0), 0x1p-23 * 2e5);
      EXPECT_NEAR(glm::length(n), 1, 2e-7);
      worst_normal = std::max(worst_normal, glm::length(n - glm::normalize(p - center)));
    }
  }
  EXPECT_GT(drawn, 2000);
  // Smooth normals interpolated over a facet: a chord's cubic error, half floats (1e-3) and positions (1e5 ulps =
  // .012).
  EXPECT_LE(worst_normal, 0.02);
}

TEST(DataImageTest, NormalsTurnWithTheSideThatIsSeen) {
  const FlatScene scene = MakeFlatScene({MakePlate({0, 0, 0}, 4, 4)});
  for (const double side : {1.0, -1.0}) {
    const Image normal =
        RenderImage(scene, Request(LookFrom({0.2, 2 * side, 1}, {0, 0, 0}), 16, 16), OutputKind::kNormal);
    ASSERT_GT(normal.size(), 0u);
    EXPECT_EQ(normal.at(8, 8, 0), 0);
    EXPECT_EQ(normal.at(8, 8, 1), side);
    EXPECT_EQ(normal.at(8, 8, 2), 0);
  }
}

TEST(DataImageTest, AlbedoIsTheBaseColourAndObjectIdsAreNodesThenTheGround) {
  FlatScene scene = MakeFlatScene({MakeBox({-1, 0.5, 0}, {1, 1, 1}), MakeBox({1, 0.5, 0}, {1, 1, 1})});
  ASSERT_EQ(scene.nodes.size(), 2u);
  scene.materials[scene.meshes[1].material].base_color = {0.25f, 0.5f, 1, 1};
  RenderRequest request = Request(LookFrom({0, 4, 6}, {0, 0, 0}), 64, 64);
  request.ground = Ground{0, 3.2, false};
  const Image id = RenderImage(scene, request, OutputKind::kObjectId);
  const Image albedo = RenderImage(scene, request, OutputKind::kAlbedo);
  ASSERT_TRUE(id.size() && albedo.size());
  const std::set<float> ids(id.data(), id.data() + id.size());
  EXPECT_EQ(ids, (std::set<float>{0, 1, 2, 3}));
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 64; ++x) {
      const glm::vec3 color(albedo.at(x, y, 0), albedo.at(x, y, 1), albedo.at(x, y, 2));
      const float object = id.at(x, y, 0);
      if (object == 0 || object == 3) {
        EXPECT_NEAR(color.r, object == 3 ? 0.6 : 0, object * 0.2 / 1024) << "half floats";
      }
    }
  }
  EXPECT_EQ(id.at(20, 28, 0), 1);
  EXPECT_EQ(id.at(43, 28, 0), 2);
  EXPECT_EQ(albedo.at(43, 28, 0), 0.25f);
  EXPECT_EQ(albedo.at(43, 28, 1), 0.5f);
  EXPECT_EQ(albedo.at(43, 28, 2), 1.0f);
}

TEST(DataImageTest, ClippingPlanesCutAtTheirDistances) {
  // Seen under 45 degrees: depth grows from row to row.
  const FlatScene scene = MakeFlatScene({MakePlate({0, 0, 0}, 40, 40)});
  const Camera camera = LookFrom({0, 3, 3}, {0, 0, 0});
  for (Camera view : {camera, Ortho(camera, 3)}) {
    const Image all = RenderImage(scene, Request(view, 40, 40), OutputKind::kDepth);
    view.near_m = 4;
    view.far_m = 4.5;
    const Image cut = RenderImage(scene, Request(view, 40, 40), OutputKind::kDepth);
    ASSERT_TRUE(all.size() && cut.size());
    int kept = 0;
    for (size_t i = 0; i < all.size(); ++i) {
      ASSERT_GT(all.data()[i], 0);
      const bool is_inside = all.data()[i] > 4 && all.data()[i] < 4.5;
      EXPECT_EQ(cut.data()[i], is_inside ? all.data()[i] : 0) << all.data()[i];
      kept += is_inside;
    }
    EXPECT_GT(kept, 100);
    EXPECT_LT(kept, 1500);
  }
}

// Linear depth with its end far away would not tell a surface from another 1e-5 of the scene behind it.
TEST(DataImageTest, AnOrthographicCameraWithoutAFarPlaneResolvesCloseSurfaces) {
  for (const double near_m : {0.0, 1e-9, 1.0}) {
    const FlatScene scene = MakeFlatScene({MakePlate({0, 1e-4, 0}, 4, 4), MakePlate({0, 0, 0}, 8, 8)});
    Camera camera = Ortho(LookDown(10, 6), 6);
    camera.near_m = near_m;
    camera.far_m = 0;
    const Image id = RenderImage(scene, Request(camera, 60, 60), OutputKind::kObjectId);
    ASSERT_GT(id.size(), 0u);
    EXPECT_EQ(std::count(id.data(), id.data() + id.size(), 1.0f), 40 * 40) << near_m;
    EXPECT_EQ(std::count(id.data(), id.data() + id.size(), 2.0f), 60 * 60 - 40 * 40) << near_m;
  }
}

TEST(DataImageTest, SeveralOutputsOfOneRequestAreWhatTheyAreAloneFromOneGBuffer) {
  const FlatScene scene = MakeFlatScene({MakeSphere({0, 1, 0}, 0.5, 16), MakePlate({0, 0, 0}, 8, 8)});
  RenderRequest request = Request(LookFrom({3, 3, 3}, {0, 0, 0}), 48, 40);
  request.lights = {LightAbove(3, 1)};
  request.method = MultiMapOptions{4, 64};
  for (const int samples : {1, 4}) {
    request.samples = samples;
    const std::vector<OutputKind> kinds = {OutputKind::kDepth,    OutputKind::kFrame,  OutputKind::kVisibility,
                                           OutputKind::kPosition, OutputKind::kNormal, OutputKind::kAlbedo,
                                           OutputKind::kObjectId, OutputKind::kFrame};
    request.outputs = kinds;
    const auto all = TestRenderer().Render("test", scene, request, [] { return absl::OkStatus(); });
    ASSERT_OK(all);
    ASSERT_EQ(all->images.size(), kinds.size());
    const auto gbuffers = std::count_if(all->report.passes.begin(), all->report.passes.end(),
                                        [](const PassReport& pass) { return pass.name.ends_with("gbuffer"); });
    EXPECT_EQ(gbuffers, samples == 1 ? 1 : samples + 1);
    for (size_t i = 0; i < kinds.size(); ++i) {
      EXPECT_EQ(all->images[i].kind, kinds[i]);
      EXPECT_TRUE(AreEqual(all->images[i].image, RenderImage(scene, request, kinds[i]))) << int(kinds[i]);
    }
  }
}

TEST(DataImageTest, WhatNoOutputNeedsIsNotDrawnAndTheReportSaysSo) {
  const FlatScene scene = MakeFlatScene({MakePlate({0, 0, 0}, 8, 8)});
  RenderRequest request = Request(LookFrom({3, 3, 3}, {0, 0, 0}), 16, 16);
  request.lights = {LightAbove(3, 1)};
  const auto skips = [&](OutputKind kind) {
    RenderReport report;
    RenderImage(scene, request, kind, &report);
    std::set<std::string> names;
    for (const PassReport& pass : report.passes) {
      if (pass.is_skipped) names.insert(pass.name + ": " + pass.reason);
    }
    return names;
  };
  const std::string shade = "shade: no FRAME is asked";
  const std::string textures = "textures: no FRAME, NORMAL or ALBEDO is asked, and nothing is masked";
  const std::string ids = "object_ids: no OBJECT_ID and no shadow catcher is asked";
  const std::string light = "light[0]/multi_map: lights[0]: no output shows light";
  request.method = MultiMapOptions{4, 64};
  EXPECT_EQ(skips(OutputKind::kDepth), (std::set<std::string>{shade, textures, ids, light}));
  EXPECT_EQ(skips(OutputKind::kNormal), (std::set<std::string>{shade, ids, light}));
  EXPECT_EQ(skips(OutputKind::kObjectId), (std::set<std::string>{shade, textures, light}));
  const std::string nothing_between = "light[0]/multi_map: lights[0]: no occluder between it and the receivers";
  std::set<std::string> frame = skips(OutputKind::kFrame);
  frame.erase(nothing_between);
  EXPECT_EQ(frame, std::set<std::string>{ids});
}

}  // namespace
}  // namespace halfshade
