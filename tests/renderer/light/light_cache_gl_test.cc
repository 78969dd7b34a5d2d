// Light data between requests: what is found, what is drawn again, and that nobody can tell from the picture.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/flat_scene_builder.h"
#include "tests/support/render_fixture.h"

namespace halfshade {
namespace {

constexpr uint64_t kMiB = 1ull << 20;

class LightCacheTest : public testing::TestWithParam<TestMethod> {
 protected:
  LightCacheTest() : scene_(MakeFlatScene({MakeSphere({0, 1, 0}, 0.5, 16), MakePlate({0, 0, 0}, 8, 8)})) {
    UseMemory(ContextMemory());
    request_.camera = LookFrom({3, 3, 3}, {0, 0, 0});
    request_.width = request_.height = 64;
    request_.lights = {LightAbove(3, 1)};
    request_.method = GetParam().options;
    request_.outputs = {OutputKind::kVisibility};
  }

  void UseMemory(const ContextMemory& memory) {
    renderer_ = nullptr;
    auto made = Renderer::Create(
        &TestContext(), [](const EncodedImage&) { return absl::UnimplementedError("no textures"); }, memory);
    ASSERT_OK(made);
    renderer_ = *std::move(made);
  }

  RenderResult Render(const std::string& name = "scene") {
    auto result = renderer_->Render(name, scene_, request_, [] { return absl::OkStatus(); });
    EXPECT_OK(result);
    return result.ok() ? *std::move(result) : RenderResult();
  }

  static bool DrawsMaps() { return !std::holds_alternative<RayOptions>(GetParam().options); }

