// What the door gets from SHAFT beside visibility.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <cstdio>
#include <cstring>
#include <glm/gtc/matrix_transform.hpp>
#include <string>
#include <vector>

#include "renderer/image/compare.h"
#include "renderer/plan/choose_method.h"
#include "renderer/scene/pose.h"
#include "tests/support/flat_scene_builder.h"
#include "tests/support/mesh_parts.h"
#include "tests/support/render_fixture.h"
#include "tests/support/scene_makers.h"

namespace halfshade {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

const PassReport* ResolveOf(const RenderReport& report) {
  for (const PassReport& pass : report.passes) {
    if (pass.name == "light[0]/resolve") return &pass;
  }
  return nullptr;
}

TEST(ShaftReportTest, ThePredictedErrorIsTheTrueOneWithinAFactorOfTwo) {
  for (const char* name : {"S2", "S3", "S5"}) {
    const MadeScene made = MakeScene(name, {.light_share = 0.2});
    const FlatScene scene = MakeFlatScene(made.meshes);
    RenderRequest request = RequestFor(made);
    request.width = 160;
    request.height = 90;
    request.method = RayOptions{4096};
    const Image truth = RenderVisibility(scene, request);
    request.method = ShaftOptions{16};
    RenderReport report;
    const Image v = RenderVisibility(scene, request, &report);
    const auto error = Compare(truth, v, nullptr);
    ASSERT_OK(error);
    ASSERT_TRUE(report.error.predicted);
    std::printf("%s: error %.5f, predicted %.5f\n", name, *error->mae_shadowed, *report.error.predicted);
    EXPECT_GT(*report.error.predicted, *error->mae_shadowed / 2) << name;
    EXPECT_LT(*report.error.predicted, *error->mae_shadowed * 2) << name;
  }
}

std::string RowsOf(const RenderReport& report) {
  for (const auto& [name, value] : report.options) {
    if (name == "rows") return value;
  }
  return "";
}

// S5 in a picture that is large enough to be sampled for its rows.
struct SampledScene {
  FlatScene scene;
  RenderRequest request;
};

SampledScene MakeSampledScene() {
  const MadeScene made = MakeScene("S5", {.light_share = 0.2});
  SampledScene sampled{MakeFlatScene(made.meshes), RequestFor(made)};
  sampled.request.width = 320;
  sampled.request.height = 180;
  return sampled;
}

TEST(ShaftReportTest, RowsThatAreLeftOpenAreTheFewestThatMeetTheError) {
  auto [scene, request] = MakeSampledScene();
  request.method = RayOptions{2048};
  const Image truth = RenderVisibility(scene, request);
  std::string last;
  for (const float max_error : {0.02f, 0.01f, 0.004f, 0.002f, 0.00001f}) {
    request.method = ShaftOptions{.max_error = max_error};
    RenderReport report;
    const auto error = Compare(truth, RenderVisibility(scene, request, &report), nullptr);
    ASSERT_OK(error);
    std::printf("%g: %s rows, error %.5f\n", double(max_error), RowsOf(report).c_str(), *error->mae_shadowed);
    if (max_error > 0.001f) {
      EXPECT_LE(*error->mae_shadowed, 1.25 * double(max_error));
    }
    if (last.empty()) {
      EXPECT_EQ(RowsOf(report), "4");
    }
    EXPECT_NE(RowsOf(report), last);
    last = RowsOf(report);
  }
  EXPECT_EQ(last, "64");
}

// Half of them are told to be off by more, and what is chosen is told to be off by less: the sample is judged as the
// picture is.
TEST(ShaftReportTest, RowsThatAreLeftOpenAreThoseThatThePictureIsToldBy) {
  for (const char* name : {"S2", "S6"}) {
    const MadeScene made = MakeScene(name, {.triangles = 8000, .light_share = 0.3});
    const FlatScene scene = MakeFlatScene(made.meshes);
    RenderRequest request = RequestFor(made);
    request.width = 320;
    request.height = 180;
    for (const float max_error : {0.004f, 0.0016f, 0.0008f}) {
      RenderReport report;
      const auto told = [&](int rows) {
        request.method = ShaftOptions{.rows = rows, .max_error = max_error};
        RenderVisibility(scene, request, &report);
        return report.error.predicted.value_or(1);
      };
      const double chosen = told(0);
      const int rows = std::stoi(RowsOf(report));
      std::printf("%s, %g: %d rows, told %.5f\n", name, double(max_error), rows, chosen);
      EXPECT_LE(chosen, 1.15 * double(max_error)) << "of all tiles, not of a sample";
      if (rows >= 16) {
        EXPECT_GT(told(rows / 2), 0.8 * double(max_error)) << name << " " << rows;
      }
    }
  }
}

// As a server settles it: by name, rows left open, with a budget.
absl::StatusOr<RenderResult> RenderSettled(const FlatScene& scene, RenderRequest request, double max_error, int rows) {
  request.method = ShaftOptions{.rows = rows};
  request.budget.max_error = max_error;
  const auto pose = BuildPose(scene, 0);
  if (!pose.ok()) return pose.status();
  const absl::Status settled = SettleMethod(scene, *pose, uint64_t(request.width) * request.height, &request);
  if (!settled.ok()) return settled;
  request.outputs = {OutputKind::kVisibility};
  return TestRenderer().Render("", scene, request, [] { return absl::OkStatus(); });
}

TEST(ShaftReportTest, ByNameWithABudgetRowsAreChosenForItAndWhatBreaksItIsRefused) {
  const auto [scene, request] = MakeSampledScene();
  int last = 0;
  for (const double max_error : {0.03, 0.01, 0.003}) {
    const auto result = RenderSettled(scene, request, max_error, 0);
    ASSERT_OK(result);
    ASSERT_TRUE(result->report.error.predicted);
    std::printf("%g: %s rows, predicted %.5f\n", max_error, RowsOf(result->report).c_str(),
                *result->report.error.predicted);
    EXPECT_LE(*result->report.error.predicted, max_error);
    EXPECT_GT(std::stoi(RowsOf(result->report)), last);
    last = std::stoi(RowsOf(result->report));
  }
  // What 64 rows do not reach; and rows that are named stay, whatever the budget.
  EXPECT_THAT(RenderSettled(scene, request, 0.00003, 0),
              StatusIs(absl::StatusCode::kFailedPrecondition, HasSubstr("budget.max_error: 3e-05; the error is")));
  EXPECT_THAT(RenderSettled(scene, request, 0.003, 8),
              StatusIs(absl::StatusCode::kFailedPrecondition, HasSubstr("budget.max_error: 0.003; the error is")));
  const auto eight = RenderSettled(scene, request, 0.01, 8);
  ASSERT_OK(eight);
  EXPECT_EQ(RowsOf(eight->report), "8");
}

TEST(ShaftTest, LightDataThatTheCacheCannotHoldIsRefusedAndAutoTakesRays) {
  const MadeScene made = MakeScene("S5", {.light_share = 0.2});
  const FlatScene scene = MakeFlatScene(made.meshes);
  RenderRequest request = RequestFor(made);
  request.width = 64;
  request.height = 36;
  request.outputs = {OutputKind::kVisibility};
  request.method = ShaftOptions{.rows = 8};
  const auto render = [&](uint64_t light_data_bytes) -> absl::StatusOr<RenderReport> {
    auto renderer =
        Renderer::Create(&TestContext(), [](const EncodedImage&) { return absl::UnimplementedError("no textures"); },
                         {.light_data_bytes = light_data_bytes});
    if (!renderer.ok()) return renderer.status();
    auto result = (*renderer)->Render("", scene, request, [] { return absl::OkStatus(); });
    if (!result.ok()) return result.status();
    return std::move(result->report);
  };
  const auto whole = render(512 << 20);
  ASSERT_OK(whole);
  uint64_t bytes = 0;
  for (const CacheReport& cache : whole->caches) {
    if (cache.name == "light[0]/light_data") bytes = cache.bytes;
  }
  ASSERT_GT(bytes, 0u);
  EXPECT_OK(render(bytes));
  // One byte less, and what is refused before a polygon is made.
  for (const uint64_t less : {bytes - 1, bytes / 100}) {
    EXPECT_THAT(render(less),
                StatusIs(absl::StatusCode::kResourceExhausted,
                         HasSubstr("the light cache holds " + std::to_string(less) + "; ray has no such bound")));
  }
  request.is_auto = true;
  const auto by_rays = render(bytes - 1);
  ASSERT_OK(by_rays);
  EXPECT_EQ(by_rays->method, "ray");
  EXPECT_THAT(by_rays->reason, HasSubstr("ray in its place: shaft: "));
}

// What its tiles find is counted, not timed, so that the choice is the same on every machine.
TEST(ShaftTest, ListsThatAreDearerThanRaysAreLeftToThem) {
  const MadeScene made = MakeScene("S6", {.triangles = 8000, .light_share = 0.2});
  const FlatScene scene = MakeFlatScene(made.meshes);
  RenderRequest request = RequestFor(made);
  request.width = 160;
  request.height = 90;
  request.outputs = {OutputKind::kVisibility};
  request.budget.max_error = 0.03;
  const auto render = [&](uint64_t most_polygons, bool is_auto) -> absl::StatusOr<RenderReport> {
    request.method = ShaftOptions{.max_error = 0.024f, .most_polygons = most_polygons};
    request.is_auto = is_auto;
    auto renderer = Renderer::Create(&TestContext(), [](const EncodedImage&) { return absl::UnimplementedError(""); });
    if (!renderer.ok()) return renderer.status();
    auto result = (*renderer)->Render("", scene, request, [] { return absl::OkStatus(); });
    if (!result.ok()) return result.status();
    return std::move(result->report);
  };
  const auto whole = render(0, true);
  ASSERT_OK(whole);
  EXPECT_EQ(whole->method, "shaft");
  uint64_t polygons = 0;
  for (const PassReport& pass : whole->passes) {
    if (pass.name == "light[0]/resolve") polygons = pass.count;
  }
  ASSERT_GT(polygons, 0u);
  const auto with_room = render(2 * polygons, true);
  ASSERT_OK(with_room);
  EXPECT_EQ(with_room->method, "shaft");
  const auto by_rays = render(polygons / 2, true);
  ASSERT_OK(by_rays);
  EXPECT_EQ(by_rays->method, "ray");
  EXPECT_THAT(by_rays->reason, HasSubstr("ray in its place: shaft: lists of about "));
  EXPECT_THAT(render(polygons / 2, false),
              StatusIs(absl::StatusCode::kResourceExhausted, HasSubstr("dearer than rays")));
}

// Sixty of 5000 triangles each: kept once. One is mirrored, one squeezed flat, one reaches the light's plane.
TEST(ShaftTest, WhatAMeshInManyPlacesHidesIsWhatRaysSay) {
  GlbMesh mesh;
  AddStarSolid(mesh, {0, 0, 0}, 36,
               [](const glm::dvec3& d) { return 1 + 0.3 * std::sin(5 * d.x) * std::cos(4 * d.y); });
  FlatScene scene = MakeFlatScene({mesh, MakePlate({0, 0, 0}, 8, 8)});
  const Node node = scene.nodes[0];
  for (int i = 0; i < 60; ++i) {
    if (i > 0) {
      scene.scenes[0].roots.push_back(uint32_t(scene.nodes.size()));
      scene.nodes.push_back(node);
    }
    glm::dmat4& place = i > 0 ? scene.nodes.back().local : scene.nodes[0].local;
    const glm::dvec3 at(i % 8 * 0.5 - 1.75, i == 5 ? 3 : 0.3 + 0.1 * (i % 5), i / 8 * 0.5 - 1.75);
    place = glm::rotate(glm::translate(glm::dmat4(1), at), 0.7 * i, {0.2, 1.0, 0.1});
    place = glm::scale(place, glm::dvec3(i == 3 ? -0.2 : 0.2, i == 4 ? 0 : 0.2, 0.15));
  }
  RenderRequest request;
  request.camera = LookFrom({3, 4, 4}, {0, 0, 0});
  request.width = 160;
  request.height = 120;
  request.lights = {LightAbove(3, 0.5)};
  request.outputs = {OutputKind::kVisibility};
  request.method = RayOptions{4096};
  const Image truth = RenderVisibility(scene, request);
  request.method = ShaftOptions{.rows = 64};
  RenderReport report;
  const Image v = RenderVisibility(scene, request, &report);
  for (const CacheReport& cache : report.caches) {
    // Two copies of 5040 triangles and levels take 1.2 MB, sixty would take 36.
    if (cache.name == "light[0]/light_data") {
      EXPECT_LT(cache.bytes, 2u << 20);
    }
  }
  const auto error = Compare(truth, v, nullptr);
  ASSERT_OK(error);
  std::printf("error %.5f over shadowed pixels, p999 %.5f; predicted %.5f\n", *error->mae_shadowed, *error->p999,
              *report.error.predicted);
  // As where nothing is shared: what the samples of both miss.
  EXPECT_LT(*error->mae_shadowed, 0.002);
  EXPECT_LT(*error->p999, 0.02);
}

TEST(ShaftTest, TheBytesAreTheSameOnOneThreadAndOnTwo) {
  const MadeScene made = MakeScene("S5", {.light_share = 0.2});
  const FlatScene scene = MakeFlatScene(made.meshes);
  RenderRequest request = RequestFor(made);
  request.width = 320;
  request.height = 180;
  request.cache = CacheMode::kRefresh;
  for (const ShaftOptions& options :
       {ShaftOptions{.rows = 16}, ShaftOptions{.rows = 8, .is_sparse = true}, ShaftOptions{.max_error = 0.01f}}) {
    request.method = options;
    std::vector<Image> images;
    for (const size_t threads : {1, 2}) {
      const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
      images.push_back(RenderVisibility(scene, request));
    }
    EXPECT_EQ(std::memcmp(images[0].data(), images[1].data(), images[0].size() * sizeof(float)), 0);
  }
}

TEST(ShaftReportTest, TheSparseFormDrawsLessAndIsNoWorse) {
  for (const char* name : {"S2", "S6"}) {
    const MadeScene made = MakeScene(name, {.triangles = 8000, .light_share = 0.2});
    const FlatScene scene = MakeFlatScene(made.meshes);
    RenderRequest request = RequestFor(made);
    request.method = RayOptions{1024};
    const Image truth = RenderVisibility(scene, request);
    double error[2], p999[2], predicted[2];
    uint64_t drawn[2];
    for (const bool is_sparse : {false, true}) {
      request.method = ShaftOptions{8, is_sparse};
      RenderReport report;
      const Image v = RenderVisibility(scene, request, &report);
      const auto compared = Compare(truth, v, nullptr);
      ASSERT_OK(compared);
      error[is_sparse] = *compared->mae_shadowed;
      p999[is_sparse] = *compared->p999;
      drawn[is_sparse] = ResolveOf(report)->count;
      predicted[is_sparse] = *report.error.predicted;
    }
    std::printf("%s: polygons %.2f, error %.2f, p999 %.2f of the dense form's\n", name,
                double(drawn[1]) / double(drawn[0]), error[1] / error[0], p999[1] / p999[0]);
    EXPECT_LT(double(drawn[1]), 0.9 * double(drawn[0])) << name;
    EXPECT_LT(error[1], error[0]) << name;
    EXPECT_LT(p999[1], 1.1 * p999[0]) << name;
    for (const bool is_sparse : {false, true}) {
      const double ratio = predicted[is_sparse] / error[is_sparse];
      std::printf("%s, %s: %.2f of the error was predicted\n", name, is_sparse ? "sparse" : "dense", ratio);
      // Interpolated neighbours share their samples, so that the picture says nothing of them: what the samples say
      // alone errs upwards (picture_error.h).
      EXPECT_GT(ratio, is_sparse ? 1 : 0.5) << name;
      EXPECT_LT(ratio, is_sparse ? 3 : 2) << name;
    }
  }
}

TEST(ShaftReportTest, TilesWithNothingInTheirShaftsAreCountedAsLit) {
  // 4 x 4 tiles of a ground, and a plate whose shadow is within the one that is first in both axes.
  RenderRequest request;
  request.camera = LookDown(0.2, 4);
  request.width = request.height = 64;
  request.lights = {LightAbove(2, 0.1, {-1.5, -1.5})};
  request.method = ShaftOptions{16};
  RenderReport report;
  RenderVisibility(MakeFlatScene({MakePlate({0, 0, 0}, 8, 8), MakePlate({-1.5, 1, -1.5}, 0.1, 0.1)}), request, &report);
  const PassReport* resolve = ResolveOf(report);
  ASSERT_NE(resolve, nullptr);
  EXPECT_THAT(resolve->reason, StartsWith("15 tiles lit"));
  EXPECT_GT(resolve->count, 0u);
  EXPECT_LE(resolve->count, 16u);  // the one polygon, in blocks of one tile
}

}  // namespace
}  // namespace halfshade
