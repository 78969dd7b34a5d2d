// Every registered method on every scene class, against rays or the closed form. A figure may be
//   sampling of the light, from the reference's own v and the method's number of points (SamplingOf), and
//   its model's error (thresholds.h);
// nothing else. Methods run at TestMethod::Fine().
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ostream>
#include <set>

#include "renderer/image/compare.h"
#include "renderer/math/light_frame.h"
#include "renderer/scene/pose.h"
#include "tests/accuracy/thresholds.h"
#include "tests/support/closed_forms.h"
#include "tests/support/render_fixture.h"
#include "tests/support/scene_classes.h"

namespace halfshade {
namespace {

constexpr int kReferenceRays = 4096;
constexpr uint32_t kReferenceSeed = 99;  // no method's

struct Case {
  std::string scene;
  double light = 0.2;
  int width = 320, height = 180;
  uint32_t triangles = 0;
};

void PrintTo(const Case& tested, std::ostream* out) { *out << tested.scene << " light " << tested.light; }

std::vector<Case> Cases() {
  std::vector<Case> cases;
  // The dense ones at a count that hundreds of depth passes of a software rasteriser can afford.
  for (const std::string& name : SceneClassNames()) {
    cases.push_back({.scene = name, .triangles = name == "S6" || name == "S7" ? 30000u : 0u});
  }
  for (const char* name : {"S1", "S2", "S3", "S4"}) {
    for (const double light : {0.05, 0.5}) cases.push_back({name, light, 160, 90});
  }
  return cases;
}

// What is known of a case before any method draws it: its truth and the pixels that count.
struct Truth {
  FlatScene scene;
  RenderRequest request;
  Image visibility;
  Image share;   // of the light above the receiver's plane
  Image all;     // 1 where something is drawn that faces part of the light
  Image ground;  // of those, the ground
};

// Behind the plate of S1 from every pixel's position: no noise.
Image PlateTruth(const AreaLight& light, const FlatScene& scene, const Image& positions) {
  const LightFrame frame = MakeLightFrame(light);
  const Box3d bounds = BuildPose(scene, 0)->bounds_ws;
  const glm::dvec3 center = PointToLight(frame, bounds.Center());
  const glm::dvec3 extent = glm::abs(frame.light_from_world_rotation * bounds.Extent());
  Image truth(positions.width(), positions.height(), 1);
  for (int y = 0; y < truth.height(); ++y) {
    for (int x = 0; x < truth.width(); ++x) {
      const glm::dvec3 position(positions.at(x, y, 0), positions.at(x, y, 1), positions.at(x, y, 2));
      truth.at(x, y, 0) = float(VisibilityBehindPlate({light.width_m / 2, light.height_m / 2}, center,
                                                      glm::dvec2(extent) / 2.0, PointToLight(frame, position)));
    }
  }
  return truth;
}

Truth MakeTruth(const Case& tested) {
  Truth truth;
  const MadeScene made = MakeScene(tested.scene, {.triangles = tested.triangles, .light_share = tested.light});
  truth.scene = MakeFlatScene(made.meshes);
  truth.request = RequestFor(made);
  truth.request.width = tested.width;
  truth.request.height = tested.height;
  truth.request.node_overrides = OverridesAt(made, 1);

  // Where nothing casts, v is the share of the light above the receiver's plane.
  RenderRequest bare = truth.request;
  bare.outputs = {OutputKind::kVisibility, OutputKind::kObjectId, OutputKind::kPosition};
  bare.node_overrides.resize(truth.scene.nodes.size());
  for (uint32_t node = 0; node < bare.node_overrides.size(); ++node) bare.node_overrides[node].node = node;
  for (const NodeOverride& change : truth.request.node_overrides) bare.node_overrides[change.node] = change;
  for (NodeOverride& change : bare.node_overrides) change.casts = false;
  const auto facts = TestRenderer().Render("bare", truth.scene, bare, [] { return absl::OkStatus(); });
  TestRenderer().ForgetScene("bare");
  EXPECT_OK(facts);
  if (!facts.ok()) return truth;
  truth.share = facts->images[0].image;
  const Image& ids = facts->images[1].image;
  const auto ground_id = float(truth.scene.nodes.size() + 1);
  truth.all = truth.ground = Image(tested.width, tested.height, 1);
  for (size_t i = 0; i < truth.all.size(); ++i) {
    truth.all.data()[i] = ids.data()[i] > 0 && truth.share.data()[i] > 0;
    truth.ground.data()[i] = truth.all.data()[i] > 0 && ids.data()[i] == ground_id;
  }

  if (tested.scene == "S1") {
    truth.visibility = PlateTruth(truth.request.lights[0], truth.scene, facts->images[2].image);
  } else {
    RenderRequest rays = truth.request;
    rays.method = RayOptions{kReferenceRays};
    rays.seed = kReferenceSeed;
    truth.visibility = RenderVisibility(truth.scene, rays);
  }
  return truth;
}

// What k points on the light may be off by, of which k share stand above the receiver's plane: share .7 sqrt(p (1 - p))
// (k share)^-.75 on average over the shadowed, p = v / share (trace_light.h), and half as much again because the factor
// .7 was measured to lie between .5 and 1 according to the scene. Of single pixels: a normal deviate's mean magnitude
// is .8 of its deviation, and one in a thousand lies beyond 3.3 of those, so 4.1 times the mean where p is 1/2, and
// half as much again.
ErrorPair SamplingOf(int samples, const Truth& truth, const Image& mask) {
  if (samples == 0) return {};
  const double rate = 1.5 * 0.7 * std::pow(samples, -0.75);
  double sum = 0;
  size_t shadowed = 0;
  for (size_t i = 0; i < mask.size(); ++i) {
    const double v = truth.visibility.data()[i], share = truth.share.data()[i];
    if (mask.data()[i] == 0 || v >= 1 - 1.0 / 512) continue;
    const double p = std::clamp(v / share, 0.0, 1.0);
    sum += std::pow(share, 0.25) * std::sqrt(p * (1 - p));
    ++shadowed;
  }
  return {rate * sum / double(std::max<size_t>(1, shadowed)), rate * 0.5 * 4.1};
}

const MethodThresholds* FindThresholds(const std::string& method) {
  for (const MethodThresholds& thresholds : Thresholds()) {
    if (thresholds.method == method) return &thresholds;
  }
  return nullptr;
}

// All methods of a case in one test, so that they share its truth.
class AccuracyTest : public testing::TestWithParam<Case> {};
INSTANTIATE_TEST_SUITE_P(Classes, AccuracyTest, testing::ValuesIn(Cases()), [](const auto& tested) {
  return tested.param.scene + "_light_" + std::to_string(std::lround(100 * tested.param.light));
});

// Against the thresholds of method and case.
void CheckForm(const TestMethod& method, const Case& tested, const Truth& truth, bool on_ground_alone) {
  const MethodThresholds* const thresholds = FindThresholds(method.name);
  ASSERT_NE(thresholds, nullptr) << method.name << " has no thresholds";
  ModelError model;
  for (const ModelError& row : thresholds->models) {
    if (row.scene == tested.scene && row.light == tested.light) model = row;
  }
  RenderRequest request = truth.request;
  request.method = method.Fine();
  const Image v = RenderVisibility(truth.scene, request);
  ASSERT_GT(v.size(), 0u);
  for (const bool is_ground : {true, false}) {
    if (on_ground_alone && !is_ground) continue;
    const Image& mask = is_ground ? truth.ground : truth.all;
    const auto error = Compare(truth.visibility, v, &mask);
    ASSERT_OK(error);
    ASSERT_GT(error->samples_shadowed, 200u);
    const ErrorPair sampling = SamplingOf(method.fine_samples, truth, mask);
    const ErrorPair& beyond = is_ground ? model.ground : model.all;
    const ErrorPair most = {sampling.mae_shadowed + beyond.mae_shadowed, sampling.p999 + beyond.p999};
    const std::string where = tested.scene + " light " + std::to_string(tested.light).substr(0, 4) + ", " +
                              method.name + ", " + (is_ground ? "ground" : "all");
    std::printf("%s: mae_shadowed %.5f (at most %.5f), p999 %.4f (%.4f), max %.3f\n", where.c_str(),
                *error->mae_shadowed, most.mae_shadowed, *error->p999, most.p999, *error->max);
    testing::Test::RecordProperty(method.name + (is_ground ? "_ground_mae_shadowed" : "_all_mae_shadowed"),
                                  std::to_string(*error->mae_shadowed));
    EXPECT_LE(*error->mae_shadowed, most.mae_shadowed) << where << "; beyond sampling: " << model.why;
    EXPECT_LE(*error->p999, most.p999) << where << "; beyond sampling: " << model.why;
  }
}

TEST_P(AccuracyTest, EveryMethodIsAsNearToTheTruthAsItsThresholdsSay) {
  const Truth truth = MakeTruth(GetParam());
  ASSERT_GT(truth.visibility.size(), 0u);
  for (const TestMethod& method : TestMethods()) CheckForm(method, GetParam(), truth, /*on_ground_alone=*/false);
  for (const TestMethod& form : SoftShadowMapForms()) CheckForm(form, GetParam(), truth, /*on_ground_alone=*/true);
}

TEST(ThresholdsTest, AreThereForEveryRegisteredMethodAndNameOnlyCasesThatAreRun) {
  std::set<std::string> with_thresholds;
  std::set<std::pair<std::string, double>> cases;
  for (const Case& tested : Cases()) cases.emplace(tested.scene, tested.light);
  for (const MethodThresholds& thresholds : Thresholds()) {
    with_thresholds.insert(thresholds.method);
    for (const ModelError& row : thresholds.models) {
      EXPECT_TRUE(cases.contains({row.scene, row.light})) << thresholds.method << " " << row.scene << " " << row.light;
      EXPECT_FALSE(row.why.empty()) << thresholds.method << " " << row.scene << ": a threshold has a reason";
    }
  }
  std::vector<std::string> registered = RegisteredMethods();
  for (const TestMethod& form : SoftShadowMapForms()) registered.push_back(form.name);
  EXPECT_EQ(with_thresholds, std::set<std::string>(registered.begin(), registered.end()));
}

}  // namespace
}  // namespace halfshade