  std::unique_ptr<Renderer> renderer_;
  FlatScene scene_;
  RenderRequest request_;
};
// Those whose light data are maps.
INSTANTIATE_TEST_SUITE_P(Methods, LightCacheTest,
                         testing::Values(TestMethod{"hard", HardOptions{512}},
                                         TestMethod{"multi_map", MultiMapOptions{32, 512}},
                                         TestMethod{"ssm", SsmOptions{.occluder_map_size = 256, .sub_lights = 2}}),
                         TestMethodName);

const PassReport& Pass(const RenderResult& result, const std::string& name) {
  for (const PassReport& pass : result.report.passes) {
    if (pass.name == name) return pass;
  }
  ADD_FAILURE() << "no pass " << name;
  static const PassReport none;
  return none;
}

const CacheReport& Cache(const RenderResult& result, const std::string& name) {
  for (const CacheReport& cache : result.report.caches) {
    if (cache.name == name) return cache;
  }
  ADD_FAILURE() << "no cache " << name;
  static const CacheReport none;
  return none;
}

bool IsHit(const RenderResult& result, const std::string& light = "light[0]/") {
  const CacheReport& cache = Cache(result, light + "light_data");
  EXPECT_EQ(cache.hits + cache.misses, 1u);
  return cache.hits == 1;
}

bool Equal(const RenderResult& a, const RenderResult& b) {
  const Image &x = a.images.at(0).image, &y = b.images.at(0).image;
  return x.size() == y.size() && std::equal(x.data(), x.data() + x.size(), y.data());
}

TEST_P(LightCacheTest, ACameraThatMovesPaysNoLightPass) {
  EXPECT_FALSE(IsHit(Render()));
  request_.camera = LookFrom({-3, 4, 1}, {0, 0, 0});
  request_.width = 96;
  const RenderResult moved = Render();
  EXPECT_TRUE(IsHit(moved));
  EXPECT_EQ(moved.report.light_ms, 0);
  const PassReport& pass = Pass(moved, "light[0]/light_data");
  EXPECT_TRUE(pass.is_skipped);
  EXPECT_EQ(pass.reason, "cached");
  EXPECT_EQ(pass.count, 0u);
  // The same picture as without what came before.
  UseMemory(ContextMemory());
  const RenderResult alone = Render();
  EXPECT_FALSE(IsHit(alone));
  EXPECT_EQ(Pass(alone, "light[0]/light_data").count > 0, DrawsMaps());
  EXPECT_TRUE(Equal(moved, alone));
}

TEST_P(LightCacheTest, ALightThatMovesIsDrawnAnewAndUploadsNoScene) {
  const RenderResult first = Render();
  EXPECT_EQ(Cache(first, "scene_on_context").misses, 1u);
  request_.lights[0].center_ws.x = 0.5;
  const RenderResult moved = Render();
  EXPECT_FALSE(IsHit(moved));
  EXPECT_EQ(Cache(moved, "scene_on_context").hits, 1u);
  EXPECT_FALSE(Equal(first, moved));
}

TEST_P(LightCacheTest, AnotherPoseSeedOrSceneIsAMissAndTheFirstIsStillThere) {
  const RenderResult first = Render();
  const auto change_back = request_;
  request_.seed = 1;
  EXPECT_FALSE(IsHit(Render()));
  request_ = change_back;
  request_.node_overrides.emplace_back().casts = false;
  EXPECT_FALSE(IsHit(Render()));
  request_ = change_back;
  EXPECT_FALSE(IsHit(Render("another scene")));
  const RenderResult again = Render();
  EXPECT_TRUE(IsHit(again));
  EXPECT_TRUE(Equal(first, again));
}

TEST_P(LightCacheTest, LightsThatDifferInRadianceOrHaveTheSameFrontShareMaps) {
  request_.lights.push_back(request_.lights[0]);
  request_.lights[1].radiance = glm::vec3(5);
  request_.lights[1].is_two_sided = true;
  const RenderResult result = Render();
  EXPECT_FALSE(IsHit(result, "light[0]/"));
  EXPECT_TRUE(IsHit(result, "light[1]/"));
  const Image& v = result.images[0].image;
  for (int y = 0; y < v.height(); ++y) {
    for (int x = 0; x < v.width(); ++x) ASSERT_EQ(v.at(x, y, 0), v.at(x, y, 1));
  }
}

TEST_P(LightCacheTest, RefreshLooksAtNothingAndReplaces) {
  const RenderResult first = Render();
  const uint64_t bytes = renderer_->Caches()[1].bytes;
  request_.cache = CacheMode::kRefresh;
  const RenderResult refreshed = Render();
  EXPECT_FALSE(IsHit(refreshed));
  EXPECT_EQ(Pass(refreshed, "light[0]/light_data").count > 0, DrawsMaps());
  EXPECT_TRUE(Equal(first, refreshed));
  EXPECT_EQ(renderer_->Caches()[1].bytes, bytes);
  request_.cache = CacheMode::kUse;
  EXPECT_TRUE(IsHit(Render()));
}

TEST_P(LightCacheTest, WhatDoesNotFitIsDrawnAgainToTheSameBytesAndSaysSo) {
  if (!DrawsMaps() || std::holds_alternative<PcssOptions>(GetParam().options) ||
      std::holds_alternative<SssmOptions>(GetParam().options))
    return;  // they keep their few maps while they last
  const RenderResult all = Render();
  const uint64_t bytes = Cache(all, "light[0]/light_data").bytes;
  const uint64_t maps = Pass(all, "light[0]/light_data").count;
  UseMemory({.light_data_bytes = 64 << 10});  // the occluders fit, no map of 512^2 does
  for (const bool is_first : {true, false}) {
    const RenderResult part = Render();
    EXPECT_EQ(IsHit(part), !is_first) << "the occluders are kept";
    EXPECT_EQ(Pass(part, "light[0]/light_data").count, 0u);
    EXPECT_THAT(Pass(part, "light[0]/light_data").reason,
                testing::HasSubstr(std::to_string(maps) + " maps do not fit the light cache"));
    EXPECT_EQ(Pass(part, "light[0]/resolve").count, maps);
    EXPECT_LE(Cache(part, "light[0]/light_data").bytes, 64u << 10);
    EXPECT_TRUE(Equal(all, part));
  }
  EXPECT_GT(bytes, 64u << 10);
}

// The hierarchy is the scene's: lights share it, whatever moves but its casters.
TEST_P(LightCacheTest, OneRaySceneServesEveryLightUntilACasterChanges) {
  if (DrawsMaps()) return;
  const auto ray_scenes_built = [&] { return renderer_->Caches()[2].misses; };
  request_.lights.push_back(LightAbove(2, 0.5));
  const RenderResult first = Render();
  EXPECT_EQ(ray_scenes_built(), 1u);
  EXPECT_GE(renderer_->Caches()[2].bytes, scene_.indices.size() * sizeof(uint32_t));
  request_.lights[0].center_ws.x = 0.5;
  request_.node_overrides.emplace_back().receives = false;
  Render();
  EXPECT_EQ(ray_scenes_built(), 1u);
  request_.node_overrides[0].casts = false;
  Render();
  EXPECT_EQ(ray_scenes_built(), 2u);
  renderer_->ForgetScene("scene");
  EXPECT_EQ(renderer_->Caches()[2].bytes, 0u);
  UseMemory({.ray_scene_bytes = 0});
  request_.node_overrides.clear();
  request_.lights[0].center_ws.x = 0;
  EXPECT_TRUE(Equal(first, Render()));
  EXPECT_EQ(Pass(Render(), "light[0]/light_data").reason, "cached");
}

TEST_P(LightCacheTest, TheBoundHoldsAndForgettingFreesAll) {
  const RenderResult first = Render();
  const uint64_t one = renderer_->Caches()[1].bytes;
  // Room for two lights' data, but not for three.
  UseMemory({.light_data_bytes = 2 * one + one / 2});
  for (int i = 0; i < 5; ++i) {
    request_.lights[0].center_ws.x = 0.125 * i;
    Render();
    EXPECT_LE(renderer_->Caches()[1].bytes, 2 * one + one / 2);
  }
  EXPECT_TRUE(IsHit(Render())) << "the newest";
  request_.lights[0].center_ws.x = 0;
  EXPECT_FALSE(IsHit(Render())) << "the oldest is gone";
  renderer_->ForgetScene("scen");
  EXPECT_GT(renderer_->Caches()[1].bytes, 0u) << "only the beginning of its name";
  renderer_->ForgetScene("scene");
  EXPECT_EQ(renderer_->Caches()[0].bytes, 0u);
  EXPECT_EQ(renderer_->Caches()[1].bytes, 0u);
}

TEST_P(LightCacheTest, ScenesInGlMemoryAreBoundedToo) {
  Render();
  const uint64_t one = renderer_->Caches()[0].bytes;
  UseMemory({.scene_bytes = 2 * one});
  for (const char* name : {"1", "2", "3", "4"}) {
    Render(name);
    EXPECT_LE(renderer_->Caches()[0].bytes, 2 * one);
  }
  EXPECT_EQ(Cache(Render("4"), "scene_on_context").hits, 1u);
  EXPECT_EQ(Cache(Render("1"), "scene_on_context").hits, 0u);
  UseMemory({.scene_bytes = one - 1});
  const RenderResult large = Render();
  EXPECT_EQ(renderer_->Caches()[0].bytes, 0u) << "larger than the bound: drawn, and not kept";
  EXPECT_GT(large.images.at(0).image.size(), 0u);
}

TEST(LightCacheShareTest, SeveralLightsShareTheBoundSoThatAllAreFoundAgain) {
  const FlatScene scene = MakeFlatScene({MakeSphere({0, 1, 0}, 0.5, 16), MakePlate({0, 0, 0}, 8, 8)});
  RenderRequest request;
  request.camera = LookFrom({3, 3, 3}, {0, 0, 0});
  request.width = request.height = 64;
  request.lights = {LightAbove(3, 1), LightAbove(3, 1, {1, 0}), LightAbove(3, 1, {0, 1})};
  request.method = MultiMapOptions{128, 512};  // 128 MiB a light
  request.outputs = {OutputKind::kVisibility};
  const auto render = [&](uint64_t bytes, bool twice) {
    auto renderer =
        Renderer::Create(&TestContext(), [](const EncodedImage&) { return absl::UnimplementedError("no textures"); },
                         {.light_data_bytes = bytes});
    EXPECT_OK(renderer);
    const StopCheck go_on = [] { return absl::OkStatus(); };
    if (twice) {
      EXPECT_OK((*renderer)->Render("scene", scene, request, go_on));
    }
    auto result = (*renderer)->Render("scene", scene, request, go_on);
    EXPECT_OK(result);
    EXPECT_LE((*renderer)->Caches()[1].bytes, bytes);
    return *std::move(result);
  };
  const RenderResult whole = render(512 * kMiB, false);
  const RenderResult part = render(240 * kMiB, true);
  for (const std::string light : {"light[0]/", "light[1]/", "light[2]/"}) {
    EXPECT_TRUE(IsHit(part, light)) << light;
    EXPECT_EQ(Pass(part, light + "resolve").count, 64u) << "one batch of 64 maps fits its 80 MiB, the other does not";
  }
  EXPECT_TRUE(Equal(whole, part));
}

}  // namespace
}  // namespace halfshade
