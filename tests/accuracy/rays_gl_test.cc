// Methods against rays, on scenes that have no closed form.
#include <gtest/gtest.h>

#include <cstdio>

#include "renderer/image/compare.h"
#include "tests/support/flat_scene_builder.h"
#include "tests/support/render_fixture.h"
#include "tests/support/scene_makers.h"

namespace halfshade {
namespace {

struct Case {
  std::string scene;
  double most = 0;  // mae_shadowed
};

class ClassTest : public testing::Test {
 protected:
  void Use(const std::string& name) {
    const MadeScene made = MakeScene(name, {.light_share = 0.2});
    scene_ = MakeFlatScene(made.meshes);
    request_ = RequestFor(made);
    request_.width = 160;
    request_.height = 90;
  }
  Image Render(const MethodOptions& method, uint32_t seed = 0, uint64_t* count = nullptr) {
    request_.method = method;
    request_.seed = seed;
    RenderReport report;
    const Image v = RenderVisibility(scene_, request_, &report);
    EXPECT_GT(v.size(), 0u);
    if (count != nullptr) *count = ResolveCount(report);
    return v;
  }
  static double MaeShadowed(const Image& reference, const Image& tested) {
    const auto error = Compare(reference, tested, nullptr);
    EXPECT_OK(error);
    EXPECT_GT(error->samples_shadowed, 200u);
    return error->mae_shadowed.value_or(1);
  }

  FlatScene scene_;
  RenderRequest request_;
};

// The brute force converges to what rays say; measured .0003, .0013, .0017. Thresholds: a map of 2048^2 moves an edge
// by up to half a texel, clutter has the most edges.
TEST_F(ClassTest, AThousandMapsAgreeWithRays) {
  for (const Case& c : {Case{"S2", 0.003}, Case{"S3", 0.003}, Case{"S5", 0.006}}) {
    Use(c.scene);
    const Image reference = Render(RayOptions{4096});
    const double noise = MaeShadowed(reference, Render(RayOptions{4096}, 1)) / 2;
    const double error = MaeShadowed(reference, Render(MultiMapOptions{1024, 2048}));
    std::printf("%s: maps against rays %.5f, noise of the rays %.5f\n", c.scene.c_str(), error, noise);
    EXPECT_LE(error, c.most) << c.scene;
    EXPECT_LE(noise, error / 2) << "else the reference says nothing";
  }
}

// Where most pixels agree with their neighbours, adaptive rays reach the error of a fixed number with half of them or
// less.
TEST_F(ClassTest, AdaptiveRaysNeedAtMostHalfOfFixedOnesForTheSameError) {
  for (const char* name : {"S1", "S2", "S4"}) {
    Use(name);
    const Image reference = Render(RayOptions{16384}, 7);
    uint64_t fixed_rays = 0, adaptive_rays = 0;
    const double fixed = MaeShadowed(reference, Render(RayOptions{256}, 1, &fixed_rays));
    const double adaptive = MaeShadowed(reference, Render(RayOptions{4096, true, 0.0045f}, 1, &adaptive_rays));
    std::printf("%s: fixed %.5f with %.1f M rays, adaptive %.5f with %.1f M\n", name, fixed, double(fixed_rays) * 1e-6,
                adaptive, double(adaptive_rays) * 1e-6);
    EXPECT_LE(adaptive, fixed) << name;
    EXPECT_GT(adaptive_rays, 0u);
    EXPECT_LE(adaptive_rays, fixed_rays / 2) << name;
  }
}

}  // namespace
}  // namespace halfshade
