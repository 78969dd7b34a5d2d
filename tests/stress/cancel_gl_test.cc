// A render that is told to stop, at every stage of it: how soon the context is free, and that it draws as before.
// HALFSHADE_CANCELS says how often each method is stopped at 1280 x 720; 3 times at 320 x 180 unless set.
#include <glad/gl.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <random>

#include "tests/stress/stress_fixture.h"
#include "tests/support/scene_makers.h"

namespace halfshade {
namespace {

using Clock = std::chrono::steady_clock;

double Ms(Clock::duration time) { return std::chrono::duration<double, std::milli>(time).count(); }

// With the options that a caller gets who says nothing.
const std::vector<TestMethod> kMethods = {
    {"hard", HardOptions{}}, {"multi_map", MultiMapOptions{}}, {"ray", RayOptions{}},   {"pcss", PcssOptions{}},
    {"ssm", SsmOptions{}},   {"pdsm", PdsmOptions{}},          {"sssm", SssmOptions{}}, {"shaft", ShaftOptions{}}};

class CancelTest : public testing::TestWithParam<TestMethod> {};
INSTANTIATE_TEST_SUITE_P(Methods, CancelTest, testing::ValuesIn(kMethods), TestMethodName);

TEST_P(CancelTest, AtAnyInstantFreesTheContextAndLeavesNothingBehind) {
  const char* const asked = std::getenv("HALFSHADE_CANCELS");
  const int times = asked != nullptr ? std::atoi(asked) : 3;
  const MadeScene made = MakeScene("S5");
  const FlatScene scene = MakeFlatScene(made.meshes);
  RenderRequest request = RequestFor(made);
  request.width = asked != nullptr ? 1280 : 320;
  request.height = asked != nullptr ? 720 : 180;
  request.method = GetParam().options;
  request.outputs = {OutputKind::kVisibility, OutputKind::kFrame};
  Renderer& renderer = TestRenderer();
  const auto draw = [&](const StopCheck& stop) {
    auto result = renderer.Render("cancelled", scene, request, stop);
    TestContext().gl().Finish();  // what is still under way on the driver's threads holds the context too
    return result;
  };
  ASSERT_OK(draw([] { return absl::OkStatus(); }));  // what only a first render does
  renderer.ForgetScene("cancelled");
  const auto begin = Clock::now();
  const auto whole = draw([] { return absl::OkStatus(); });
  const auto whole_time = Clock::now() - begin;
  ASSERT_OK(whole);

  std::mt19937 random(6);
  std::vector<double> late_ms;
  for (int i = 0; int(late_ms.size()) < times && i < 10 * times; ++i) {
    renderer.ForgetScene("cancelled");
    const auto instant = Clock::now() + whole_time * (random() >> 8) / (1 << 24);
    const auto stopped =
        draw([&] { return Clock::now() < instant ? absl::OkStatus() : absl::CancelledError("enough"); });
    const double late = Ms(Clock::now() - instant);
    if (stopped.ok()) continue;  // it was done before
    EXPECT_EQ(stopped.status().code(), absl::StatusCode::kCancelled) << stopped.status();
    late_ms.push_back(late);
  }
  ASSERT_EQ(int(late_ms.size()), times) << "renders were not under way when they were told to stop";
  std::sort(late_ms.begin(), late_ms.end());
  std::printf("%s: whole in %.0f ms; %zu stopped, free after %.1f ms (median), %.1f ms (p99), %.1f ms (most)\n",
              GetParam().name.c_str(), Ms(whole_time), late_ms.size(), late_ms[late_ms.size() / 2],
              late_ms[late_ms.size() * 99 / 100], late_ms.back());
  const auto after = draw([] { return absl::OkStatus(); });
  ASSERT_OK(after);
  for (size_t i = 0; i < whole->images.size(); ++i) {
    const Image& a = whole->images[i].image;
    const Image& b = after->images[i].image;
    ASSERT_EQ(a.size(), b.size());
    EXPECT_TRUE(std::equal(a.data(), a.data() + a.size(), b.data())) << "a cancelled render left something behind";
  }
}

}  // namespace
}  // namespace halfshade
