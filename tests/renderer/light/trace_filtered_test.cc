// Rays that pixels share, against closed forms and against rays of their own. No GL.
#include "renderer/light/trace_filtered.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "renderer/light/trace_light.h"
#include "renderer/math/camera.h"
#include "renderer/scene/pose.h"
#include "tests/support/closed_forms.h"
#include "tests/support/flat_scene_builder.h"
#include "tests/support/render_fixture.h"
#include "tests/support/scene_makers.h"
#include "tests/support/status_matchers.h"

namespace halfshade {
namespace {

constexpr int kWidth = 100, kHeight = 90;  // no whole tiles, nor blocks
constexpr double kLightHeight = 2, kEyeHeight = 5;
constexpr float kPlateEdge = 0.8f;
constexpr double kPixel = 0.04;  // metres

absl::StatusOr<Rgba8Image> NoImages(const EncodedImage&) { return absl::UnimplementedError("no masks here"); }

AreaLight Light(double size) { return LightAbove(kLightHeight, size); }

std::unique_ptr<RayScene> Casting(const std::vector<GlbMesh>& meshes) {
  const FlatScene scene = MakeFlatScene(meshes);
  return *RayScene::Create(scene, *BuildPose(scene, scene.default_scene), NoImages);
}

std::unique_ptr<RayScene> Plate() { return Casting({MakePlate({0, 1, 0}, kPlateEdge, kPlateEdge)}); }

// The ground y = 0, seen from above: 3.6 m high, the plate's shadow so many pixels left of the middle and above it.
CpuReceivers Ground(int shift = 0) {
  CpuReceivers pixels;
  pixels.camera =
      *MakeLookAtCamera({shift * kPixel, kEyeHeight, shift * kPixel}, {shift * kPixel, 0, shift * kPixel}, {0, 0, -1});
  pixels.camera.is_orthographic = true;
  pixels.camera.ortho_height_m = kPixel * kHeight;
  pixels.width = kWidth;
  pixels.height = kHeight;
  pixels.planes.assign(size_t(kWidth) * kHeight, {0, 1, 0, -kEyeHeight});
  return pixels;
}

FilteredLight Trace(const RayScene& scene, const AreaLight& light, const CpuReceivers& pixels,
                    const FilteredTraceOptions& options) {
  auto traced = TraceFiltered(scene, light, pixels, options, [] { return absl::OkStatus(); });
  EXPECT_OK(traced);
  return traced.ok() ? *std::move(traced) : FilteredLight{};
}

// Hidden fractions of the ground behind the plate, in closed form.
std::vector<double> Truth(double light_size, const CpuReceivers& pixels) {
  std::vector<double> truth;
  for (size_t i = 0; i < pixels.size(); ++i) {
    const glm::dvec3 at = pixels.At(i).position_ws;
    truth.push_back(1 - VisibilityBehindPlate(glm::dvec2(light_size / 2), {0, 0, 1}, glm::dvec2(kPlateEdge / 2),
                                              {at.x, at.z, kLightHeight - at.y}));
  }
  return truth;
}

bool IsShadowed(double hidden) { return hidden > 1.0 / 512; }

template <typename Errors>
double MeanOverShadowed(const std::vector<double>& truth, const Errors& error_of) {
  double sum = 0;
  int count = 0;
  for (size_t i = 0; i < truth.size(); ++i) {
    if (!IsShadowed(truth[i])) continue;
    sum += error_of(i);
    ++count;
  }
  EXPECT_GT(count, 1000);
  return sum / count;
}

TEST(TraceFilteredTest, SharedRaysAreWorthSeveralOfAPixelsOwn) {
  const auto scene = Plate();
  const CpuReceivers pixels = Ground();
  const AreaLight light = Light(0.8);
  const std::vector<double> truth = Truth(0.8, pixels);
  double before = 1;
  for (const int rays : {1, 4, 16}) {
    const FilteredLight shared = Trace(*scene, light, pixels, {.rays = rays, .seed = 3});
    const auto own = TraceLight(*scene, light, pixels, {.rays = rays, .seed = 3}, [] { return absl::OkStatus(); });
    ASSERT_OK(own);
    const double error = MeanOverShadowed(truth, [&](size_t i) { return std::abs(shared.hidden[i] - truth[i]); });
    const double of_own = MeanOverShadowed(truth, [&](size_t i) { return std::abs(own->hidden[i] - truth[i]); });
    const double told = MeanOverShadowed(truth, [&](size_t i) { return shared.errors[i]; });
    std::printf("%d rays: %.5f, of its own %.5f, told %.5f; traced %lu of %lu\n", rays, error, of_own, told,
                shared.rays, own->rays);
    // Four rays of each pixel, all in all, take a third of the noise; with sixteen the blur is seen.
    EXPECT_LE(error, of_own / (rays < 16 ? 3 : 2));
    EXPECT_LT(error, before);
    EXPECT_LE(told, 2 * error);
    EXPECT_GE(told, error / 2);
    EXPECT_LE(shared.rays, own->rays);
    before = error;
  }
}

TEST(TraceFilteredTest, OnlyPenumbraHasMoreThanOneRay) {
  const auto scene = Plate();
  const CpuReceivers pixels = Ground();
  const std::vector<double> truth = Truth(0.2, pixels);
  const FilteredLight traced = Trace(*scene, Light(0.2), pixels, {.rays = 16});
  const auto penumbra = std::count_if(truth.begin(), truth.end(), [](double h) { return h > 0.01 && h < 0.99; });
  EXPECT_GT(traced.lit, pixels.size() / 4);
  EXPECT_LT(traced.rays, pixels.size() + 16 * 5 * uint64_t(penumbra)) << "blocks of it and those around";
  for (size_t i = 0; i < truth.size(); ++i) {
    if (truth[i] == 1) {
      EXPECT_GE(traced.hidden[i], 0.88f) << i << ": by its rim, .9 16^-.75 off its own rays";
    }
  }
}

TEST(TraceFilteredTest, TheSameNumbersOnAnyNumberOfThreads) {
  const auto scene = Plate();
  const CpuReceivers pixels = Ground();
  const FilteredLight one = Trace(*scene, Light(0.8), pixels, {.rays = 4, .threads = 1});
  for (const int threads : {2, 5}) {
    const FilteredLight many = Trace(*scene, Light(0.8), pixels, {.rays = 4, .threads = threads});
    EXPECT_EQ(many.hidden, one.hidden);
    EXPECT_EQ(many.errors, one.errors);
    EXPECT_EQ(many.rays, one.rays);
  }
  EXPECT_NE(Trace(*scene, Light(0.8), pixels, {.rays = 4, .seed = 1}).hidden, one.hidden);
}

// Bars above the plate among ground below it, a pixel wide: what one sees of the light is no business of the other.
TEST(TraceFilteredTest, SurfacesAsideOfEachOtherShareNothing) {
  const auto scene = Plate();
  CpuReceivers pixels = Ground();
  const std::vector<double> truth = Truth(0.1, pixels);
  for (size_t i = 0; i < pixels.size(); i += 2) pixels.planes[i].w = float(1.5 - kEyeHeight);
  const FilteredLight traced = Trace(*scene, Light(0.1), pixels, {.rays = 1});
  const auto is_umbra_around = [&](size_t i) {  // as far as a mean reaches
    for (int v = -2; v <= 2; ++v) {
      for (int u = -2; u <= 2; ++u) {
        if (truth[i + v * kWidth + u] != 1) return false;
      }
    }
    return true;
  };
  int umbra = 0;
  for (size_t i = 0; i < truth.size(); ++i) {
    if (i % 2 == 0) {
      EXPECT_EQ(traced.hidden[i], 0) << i;
    } else if (truth[i] == 1 && is_umbra_around(i)) {
      EXPECT_EQ(traced.hidden[i], 1) << i;
      ++umbra;
    }
  }
  EXPECT_GT(umbra, 200);
}

// An edge of less than a pixel would be blurred over five; a pixel's own rays say that it is none of it.
TEST(TraceFilteredTest, AMeanStaysWithinWhatThePixelsOwnRaysAllow) {
  const auto scene = Plate();
  const CpuReceivers pixels = Ground();
  const std::vector<double> truth = Truth(0.01, pixels);
  for (const int rays : {4, 16, 64, 600}) {  // the last in several rounds
    const FilteredLight traced = Trace(*scene, Light(0.01), pixels, {.rays = rays});
    double largest = 0;
    for (size_t i = 0; i < truth.size(); ++i) largest = std::max(largest, std::abs(traced.hidden[i] - truth[i]));
    EXPECT_LE(largest, 1.3 * std::pow(rays, -0.75)) << rays << ": .9 of it, and what its own rays are off by";
  }
}

// Tiles are lit by proof, or traced, and blocks have one ray or all: none of it is seen where they meet. The shadow
// stands at eight places among them, since errors are largest at its rims.
TEST(TraceFilteredTest, TileBordersAreAsExactAsTheirInside) {
  const auto scene = Plate();
  for (const double size : {0.2, 0.8}) {
    for (const int rays : {1, 4, 16}) {
      double sum[2] = {0, 0};
      int count[2] = {0, 0};
      for (int shift = 0; shift < 16; shift += 2) {
        const CpuReceivers pixels = Ground(shift);
        const std::vector<double> truth = Truth(size, pixels);
        const FilteredLight traced = Trace(*scene, Light(size), pixels, {.rays = rays, .seed = 5});
        for (size_t i = 0; i < truth.size(); ++i) {
          if (!IsShadowed(truth[i])) continue;
          const auto is_border = [](size_t at) { return at % 16 == 0 || at % 16 == 15; };
          const bool at_border = is_border(i % kWidth) || is_border(i / kWidth);
          sum[at_border] += std::abs(traced.hidden[i] - truth[i]);
          ++count[at_border];
        }
      }
      ASSERT_GT(count[true], 2000);
      std::printf("light %.1f, %d rays: %.5f at borders, %.5f inside\n", size, rays, sum[true] / count[true],
                  sum[false] / count[false]);
      EXPECT_LE(sum[true] / count[true], 1.2 * sum[false] / count[false]) << size << ", " << rays << " rays";
    }
  }
}

TEST(TraceFilteredTest, WhereNothingCastsNoRayIsTraced) {
  const FilteredLight traced = Trace(*Casting({}), Light(0.8), Ground(), {.rays = 4});
  EXPECT_EQ(traced.rays, 0u);
  EXPECT_EQ(traced.lit, size_t(kWidth) * kHeight);
  EXPECT_EQ(*std::max_element(traced.hidden.begin(), traced.hidden.end()), 0);
  EXPECT_EQ(*std::max_element(traced.errors.begin(), traced.errors.end()), 0);
}

}  // namespace
}  // namespace halfshade
