// Light data that outlives its context: stored by one renderer, found by the next, refused where it is not whole.
#include <gtest/gtest.h>

#include <map>

#include "tests/support/render_fixture.h"

namespace halfshade {
namespace {

class MapStore : public LightStore {
 public:
  std::string Get(const std::string& scene_name, const std::string& key) override {
    ++asked;
    return values[scene_name + "\n" + key];
  }
  void Put(const std::string& scene_name, const std::string& key, std::string bytes) override {
    values[scene_name + "\n" + key] = std::move(bytes);
    ++put;
  }
  std::map<std::string, std::string> values;
  int asked = 0, put = 0;
};

class LightStoreTest : public testing::Test {
 protected:
  LightStoreTest() : scene_(MakeFlatScene({MakePlate({0, 0, 0}, 4, 4), MakePlate({0, 1, 0}, 1, 1)})) {
    request_.camera = LookFrom({2, 2, 2}, {0, 0, 0});
    request_.width = request_.height = 48;
    request_.lights = {LightAbove(3, 0.5)};
    request_.outputs = {OutputKind::kVisibility};
    request_.method = PdsmOptions{.k = 16, .map_size = 64, .pdsm_size = 64, .eps = 0.04f};
  }
  // A renderer that has nothing yet: a server's first render.
  RenderResult RenderAnew() {
    auto renderer =
        Renderer::Create(&TestContext(), [](const EncodedImage&) { return absl::UnimplementedError("no textures"); },
                         {.light_store = &store_});
    EXPECT_OK(renderer);
    auto result = (*renderer)->Render("scene", scene_, request_, [] { return absl::OkStatus(); });
    EXPECT_OK(result);
    return *std::move(result);
  }
  static const PassReport& LightPass(const RenderResult& result) {
    for (const PassReport& pass : result.report.passes) {
      if (pass.name == "light[0]/light_data") return pass;
    }
    ADD_FAILURE() << "no pass of light data";
    return result.report.passes.front();
  }
  static bool AreEqual(const RenderResult& a, const RenderResult& b) {
    const Image &x = a.images[0].image, &y = b.images[0].image;
    return x.size() == y.size() && std::equal(x.data(), x.data() + x.size(), y.data());
  }

  FlatScene scene_;
  RenderRequest request_;
  MapStore store_;
};

TEST_F(LightStoreTest, TheNextRendererDrawsNoMapsAndTheSamePicture) {
  for (const bool is_indexed : {false, true}) {
    auto& pdsm = std::get<PdsmOptions>(request_.method);
    if (is_indexed) {
      pdsm.layout = PdsmLayout::kIndexed;
      pdsm.construction = PdsmConstruction::kScatter;
    }
    const RenderResult built = RenderAnew();
    EXPECT_EQ(LightPass(built).count, 16u);
    const RenderResult loaded = RenderAnew();
    EXPECT_EQ(LightPass(loaded).count, 0u);
    EXPECT_EQ(LightPass(loaded).reason, "from the store");
    EXPECT_TRUE(AreEqual(built, loaded));
    EXPECT_EQ(store_.put, is_indexed ? 2 : 1);
  }
}

TEST_F(LightStoreTest, WhatIsTornOrForeignIsBuiltAgainAndReplaced) {
  const RenderResult built = RenderAnew();
  ASSERT_EQ(store_.values.size(), 1u);
  const std::string whole = store_.values.begin()->second;
  // Another light's, whole in itself.
  request_.lights = {LightAbove(2, 0.5)};
  RenderAnew();
  request_.lights = {LightAbove(3, 0.5)};
  ASSERT_EQ(store_.values.size(), 2u);
  std::string foreign;
  for (const auto& [key, bytes] : store_.values) {
    if (bytes != whole) foreign = bytes;
  }
  std::string turned = whole;
  turned[whole.size() / 2] ^= 4;
  for (const std::string& bad : {whole.substr(0, whole.size() / 2), turned, foreign, std::string("halfshade")}) {
    ASSERT_NE(bad, whole);
    for (auto& [key, bytes] : store_.values) bytes = bad;
    const RenderResult again = RenderAnew();
    EXPECT_EQ(LightPass(again).count, 16u);
    EXPECT_EQ(LightPass(again).reason, "what the store has is not whole: built again");
    EXPECT_TRUE(AreEqual(built, again));
    bool is_replaced = false;
    for (const auto& [key, bytes] : store_.values) is_replaced |= bytes == whole;
    EXPECT_TRUE(is_replaced);
  }
}

TEST_F(LightStoreTest, RefreshDoesNotAskAndReplaces) {
  RenderAnew();
  const int asked = store_.asked;
  request_.cache = CacheMode::kRefresh;
  EXPECT_EQ(LightPass(RenderAnew()).count, 16u);
  EXPECT_EQ(store_.asked, asked);
  EXPECT_EQ(store_.put, 2);
}

TEST_F(LightStoreTest, MethodsThatAreAsSoonBuiltAgainAreNotStored) {
  request_.method = MultiMapOptions{4, 64};
  RenderAnew();
  EXPECT_EQ(store_.put, 0);
}

}  // namespace
}  // namespace halfshade
