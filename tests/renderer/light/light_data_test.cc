#include "renderer/light/light_data.h"

#include <gtest/gtest.h>

#include <functional>

namespace halfshade {
namespace {

struct Source {
  std::string scene = "scenes/a";
  RenderRequest request;
  AreaLight light;
  std::string method = "multi_map";
  std::string options = "k=64 map_size=1024 ";
};

Source Original() {
  Source source;
  source.light.width_m = source.light.height_m = 1;
  return source;
}

std::string KeyAfter(const std::function<void(Source&)>& change) {
  Source source = Original();
  change(source);
  return LightDataKey(source.scene, source.request, source.light, source.method, source.options);
}

NodeOverride& Override(Source& source) { return source.request.node_overrides.emplace_back(); }

TEST(LightDataKeyTest, IsOfAllThatLightDataDependsOn) {
  const std::string original = KeyAfter([](Source&) {});
  const std::vector<std::function<void(Source&)>> changes = {
      [](Source& s) { s.scene = "scenes/b"; },
      [](Source& s) { s.request.scene_index = 1; },
      [](Source& s) { s.request.seed = 1; },
      [](Source& s) { s.method = "hard"; },
      [](Source& s) { s.options = "k=65 map_size=1024 "; },
      [](Source& s) { s.light.center_ws.x = 1e-300; },
      [](Source& s) { s.light.width_m = 2; },
      [](Source& s) { s.light.height_m = 0; },
      [](Source& s) { s.light.axis_u_ws = -s.light.axis_u_ws; },
      [](Source& s) { s.light.axis_v_ws.x = 1; },
      [](Source& s) { s.light.normal_ws = -s.light.normal_ws; },
      [](Source& s) { Override(s).casts = false; },
      [](Source& s) { Override(s).receives = false; },
      [](Source& s) { Override(s).local = glm::dmat4(1); },
      [](Source& s) { Override(s).local = glm::dmat4(2); },
  };
  std::vector<std::string> keys = {original};
  for (size_t i = 0; i < changes.size(); ++i) {
    keys.push_back(KeyAfter(changes[i]));
    EXPECT_TRUE(keys.back().starts_with(LightDataPrefix("scenes/a")) || i == 0);
    for (size_t other = 0; other + 1 < keys.size(); ++other) EXPECT_NE(keys.back(), keys[other]) << i << " " << other;
  }
}

TEST(LightDataKeyTest, IsOfNothingElse) {
  const std::string original = KeyAfter([](Source&) {});
  const std::vector<std::function<void(Source&)>> changes = {
      [](Source& s) { s.light.radiance = glm::vec3(7); },
      [](Source& s) { s.light.intensity = glm::vec3(7); },
      [](Source& s) { s.light.is_two_sided = true; },
      [](Source& s) {
        s.request.camera.eye_ws = {1, 2, 3};
      },
      [](Source& s) { s.request.width = 7; },
      [](Source& s) { s.request.ground = Ground{}; },
      [](Source& s) { s.request.cache = CacheMode::kRefresh; },
      [](Source& s) { s.request.shading.exposure_ev = 7; },
      [](Source& s) { s.request.outputs = {OutputKind::kVisibility}; },
      [](Source& s) { s.request.lights.resize(7); },
      [](Source& s) { Override(s).is_visible = false; },
      [](Source& s) { Override(s).node = 7; },
  };
  for (size_t i = 0; i < changes.size(); ++i) EXPECT_EQ(KeyAfter(changes[i]), original) << i;
}

TEST(CastersKeyTest, IsOfWhereCastersStandAndOfNothingElse) {
  const auto key_after = [](const std::function<void(Source&)>& change) {
    Source source = Original();
    change(source);
    return CastersKey(source.scene, source.request);
  };
  const std::string original = key_after([](Source&) {});
  const std::string moved = key_after([](Source& s) { Override(s).local = glm::dmat4(2); });
  const std::string silent = key_after([](Source& s) { Override(s).casts = false; });
  const std::string moved_and_silent = key_after([](Source& s) {
    Override(s).casts = false;
    s.request.node_overrides.back().local = glm::dmat4(2);
  });
  EXPECT_NE(moved, original);
  EXPECT_NE(silent, original);
  EXPECT_NE(silent, moved);
  EXPECT_EQ(moved_and_silent, silent) << "what does not cast casts nothing wherever it stands";
  EXPECT_EQ(key_after([](Source& s) { Override(s).receives = false; }), original);
  EXPECT_EQ(key_after([](Source& s) { s.light.width_m = 7; }), original);
}

}  // namespace
}  // namespace halfshade
