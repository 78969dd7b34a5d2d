#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <set>

#include "renderer/math/camera.h"
#include "renderer/math/form_factor.h"
#include "renderer/math/horizon.h"
#include "renderer/math/light_frame.h"
#include "renderer/math/sampling.h"
#include "tests/support/status_matchers.h"

namespace halfshade {
namespace {

// What ClipFromView projects to a pixel is what RayFromNdc sees through it, shifted or not.
TEST(ShiftedCameraTest, RaysAndProjectionAgreeAndTheSampleMovesByTheOffset) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (const bool is_orthographic : {false, true}) {
    for (int round = 0; round < 100; ++round) {
      Camera camera = *MakeLookAtCamera({3 * unit(random), 2, 3}, {0, unit(random), 0}, {0, 1, 0});
      camera.is_orthographic = is_orthographic;
      camera.ortho_height_m = 3;
      camera.far_m = 100;
      constexpr int kWidth = 64, kHeight = 48;
      const glm::dvec2 offset(unit(random) / 2, unit(random) / 2);
      const Camera shifted = ShiftedCamera(camera, offset, kWidth, kHeight);
      const double aspect = double(kWidth) / kHeight;
      const glm::dvec2 ndc(unit(random), unit(random));
      const glm::dmat3 rays = RayFromNdc(shifted, aspect);
      const glm::dvec3 across = rays[0] * ndc.x + rays[1] * ndc.y;
      const double depth = 5 + unit(random);
      const glm::dvec3 point =
          shifted.eye_ws + (is_orthographic ? across + rays[2] * depth : (across + rays[2]) * depth);
      const auto project = [&](const Camera& by) {
        const glm::dvec4 clip =
            ClipFromView(by, aspect) * glm::dvec4(ViewRotationFromWorld(by) * (point - by.eye_ws), 1);
        return glm::dvec2(clip) / clip.w;
      };
      EXPECT_LE(glm::length(project(shifted) - ndc), 1e-12);
      const glm::dvec2 moved = (project(camera) - ndc) * glm::dvec2(kWidth / 2.0, -kHeight / 2.0);
      EXPECT_LE(glm::length(moved - offset), 1e-12) << "in pixels, y down";
      EXPECT_EQ(shifted.target_ws, camera.target_ws) << "the ground stays";
    }
  }
}

TEST(OwenSobol2Test, EveryPowerOfTwoPrefixIsStratifiedInAllElementaryIntervals) {
  for (const uint32_t seed : {0u, 1u, 77u}) {
    for (int log = 0; log <= 10; ++log) {
      for (int log_x = 0; log_x <= log; ++log_x) {
        std::set<std::pair<int, int>> cells;
        for (uint32_t i = 0; i < 1u << log; ++i) {
          const glm::dvec2 p = OwenSobol2(i, seed);
          ASSERT_TRUE(p.x >= 0 && p.x < 1 && p.y >= 0 && p.y < 1);
          cells.emplace(int(std::ldexp(p.x, log_x)), int(std::ldexp(p.y, log - log_x)));
        }
        EXPECT_EQ(cells.size(), size_t(1) << log) << "seed " << seed << " 2^" << log << " x 2^" << log_x;
      }
    }
  }
}

TEST(OwenSobol2Test, SeedsGiveOtherPoints) {
  int same = 0;
  for (uint32_t i = 0; i < 256; ++i) same += OwenSobol2(i, 1) == OwenSobol2(i, 2);
  EXPECT_EQ(same, 0);
}

// Against 256 x 256 midpoints of the rectangle.
TEST(ShareAbovePlaneTest, IsTheShareOfPointsAbove) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int round = 0; round < 200; ++round) {
    const glm::dvec2 half(0.1 + std::abs(unit(random)), 0.1 + std::abs(unit(random)));
    const glm::dvec3 normal = glm::normalize(glm::dvec3(unit(random), unit(random), unit(random)));
    const double offset = 0.5 * unit(random);
    int above = 0;
    for (int i = 0; i < 256; ++i) {
      for (int j = 0; j < 256; ++j) {
        const glm::dvec3 p(((2 * i + 1) / 256.0 - 1) * half.x, ((2 * j + 1) / 256.0 - 1) * half.y, 0);
        above += glm::dot(normal, p) > offset;
      }
    }
    EXPECT_NEAR(ShareAbovePlane(half, normal, offset), above / 65536.0, 6e-3);
  }
}

TEST(ShareAbovePlaneTest, LinesAndPointsNeverDivideByZero) {
  EXPECT_EQ(ShareAbovePlane({0, 0}, {0, 0, 1}, -1), 1);
  EXPECT_EQ(ShareAbovePlane({0, 0}, {0, 0, 1}, 0), 0) << "in the plane is hidden";
  EXPECT_EQ(ShareAbovePlane({1, 0}, {1, 0, 0}, 0), 0.5);
  EXPECT_EQ(ShareAbovePlane({1, 0}, {1, 0, 0}, 0.5), 0.25);
  EXPECT_EQ(ShareAbovePlane({1, 1}, {0, 0, 1}, 0), 0);
}

