// The certificate's interval against the whole truth: every pixel by 4096 rays.
#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <random>

#include "renderer/image/compare.h"
#include "tests/support/flat_scene_builder.h"
#include "tests/support/render_fixture.h"
#include "tests/support/scene_makers.h"

namespace halfshade {
namespace {

constexpr const char* kScenes[] = {"S1", "S2", "S3", "S4", "S5", "S6", "plant", "colonnade"};

// HALFSHADE_CERTIFY_PAIRS=200 is the run that figures are quoted from: three minutes.
int PairCount() {
  const char* text = std::getenv("HALFSHADE_CERTIFY_PAIRS");
  return text != nullptr ? std::atoi(text) : 24;
}

// A scene with a light somewhere around its own, and the method of its turn.
RenderRequest PairRequest(int pair, FlatScene* scene) {
  std::mt19937 random(static_cast<uint32_t>(pair));
  const auto uniform = [&](double low, double high) { return low + (high - low) * double(random()) / 4294967296.0; };
  const std::string name = kScenes[pair % std::size(kScenes)];
  const MadeScene made = MakeScene(
      name, {.triangles = name == "S6" ? 8000u : 0u, .seed = uint32_t(pair), .light_share = uniform(0.05, 0.5)});
  *scene = MakeFlatScene(made.meshes);
  RenderRequest request = RequestFor(made);
  request.width = 128;
  request.height = 72;
  for (int axis = 0; axis < 3; ++axis) request.lights[0].center_ws[axis] += uniform(-0.2, 0.2);
  const MethodOptions methods[] = {MultiMapOptions{16, 512}, PcssOptions{}, HardOptions{1024}, RayOptions{16},
                                   MultiMapOptions{64, 1024}};
  request.method = methods[size_t(pair) / std::size(kScenes) % std::size(methods)];
  request.outputs = {OutputKind::kVisibility};
  return request;
}

// Over 0 where part of the light stands above the horizon: what is seen when nothing casts.
Image FacingMask(const FlatScene& scene, RenderRequest request) {
  for (uint32_t node = 0; node < scene.nodes.size(); ++node) {
    NodeOverride& change = request.node_overrides.emplace_back();
    change.node = node;
    change.casts = false;
  }
  return RenderVisibility(scene, request);
}

TEST(CertifyTest, TheIntervalHoldsTheTruthInNinetyTwoOfAHundredPairs) {
  const int pairs = PairCount();
  int held = 0;
  int wide = 0;
  for (int pair = 0; pair < pairs; ++pair) {
    FlatScene scene;
    RenderRequest request = PairRequest(pair, &scene);
    RenderReport report;
    request.certify = CertifyOptions{1024, 256};
    const Image tested = RenderVisibility(scene, request, &report);
    request.certify.reset();
    request.method = RayOptions{4096};
    request.seed = 99;
    const Image truth = RenderVisibility(scene, request);
    ASSERT_TRUE(report.error.measured.has_value()) << pair;

    const Image mask = FacingMask(scene, request);
    const auto error = Compare(truth, tested, &mask);
    ASSERT_OK(error);
    const bool holds = std::abs(*error->mae_shadowed - *report.error.measured) <= *report.error.ci95;
    held += holds;
    wide += *report.error.ci95 > *error->mae_shadowed / 2;
    std::printf("%3d %-9s %-9s true %.5f measured %.5f +- %.5f noise %.5f %s\n", pair,
                kScenes[size_t(pair) % std::size(kScenes)], report.method.c_str(), *error->mae_shadowed,
                *report.error.measured, *report.error.ci95, *report.error.noise, holds ? "" : "MISSED");
  }
  std::printf("held in %d of %d; wider than half the error in %d\n", held, pairs, wide);
  EXPECT_GE(held, pairs * 92 / 100);
  EXPECT_LE(wide, pairs / 4) << "an interval that holds everything says nothing";
}

}  // namespace
}  // namespace halfshade
