// The skips must be proofs for every light: turned, far off, long and thin, a line, a point.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "renderer/math/camera.h"
#include "renderer/math/light_frame.h"
#include "renderer/plan/frame_plan.h"
#include "tests/support/flat_scene_builder.h"

namespace halfshade {
namespace {

class SkipPredicateTest : public testing::Test {
 protected:
  double Between(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  glm::dvec3 Point(double reach) { return {Between(-reach, reach), Between(-reach, reach), Between(-reach, reach)}; }

  AreaLight Light(double reach) {
    AreaLight light;
    light.center_ws = Point(reach);
    light.normal_ws = glm::normalize(Point(1));
    light.axis_u_ws = glm::normalize(glm::cross(light.normal_ws, Point(1)));
    light.axis_v_ws = glm::cross(light.normal_ws, light.axis_u_ws);
    const int shape = std::uniform_int_distribution<int>(0, 3)(random_);
    light.width_m = shape == 0 ? 0 : std::exp(Between(-6, 1));
    light.height_m = shape <= 1 ? 0 : std::exp(Between(-6, 1));
    return light;
  }

  Box3d BoxAround(const glm::dvec3& middle, double reach) {
    Box3d box;
    box.Add(middle + Point(reach));
    box.Add(middle + Point(reach));
    return box;
  }

  glm::dvec3 PointIn(const Box3d& box) {
    return glm::mix(box.min, box.max, glm::dvec3(Between(0, 1), Between(0, 1), Between(0, 1)));
  }

  glm::dvec3 PointOn(const AreaLight& light) {
    return light.center_ws + light.axis_u_ws * (light.width_m * Between(-0.5, 0.5)) +
           light.axis_v_ws * (light.height_m * Between(-0.5, 0.5));
  }

 private:
  std::mt19937 random_{29};
};

// Does the open segment meet the box? Slabs, exactly.
bool Meets(const glm::dvec3& from, const glm::dvec3& to, const Box3d& box) {
  double begin = 0, end = 1;
  for (int axis = 0; axis < 3; ++axis) {
    const double along = to[axis] - from[axis];
    double enter = (box.min[axis] - from[axis]) / along;
    double leave = (box.max[axis] - from[axis]) / along;
    if (enter > leave) std::swap(enter, leave);
    begin = std::max(begin, enter);
    end = std::min(end, leave);
  }
  return begin < end;
}

TEST_F(SkipPredicateTest, NoOccluderIsNeverSaidWhereASegmentMeetsOne) {
  int skips = 0, met = 0;
  for (int round = 0; round < 20000; ++round) {
    const AreaLight light = Light(3);
    const std::vector<Box3d> receivers = {BoxAround(Point(2), 1), BoxAround(Point(2), 1)};
    // Close to a segment, so that about as many stand in the way as beside it.
    const glm::dvec3 on_segment = glm::mix(PointOn(light), PointIn(receivers[0]), Between(0, 1.2));
    const std::vector<Box3d> occluders = {BoxAround(on_segment + Point(1), 0.7)};
    const bool is_skipped = HasNoOccluder(light, occluders, receivers);
    bool is_met = false;
    for (int i = 0; i < 64 && !is_met; ++i) {
      const glm::dvec3 to = PointIn(receivers[size_t(i % 2)]);
      if (PointToLight(MakeLightFrame(light), to).z <= 0) continue;
      is_met = Meets(PointOn(light), to, occluders[0]);
    }
    skips += is_skipped;
    met += is_met;
    ASSERT_FALSE(is_skipped && is_met) << round;
  }
  EXPECT_GT(skips, 2000) << "the skip must fire often enough to be tested";
  EXPECT_GT(met, 2000);
}

TEST_F(SkipPredicateTest, FacingAwayIsNeverSaidWhereAReceiverStandsInFront) {
  int skips = 0;
  for (int round = 0; round < 20000; ++round) {
    const AreaLight light = Light(3);
    const Box3d receiver = BoxAround(Point(2), 1);
    if (!FacesAway(light, {receiver})) continue;
    ++skips;
    for (int i = 0; i < 16; ++i) ASSERT_LE(PointToLight(MakeLightFrame(light), PointIn(receiver)).z, 0) << round;
  }
  EXPECT_GT(skips, 2000);
}

TEST_F(SkipPredicateTest, TheSeenGroundHoldsEveryPointOfItThatHasAPixel) {
  int seen = 0, unseen = 0;
  for (int round = 0; round < 2000; ++round) {
    RenderRequest request;
    request.width = 64;
    request.height = 48;
    request.ground = Ground{Between(-1, 1), Between(1, 20), false};
    const auto camera = MakeLookAtCamera(Point(4), Point(4), {0, 1, 0});
    if (!camera.ok()) continue;
    request.camera = *camera;
    request.camera.is_orthographic = round % 3 == 0;
    request.camera.near_m = request.camera.is_orthographic ? 0 : 0.01;
    request.camera.target_ws = {0, 0, 0};
    const Box3d box = SeenGround(request, request.camera);
    const auto quad = GroundQuad(request);
    const glm::dmat4 clip_from_camera =
        ClipFromView(request.camera, 64.0 / 48) * glm::dmat4(ViewRotationFromWorld(request.camera));
    for (int i = 0; i < 64; ++i) {
      const glm::dvec3 p =
          glm::mix(glm::mix(quad[0], quad[1], Between(0, 1)), glm::mix(quad[3], quad[2], Between(0, 1)), Between(0, 1));
      const glm::dvec4 clip = clip_from_camera * glm::dvec4(p - request.camera.eye_ws, 1);
      if (clip.w <= 0 || std::abs(clip.x) > clip.w || std::abs(clip.y) > clip.w || clip.z > clip.w) {
        ++unseen;
        continue;
      }
      ++seen;
      ASSERT_FALSE(box.IsEmpty()) << round;
      for (const int axis : {0, 2}) {
        ASSERT_GE(p[axis], box.min[axis] - 1e-9) << round;
        ASSERT_LE(p[axis], box.max[axis] + 1e-9) << round;
      }
    }
  }
  EXPECT_GT(seen, 5000);
  EXPECT_GT(unseen, 5000);
}

TEST_F(SkipPredicateTest, SeenTrianglesAreAllThatHaveACornerInView) {
  const FlatScene scene = MakeFlatScene({MakeSphere({0, 0, 0}, 1, 40)});
  const Pose pose = *BuildPose(scene, 0);
  const Instance& instance = pose.instances[0];
  const Mesh& mesh = scene.meshes[0];
  ASSERT_GT(mesh.cluster_count, 8u);
  uint64_t left_out = 0, kept = 0;
  for (int round = 0; round < 200; ++round) {
    auto camera = MakeLookAtCamera(Point(3), Point(2), {0, 1, 0});
    if (!camera.ok()) continue;
    camera->near_m = 0.01;
    const glm::dmat4 clip_from_mesh = ClipFromView(*camera, 1.5) * glm::dmat4(ViewRotationFromWorld(*camera));
    std::vector<bool> is_kept(mesh.TriangleCount(), false);
    uint32_t end = 0;
    for (const TriangleRun& run : SeenTriangles(scene, instance, *camera, 1.5)) {
      ASSERT_TRUE(run.first > end || end == 0) << "in order, and joined where they touch";
      end = run.first + run.count;
      ASSERT_LE(end, mesh.TriangleCount());
      std::fill(is_kept.begin() + run.first, is_kept.begin() + end, true);
    }
    for (uint32_t i = 0; i < mesh.index_count; ++i) {
      const glm::dvec4 p(instance.world_from_mesh * glm::dvec4(scene.positions[scene.indices[i]], 1));
      const glm::dvec4 clip = clip_from_mesh * glm::dvec4(glm::dvec3(p) - camera->eye_ws, 1);
      const bool is_in_view = std::abs(clip.x) < clip.w && std::abs(clip.y) < clip.w && clip.z > 0 && clip.z < clip.w;
      ASSERT_TRUE(is_kept[i / 3] || !is_in_view) << round;
    }
    left_out += uint64_t(std::count(is_kept.begin(), is_kept.end(), false));
    kept += uint64_t(std::count(is_kept.begin(), is_kept.end(), true));
  }
  EXPECT_GT(left_out, kept / 4);
  EXPECT_GT(kept, 0u);
}

TEST(NoPowerTest, AsksRadianceOfRectanglesAndIntensityOfLinesAndPoints) {
  AreaLight light;
  light.radiance = glm::vec3(0, 0, 1);
  EXPECT_TRUE(HasNoPower(light)) << "a point";
  light.width_m = 1;
  EXPECT_TRUE(HasNoPower(light)) << "a line";
  light.height_m = 1;
  EXPECT_FALSE(HasNoPower(light));
  light.radiance = glm::vec3(0);
  light.intensity = glm::vec3(1);
  EXPECT_TRUE(HasNoPower(light));
  light.height_m = 0;
  EXPECT_FALSE(HasNoPower(light));
}

}  // namespace
}  // namespace halfshade