TEST(ShareAbovePlaneTest, IsTheMeanOfItsFourQuarters) {
  const glm::dvec2 half(0.7, 0.3);
  const glm::dvec3 normal = glm::normalize(glm::dvec3(0.5, -0.9, 0.4));
  for (double offset = -0.5; offset < 0.5; offset += 0.013) {
    double sum = 0;
    for (const double x : {-0.35, 0.35}) {
      for (const double y : {-0.15, 0.15}) {
        sum += ShareAbovePlane(half * 0.5, normal, offset - glm::dot(normal, glm::dvec3(x, y, 0)));
      }
    }
    EXPECT_NEAR(ShareAbovePlane(half, normal, offset), sum / 4, 1e-12);
  }
}

TEST(RectangleIrradianceTest, FacingInfinityIsPi) {
  EXPECT_NEAR(RectangleIrradiance({1e6, 1e6}, {0, 0, 1}, {0, 0, -1}), M_PI, 1e-5);
}

TEST(RectangleIrradianceTest, FarAwayIsAreaTimesCosinesOverSquare) {
  const glm::dvec3 position = glm::dvec3(30, 40, 120);
  const glm::dvec3 normal = glm::normalize(glm::dvec3(0.1, -0.2, -1));
  const double far = 0.2 * 0.4 * PointIrradiance(position, normal);
  EXPECT_NEAR(RectangleIrradiance({0.1, 0.2}, position, normal) / far, 1, 1e-5);
}

TEST(RectangleIrradianceTest, IsTheSumOfItsPointsAlsoAcrossTheHorizon) {
  const glm::dvec3 position(0.2, -0.1, 0.6);
  for (const glm::dvec3 n : {glm::dvec3(0, 0, -1), glm::dvec3(1, 0.3, -0.2), glm::dvec3(-0.5, 1, 0.1)}) {
    const glm::dvec3 normal = glm::normalize(n);
    double sum = 0;
    constexpr int kSide = 400;
    for (int i = 0; i < kSide; ++i) {
      for (int j = 0; j < kSide; ++j) {
        const glm::dvec3 p((i + 0.5) / kSide * 2 - 1, (j + 0.5) / kSide - 0.5, 0);
        sum += PointIrradiance(position - p, normal) * 2.0 / kSide / kSide;
      }
    }
    EXPECT_NEAR(RectangleIrradiance({1, 0.5}, position, normal), sum, 1e-4);
  }
}

TEST(RectangleIrradianceTest, IsNothingBehindTheLight) {
  EXPECT_EQ(RectangleIrradiance({1, 1}, {0, 0, -1}, {0, 0, 1}), 0);
}

TEST(LightFrameTest, FarFromTheOriginDistancesKeepTheirPrecision) {
  AreaLight light;
  light.center_ws = {1e9, -1e9, 5};
  EXPECT_EQ(PointToLight(MakeLightFrame(light), light.center_ws + glm::dvec3(0.25, 0, 3)), glm::dvec3(0.25, 0, 3));
}

TEST(CameraTest, TheProjectionPutsThePixelRayWhereTheHeaderSays) {
  Camera camera = *MakeLookAtCamera({1, 2, 3}, {-2, 0.5, -1}, {0, 1, 0});
  camera.tan_half_fovy = 0.5;
  camera.near_m = 0.1;
  const double aspect = 1.5;
  for (const glm::dvec2 ndc : {glm::dvec2(0, 0), glm::dvec2(0.5, -0.25), glm::dvec2(-1, 1)}) {
    const glm::dvec3 ray = camera.forward_ws + (ndc.x * aspect * camera.right_ws + ndc.y * camera.up_ws) * 0.5;
    const glm::dvec4 clip = ClipFromView(camera, aspect) * glm::dvec4(ViewRotationFromWorld(camera) * (ray * 7.0), 1);
    EXPECT_NEAR(clip.x / clip.w, ndc.x, 1e-12);
    EXPECT_NEAR(clip.y / clip.w, ndc.y, 1e-12);
    EXPECT_NEAR(clip.z / clip.w, 0.1 / 7, 1e-12) << "reversed depth, far plane at infinity";
  }
}

TEST(CameraTest, BoundedAndOrthographicDepthRunFromOneToZero) {
  Camera camera = *MakeLookAtCamera({0, 0, 0}, {0, 0, -1}, {0, 1, 0});
  camera.near_m = 2;
  camera.far_m = 10;
  for (const bool is_orthographic : {false, true}) {
    camera.is_orthographic = is_orthographic;
    const glm::dmat4 clip = ClipFromView(camera, 1);
    const glm::dvec4 near = clip * glm::dvec4(0, 0, -2, 1), far = clip * glm::dvec4(0, 0, -10, 1);
    EXPECT_NEAR(near.z / near.w, 1, 1e-12);
    EXPECT_NEAR(far.z / far.w, 0, 1e-12);
  }
}

}  // namespace
}  // namespace halfshade
