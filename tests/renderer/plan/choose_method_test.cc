#include "renderer/plan/choose_method.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "tests/support/flat_scene_builder.h"
#include "tests/support/scene_makers.h"
#include "tests/support/status_matchers.h"

namespace halfshade {
namespace {

using testing::HasSubstr;

MethodFacts Facts(uint64_t triangles, double masked_share = 0) {
  return {
      .casting_triangles = triangles, .masked_share = masked_share, .clutter = masked_share, .receivers = 640 * 360};
}

TEST(ChooseMethodTest, WithoutABudgetShaftTakesTheRowsThatThePictureWants) {
  for (const uint64_t triangles : {0ull, 2ull, 6000ull, 100'000ull}) {
    const auto choice = ChooseMethod(Facts(triangles), {});
    ASSERT_OK(choice);
    const auto& shaft = std::get<ShaftOptions>(choice->options);
    EXPECT_EQ(shaft.rows, 0);
    EXPECT_LT(shaft.max_error, kDefaultMaxError);
    EXPECT_LE(choice->error, kDefaultMaxError);
    EXPECT_THAT(choice->reason, HasSubstr("auto, shaft: predicted error 0.0019"));
    EXPECT_THAT(choice->reason, HasSubstr("; ray: predicted error")) << "what it was weighed against";
  }
}

TEST(ChooseMethodTest, ErrorsMeetTheBudgetAndCostFallsAsItGrows) {
  double cost = std::numeric_limits<double>::infinity();
  for (const double max_error : {0.0002, 0.0006, 0.002, 0.005, 0.01, 0.03, 0.1}) {
    const auto choice = ChooseMethod(Facts(70'000), {.max_error = max_error});
    ASSERT_OK(choice);
    EXPECT_LE(choice->error, max_error);
    EXPECT_LE(choice->frame_ms, cost) << max_error;
    cost = choice->frame_ms;
  }
}

TEST(ChooseMethodTest, RaysTakeWhatRowsDoNotReach) {
  const auto is_ray = [](const MethodFacts& facts, double max_error) {
    const auto choice = ChooseMethod(facts, {.max_error = max_error});
    EXPECT_OK(choice);
    return choice.ok() && std::holds_alternative<RayOptions>(choice->options);
  };
  EXPECT_FALSE(is_ray(Facts(27'000), 0.01));
  EXPECT_FALSE(is_ray(Facts(27'000, 0.9), 0.002));
  EXPECT_FALSE(is_ray(Facts(27'000), 0.002));
  EXPECT_TRUE(is_ray(Facts(6000), 0.0003)) << "64 rows are off by .0005";
  EXPECT_FALSE(is_ray(Facts(6000), 0.0006));
}

// What the first picture of a dense mesh pays for its shape is more than rays take; what the next ones pay is less.
TEST(ChooseMethodTest, WhatStaysOfASceneIsWeighedAsOfThirtyFrames) {
  MethodFacts facts = Facts(230'000);
  facts.kept_share = 1;
  facts.kept_triangles = facts.casting_triangles;
  const std::vector<MethodChoice> candidates = MethodCandidates(facts, 0.01);
  const auto named = [&](const std::string& name) {
    return *std::find_if(candidates.begin(), candidates.end(),
                         [&](const MethodChoice& choice) { return choice.reason == name; });
  };
  EXPECT_LT(named("shaft").frame_ms, named("ray").frame_ms);
  EXPECT_GT(named("shaft").cpu_ms, named("ray").cpu_ms);
  EXPECT_TRUE(std::is_sorted(candidates.begin(), candidates.end(),
                             [](const MethodChoice& a, const MethodChoice& b) { return a.frame_ms < b.frame_ms; }));
}

TEST(ChooseMethodTest, WhatCannotBeMetNamesTheBest) {
  EXPECT_THAT(
      ChooseMethod(Facts(6000), {.max_error = 1e-5}),
      StatusIs(absl::StatusCode::kFailedPrecondition, HasSubstr("budget.max_error: 1e-05; the least possible is")));
  EXPECT_THAT(
      ChooseMethod(Facts(6000), {.max_latency_ms = 1}),
      StatusIs(absl::StatusCode::kFailedPrecondition, HasSubstr("budget.max_latency: 1.0 ms; the least possible is")));
  EXPECT_THAT(ChooseMethod(Facts(70'000), {.max_error = 0.0005, .max_latency_ms = 50}),
              StatusIs(absl::StatusCode::kFailedPrecondition, HasSubstr("budget.max_latency: 50 ms")));
}

TEST(ChooseMethodTest, ALatencyBuysTheLeastErrorInTime) {
  double error = 1;
  for (const double max_latency_ms : {100.0, 300.0, 1000.0, 10'000.0, 100'000.0}) {
    const auto choice = ChooseMethod(Facts(6000), {.max_latency_ms = max_latency_ms});
    ASSERT_OK(choice);
    EXPECT_LE(choice->error, error) << max_latency_ms;
    error = choice->error;
  }
  EXPECT_LT(error, 0.001);
}

TEST(ChooseMethodTest, AMachineThreeTimesSlowerGetsWhatAThirdOfTheTimeBuysHere) {
  for (const double max_latency_ms : {100.0, 300.0, 1000.0}) {
    const auto slow = ChooseMethod(Facts(6000), {.max_latency_ms = 3 * max_latency_ms, .machine = {.slowness = 3}});
    const auto here = ChooseMethod(Facts(6000), {.max_latency_ms = max_latency_ms});
    ASSERT_OK(slow);
    ASSERT_OK(here);
    EXPECT_EQ(slow->error, here->error);
    EXPECT_EQ(slow->cpu_ms, here->cpu_ms);
  }
  EXPECT_OK(ChooseMethod(Facts(6000), {.max_latency_ms = 100}));
  EXPECT_FALSE(ChooseMethod(Facts(6000), {.max_latency_ms = 100, .machine = {.slowness = 30}}).ok());
}

TEST(ChooseMethodTest, WithAnErrorAloneNoMachineChoosesOtherwise) {
  for (const double max_error : {0.03, 0.002, 0.0003}) {
    const auto quick = ChooseMethod(Facts(70'000), {.max_error = max_error, .machine = {.slowness = 0.1}});
    const auto slow = ChooseMethod(Facts(70'000), {.max_error = max_error, .machine = {.slowness = 50}});
    ASSERT_OK(quick);
    ASSERT_OK(slow);
    EXPECT_EQ(quick->reason, slow->reason);
    EXPECT_EQ(quick->options.index(), slow->options.index());
  }
}

TEST(ChooseMethodTest, ALatencyIsKeptAndBoughtOutToTheNextChoice) {
  const MethodFacts facts = Facts(6000);
  for (const double max_latency_ms : {80.0, 120.0, 500.0, 4000.0}) {
    const auto choice = ChooseMethod(facts, {.max_latency_ms = max_latency_ms});
    ASSERT_OK(choice);
    EXPECT_LE(PredictWallMs(facts, choice->cpu_ms, 1), max_latency_ms);
    // With its error as a bound, and the time that it takes, it is still the choice; with less of either nothing is.
    const double wall_ms = PredictWallMs(facts, choice->cpu_ms, 1);
    EXPECT_OK(ChooseMethod(facts, {.max_error = choice->error, .max_latency_ms = wall_ms}));
    const auto better = ChooseMethod(facts, {.max_error = 0.99 * choice->error, .max_latency_ms = max_latency_ms});
    EXPECT_TRUE(!better.ok() || better->error < choice->error) << better->reason;
    EXPECT_FALSE(better.ok()) << better->reason;
  }
}

TEST(ChooseMethodTest, PenumbraWidthsAreSssms) {
  MethodFacts facts = Facts(6000);
  facts.wants_penumbra_width = true;
  const auto choice = ChooseMethod(facts, {});
  ASSERT_OK(choice);
  EXPECT_TRUE(std::holds_alternative<SssmOptions>(choice->options));
  EXPECT_THAT(choice->reason, HasSubstr("PENUMBRA_WIDTH is known to sssm and pcss"));
  EXPECT_THAT(ChooseMethod(facts, {.max_error = 0.01}),
              StatusIs(absl::StatusCode::kFailedPrecondition, HasSubstr("the least possible is 0.015, by sssm")));
  MethodOptions options = choice->options;
  EXPECT_FALSE(MakeMoreExact(facts, 0.02, &options)) << "nothing else knows them";
}

TEST(ChooseMethodTest, AfterABreachShaftHalvesItsErrorThenRaysTakeOverUntilThereAreNoMore) {
  const MethodFacts facts = Facts(6000);
  MethodOptions options = ShaftOptions{.max_error = 0.0008f};
  EXPECT_TRUE(MakeMoreExact(facts, 0.001, &options));
  EXPECT_FLOAT_EQ(std::get<ShaftOptions>(options).max_error, 0.0005f);
  EXPECT_TRUE(MakeMoreExact(facts, 0.001, &options));
  int rays = std::get<RayOptions>(options).rays;
  EXPECT_GE(rays, 4096);
  while (MakeMoreExact(facts, 0.001, &options)) {
    EXPECT_EQ(std::get<RayOptions>(options).rays, 4 * rays);
    rays *= 4;
  }
  EXPECT_LE(rays, 65536);
  EXPECT_GT(rays, 16384);
}

TEST(ChooseMethodTest, RaysThatTakeAnothersPlaceAreAsManyAsMasksWant) {
  for (const double masked_share : {0.0, 1.0}) {
    const MethodFacts facts = Facts(6000, masked_share);
    RenderRequest smaller;
    smaller.method = ShaftOptions{.max_error = 0.004f};
    ASSERT_TRUE(MakeSmaller(facts, 0.004, &smaller));
    EXPECT_LE(std::get<RayOptions>(smaller.method).max_error, 0.004f) << masked_share;
    MethodOptions exact = ShaftOptions{.max_error = 0.001f};
    ASSERT_TRUE(MakeMoreExact(facts, 0.004, &exact));
    EXPECT_LE(RayError(facts, std::get<RayOptions>(exact).rays), 0.002) << masked_share;
  }
}

TEST(ChooseMethodTest, TheDefaultCertificateIsATwentiethAtMost) {
  EXPECT_FALSE(CertifiesByDefault(Facts(6000), 100));
  EXPECT_TRUE(CertifiesByDefault(Facts(6000), 100'000));
}

RenderRequest RequestForError(double max_error, MethodOptions method) {
  RenderRequest request;
  request.is_auto = true;
  request.outputs = {OutputKind::kVisibility};
  request.budget.max_error = max_error;
  request.method = method;
  return request;
}

TEST(ChooseMethodTest, WithoutRoomForShaftTheCheapestRaysTakeItsPlace) {
  RenderRequest fine = RequestForError(0.002, ShaftOptions{});
  ASSERT_TRUE(MakeSmaller(Facts(6000), 0.002, &fine));
  EXPECT_TRUE(std::get<RayOptions>(fine.method).is_adaptive);
  EXPECT_LE(std::get<RayOptions>(fine.method).max_error, 0.002f);
  EXPECT_FALSE(MakeSmaller(Facts(6000), 0.002, &fine));

  RenderRequest coarse = RequestForError(0.02, PdsmOptions{});
  ASSERT_TRUE(MakeSmaller(Facts(229'000), 0.02, &coarse));
  EXPECT_TRUE(std::get<RayOptions>(coarse.method).is_filtered);
  EXPECT_TRUE(coarse.certify) << "filtered rays do not surely tell their error";
  EXPECT_GT(*coarse.predicted_cpu_ms, 0);

  MethodOptions broken = coarse.method;
  ASSERT_TRUE(MakeMoreExact(Facts(229'000), 0.02, &broken));
  EXPECT_TRUE(std::get<RayOptions>(broken).is_adaptive);
  EXPECT_FALSE(std::get<RayOptions>(broken).is_filtered);
}

TEST(ChooseMethodTest, UnderALatencyAloneRaysTakeShaftsPlaceForItsErrorAndNoListIsTooLong) {
  RenderRequest request = RequestForError(0, ShaftOptions{.max_error = 0.012f});
  request.budget = {.max_latency_ms = 100};
  ASSERT_TRUE(MakeSmaller(Facts(6000), kDefaultMaxError, &request));
  EXPECT_GT(std::get<RayOptions>(request.method).max_error, 0.005f);
  const auto choice = ChooseMethod(Facts(6000), {.max_latency_ms = 100});
  ASSERT_OK(choice);
  EXPECT_EQ(std::get<ShaftOptions>(choice->options).most_polygons, 0u);
}

TEST(ChooseMethodTest, FilteredRaysAreForCoarseErrorsOfSmoothSurfaces) {
  const auto has_filtered = [](const MethodFacts& facts, double max_error) {
    const std::vector<MethodChoice> candidates = MethodCandidates(facts, max_error);
    return std::any_of(candidates.begin(), candidates.end(), [&](const MethodChoice& choice) {
      const auto* ray = std::get_if<RayOptions>(&choice.options);
      EXPECT_TRUE(ray == nullptr || !ray->is_filtered || choice.error <= max_error);
      return ray != nullptr && ray->is_filtered;
    });
  };
  EXPECT_TRUE(has_filtered(Facts(70'000), 0.03));
  EXPECT_FALSE(has_filtered(Facts(70'000), 0.01)) << "more than four rays are no cheaper than shaft";
  EXPECT_FALSE(has_filtered(Facts(70'000, 0.9), 0.03)) << "leaves";
}

bool IsFewMaps(const MethodChoice& choice) {
  return std::holds_alternative<PcssOptions>(choice.options) || std::holds_alternative<SsmOptions>(choice.options) ||
         std::holds_alternative<SssmOptions>(choice.options);
}

TEST(ChooseMethodTest, FewMapsAreForCoarseErrorsWhereAGpuDraws) {
  MethodFacts facts = Facts(70'000);
  facts.has_gpu = true;
  for (const double max_error : {0.1, 0.03, 0.02}) {
    const auto choice = ChooseMethod(facts, {.max_error = max_error});
    ASSERT_OK(choice);
    EXPECT_TRUE(IsFewMaps(*choice)) << max_error << ": " << choice->reason;
    EXPECT_LT(choice->error, max_error);
    const auto in_software = ChooseMethod(Facts(70'000), {.max_error = max_error});
    ASSERT_OK(in_software);
    EXPECT_FALSE(IsFewMaps(*in_software)) << max_error << ": " << in_software->reason;
    EXPECT_LT(choice->frame_ms, in_software->frame_ms);
    MethodOptions broken = choice->options;
    ASSERT_TRUE(MakeMoreExact(facts, max_error, &broken));
    EXPECT_FLOAT_EQ(std::get<ShaftOptions>(broken).max_error, float(max_error / 2));
  }
  for (const double max_error : {0.01, 0.002}) {
    EXPECT_FALSE(IsFewMaps(*ChooseMethod(facts, {.max_error = max_error}))) << max_error;
  }
  MethodFacts leaves = Facts(70'000, 1);
  leaves.has_gpu = true;
  EXPECT_FALSE(IsFewMaps(*ChooseMethod(leaves, {.max_error = 0.02}))) << "finer than their texels";
  facts.has_side_windows = true;
  EXPECT_FALSE(IsFewMaps(*ChooseMethod(facts, {.max_error = 0.03})));
}

TEST(ChooseMethodTest, WhatDoesNotTellItsErrorIsForPicturesThatRaysCanMeasure) {
  for (const bool has_gpu : {false, true}) {
    MethodFacts facts = Facts(229'000);
    facts.has_gpu = has_gpu;
    facts.frames = 1'000'000;
    EXPECT_GT(MethodCandidates(facts, 0.03).size(), 3u);
    facts.can_certify = false;
    const std::vector<MethodChoice> candidates = MethodCandidates(facts, 0.03);
    EXPECT_EQ(candidates.size(), 2u) << "shaft and rays";
  }
}

TEST(ChooseMethodTest, ShaftIsBoundByWhatRaysWouldTake) {
  const auto bound = [](MethodFacts facts, double max_error) {
    facts.kept_share = 1;
    const auto choice = ChooseMethod(facts, {.max_error = max_error});
    EXPECT_OK(choice);
    return std::get<ShaftOptions>(choice->options).most_polygons;
  };
  const uint64_t coarse = bound(Facts(70'000), 0.03), fine = bound(Facts(70'000), 0.005);
  EXPECT_GT(coarse, 100'000u);
  EXPECT_GT(fine, coarse) << "rays for it are dearer";
  EXPECT_EQ(bound(Facts(27'000, 0.9), 0.005), 0u) << "where masks are dear their polygons are not what counts";
}

TEST(ChooseMethodTest, RaysGoOnUntilTheyTellTheErrorAndOfBlendAreAsManyEverywhereAsItWants) {
  const auto rays_for = [](const MethodFacts& facts, double max_error) {
    for (const MethodChoice& choice : MethodCandidates(facts, max_error)) {
      if (choice.reason == "ray") return choice;
    }
    ADD_FAILURE();
    return MethodChoice{};
  };
  MethodFacts facts = Facts(6000);
  const MethodChoice adaptive = rays_for(facts, 0.01);
  EXPECT_TRUE(std::get<RayOptions>(adaptive.options).is_adaptive);
  EXPECT_LT(std::get<RayOptions>(adaptive.options).max_error, 0.01f);
  EXPECT_LE(adaptive.error, 0.01);
  EXPECT_LT(adaptive.cpu_ms, rays_for(facts, 0.001).cpu_ms);
  facts.blend_share = 0.5;
  const auto fixed = std::get<RayOptions>(rays_for(facts, 0.01).options);
  EXPECT_FALSE(fixed.is_adaptive);
  EXPECT_EQ(fixed.max_error, 0);
  EXPECT_LE(RayError(facts, fixed.rays), 0.01);
}

// A smooth mesh of 230 k triangles: its maps take seconds, and then any camera asks them for less than its shafts.
TEST(ChooseMethodTest, PdsmIsPaidBackByManyFramesOfADenseMesh) {
  const auto choose = [](uint64_t triangles, uint64_t frames, double max_error, double clutter) {
    MethodFacts facts = Facts(triangles);
    facts.clutter = clutter;
    facts.frames = frames;
    const auto choice = ChooseMethod(facts, {.max_error = max_error});
    EXPECT_OK(choice);
    return choice.ok() ? *choice : MethodChoice{};
  };
  const auto is_pdsm = [&](auto... facts) { return std::holds_alternative<PdsmOptions>(choose(facts...).options); };
  EXPECT_FALSE(is_pdsm(230'000, 1, 0.02, 0.0));
  EXPECT_FALSE(is_pdsm(230'000, 100, 0.02, 0.0)) << "a tenth of a second each";
  EXPECT_TRUE(is_pdsm(230'000, 10'000, 0.02, 0.0));
  EXPECT_FALSE(is_pdsm(230'000, 10'000, 0.005, 0.0)) << "no number of its maps is as exact";
  EXPECT_FALSE(is_pdsm(230'000, 10'000, 0.02, 1.0)) << "leaves";
  EXPECT_FALSE(is_pdsm(6000, 10'000, 0.02, 0.0)) << "what is quick is not made quicker";
  EXPECT_LE(choose(230'000, 10'000, 0.02, 0.0).error, 0.02);
  EXPECT_EQ(std::get<PdsmOptions>(choose(230'000, 10'000, 0.1, 0.0).options).k, 256) << "fewer are seen as steps";
  EXPECT_THAT(choose(230'000, 10'000, 0.02, 0.0).reason, HasSubstr("a frame of 10000"));
}

TEST(ChooseMethodTest, AfterPdsmBrokeTheBudgetShaftDoesNot) {
  MethodOptions options = PdsmOptions{};
  ASSERT_TRUE(MakeMoreExact(Facts(229'000), 0.01, &options));
  EXPECT_EQ(std::get<ShaftOptions>(options).max_error, 0.005f);
}

TEST(ChooseMethodTest, RaysThatBrokeTheBudgetGoOnThenAreAsManyEverywhere) {
  const MethodFacts facts = Facts(6000);
  MethodOptions options = RayOptions{.rays = kMostRays, .is_adaptive = true, .max_error = 0.008f};
  ASSERT_TRUE(MakeMoreExact(facts, 0.01, &options));
  EXPECT_EQ(std::get<RayOptions>(options).max_error, 0.005f);
  ASSERT_TRUE(MakeMoreExact(facts, 0.01, &options));
  const auto fixed = std::get<RayOptions>(options);
  EXPECT_FALSE(fixed.is_adaptive);
  EXPECT_LE(RayError(facts, fixed.rays), 0.005);
  ASSERT_TRUE(MakeMoreExact(facts, 0.01, &options));
  EXPECT_EQ(std::get<RayOptions>(options).rays, 4 * fixed.rays);
}

TEST(SettleMethodTest, AdaptiveRaysByNameStopAtTheWantedMean) {
  const MadeScene made = MakeScene("S5", {.light_share = 0.2});
  const FlatScene scene = MakeFlatScene(made.meshes);
  const auto pose = BuildPose(scene, 0, {});
  ASSERT_OK(pose);
  for (const bool is_adaptive : {false, true}) {
    for (const std::optional<double> max_error : {std::optional<double>{}, std::optional<double>{0.01}}) {
      RenderRequest request = RequestFor(made);
      request.method = RayOptions{.rays = 4096, .is_adaptive = is_adaptive};
      request.budget.max_error = max_error;
      ASSERT_OK(SettleMethod(scene, *pose, 640 * 360, &request));
      const auto& ray = std::get<RayOptions>(request.method);
      EXPECT_EQ(ray.rays, 4096);
      EXPECT_EQ(ray.max_error > 0, is_adaptive && max_error);
      EXPECT_LE(ray.max_error, 0.01f);
    }
  }
}

TEST(SettleMethodTest, ShaftByNameChoosesItsRowsForTheWantedError) {
  const MadeScene made = MakeScene("S5", {.light_share = 0.2});
  const FlatScene scene = MakeFlatScene(made.meshes);
  const auto pose = BuildPose(scene, 0, {});
  ASSERT_OK(pose);
  double cpu_ms = 0;
  for (const double max_error : {0.03, 0.002, 0.0003}) {
    RenderRequest request = RequestFor(made);
    request.method = ShaftOptions{};
    request.budget.max_error = max_error;
    ASSERT_OK(SettleMethod(scene, *pose, 640 * 360, &request));
    const auto& shaft = std::get<ShaftOptions>(request.method);
    EXPECT_EQ(shaft.rows, 0);
    // What AUTO would ask it for.
    for (const MethodChoice& choice : MethodCandidates(FactsForMethod(scene, *pose, request, 640 * 360), max_error)) {
      const auto* candidate = std::get_if<ShaftOptions>(&choice.options);
      EXPECT_TRUE(candidate == nullptr || candidate->max_error == shaft.max_error);
    }
    EXPECT_GT(*request.predicted_cpu_ms, cpu_ms);  // by as many rows
    cpu_ms = *request.predicted_cpu_ms;
    EXPECT_FALSE(request.certify) << "it tells its error";
  }
  RenderRequest request = RequestFor(made);
  request.method = ShaftOptions{};
  ASSERT_OK(SettleMethod(scene, *pose, 640 * 360, &request));
  EXPECT_EQ(std::get<ShaftOptions>(request.method).max_error, ShaftOptions{}.max_error);
}

// Its work is a pass over the instances and a fixed number of candidates: no vertex is looked at, and none is here.
TEST(SettleMethodTest, DecidesByInstancesWithoutATriangle) {
  const MadeScene made = MakeScene("S6", {.light_share = 0.2});
  FlatScene scene = MakeFlatScene(made.meshes);
  const auto pose = BuildPose(scene, 0, {});
  ASSERT_OK(pose);
  RenderRequest request = RequestFor(made);
  request.is_auto = true;
  request.budget.max_error = 0.005;
  RenderRequest emptied = request;
  ASSERT_OK(SettleMethod(scene, *pose, 640 * 360, &request));
  scene.positions = {};
  scene.indices = {};
  ASSERT_OK(SettleMethod(scene, *pose, 640 * 360, &emptied));
  EXPECT_EQ(emptied.method_reason, request.method_reason);
  EXPECT_EQ(emptied.predicted_cpu_ms, request.predicted_cpu_ms);
  EXPECT_EQ(MethodCandidates(FactsForMethod(scene, *pose, request, 640 * 360), 0.005).size(), 2u);
}

}  // namespace
}  // namespace halfshade
