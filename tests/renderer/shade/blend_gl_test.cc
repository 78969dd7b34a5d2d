// alphaMode BLEND: alpha's share of the light, in every method; and what the camera sees of it.
#include <gtest/gtest.h>
#include <sched.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <string>

#include "renderer/image/compare.h"
#include "renderer/plan/choose_method.h"
#include "tests/renderer/shade/shade_fixture.h"
#include "tests/support/closed_forms.h"

namespace halfshade {
namespace {

// A pane of edge 4 at each height over a plain plate of edge 8; a light of edge .5 at height 2.
FlatScene Panes(std::initializer_list<double> heights, float alpha) {
  std::vector<GlbMesh> meshes = {MakePlate({0, 0, 0}, 8, 8)};
  for (const double height : heights) meshes.push_back(MakePlate({0, height, 0}, 4, 4));
  FlatScene scene = MakeFlatScene(meshes);
  for (size_t i = 1; i < meshes.size(); ++i) {
    scene.materials[i].alpha_mode = AlphaMode::kBlend;
    scene.materials[i].base_color.a = alpha;
  }
  return scene;
}

// The ground alone, in the middle of the panes' shadow: 2 m, seen from below the panes.
RenderRequest UnderPanes(const MethodOptions& method, int n = 64) {
  RenderRequest request = LookDownOn(2, n);
  request.camera = LookDown(0.25, 2);
  request.lights = {LightAbove(2, 0.5)};
  request.method = method;
  request.outputs = {OutputKind::kVisibility};
  return request;
}

double Mean(const Image& v) {
  double sum = 0;
  for (size_t i = 0; i < v.size(); ++i) sum += v.data()[i];
  return sum / double(v.size());
}

double Deviation(const Image& v) {
  const double mean = Mean(v);
  double sum = 0;
  for (size_t i = 0; i < v.size(); ++i) sum += (v.data()[i] - mean) * (v.data()[i] - mean);
  return std::sqrt(sum / double(v.size()));
}

bool AreEqual(const Image& a, const Image& b) {
  return a.size() == b.size() && std::equal(a.data(), a.data() + a.size(), b.data());
}

class BlendTest : public ShadeTest {
 protected:
  Image Visibility(const FlatScene& scene, const RenderRequest& request) {
    std::vector<RenderedImage> images = Render(scene, request);
    return images.empty() ? Image() : std::move(images[0].image);
  }
};

// Points of a pane that decide on a pixel, each with a coin of its own: samples of the light, taps in its image on the
// map, of SSM the patches of it.
int CoinsOf(const std::string& method) {
  const std::map<std::string, int> coins = {{"hard", 1},  {"multi_map", 32}, {"ray", 64},   {"pcss", 15 * 15},
                                            {"ssm", 256}, {"pdsm", 32},      {"sssm", 225}, {"shaft", 256}};
  const auto found = coins.find(method);
  EXPECT_NE(found, coins.end()) << method;
  return found == coins.end() ? 1 : found->second;
}

class BlendMethodTest : public BlendTest, public testing::WithParamInterface<TestMethod> {
 protected:
  // Four standard deviations of a picture's mean. Of HARD 64 x 64 pixels are coins, 4 / (2 x 64); methods of one map
  // have its texels on a pane, at least 160 x 160 of 512 (of 4 x 256).
  double bound() const { return GetParam().name == "hard" ? 0.032 : 0.0125; }
};

TEST_P(BlendMethodTest, APaneLeavesWhatAlphaLeaves) {
  for (const float alpha : {0.25f, 0.5f, 0.75f}) {
    const Image v = Visibility(Panes({1}, alpha), UnderPanes(GetParam().options));
    ASSERT_GT(v.size(), 0u);
    std::printf("%.2f: mean %.4f, deviation of a pixel %.4f\n", alpha, Mean(v), Deviation(v));
    EXPECT_NEAR(Mean(v), 1 - alpha, bound());
    // A tenth more than coins have, since a cell may be met twice.
    EXPECT_LE(Deviation(v), 1.1 * std::sqrt(double(alpha) * (1 - alpha) / CoinsOf(GetParam().name)));
  }
}

TEST_P(BlendMethodTest, OfTwoPanesTheProductIsLeft) {
  for (const float alpha : {0.25f, 0.5f, 0.75f}) {
    const Image v = Visibility(Panes({0.75, 1}, alpha), UnderPanes(GetParam().options));
    ASSERT_GT(v.size(), 0u);
    std::printf("%.2f twice: mean %.4f\n", alpha, Mean(v));
    EXPECT_NEAR(Mean(v), (1 - alpha) * (1 - alpha), bound());
  }
}

TEST_P(BlendMethodTest, AlphaOfNoneIsNoPaneAndOfAllAnOpaqueOne) {
  const FlatScene ground = MakeFlatScene({MakePlate({0, 0, 0}, 8, 8)});
  FlatScene opaque = Panes({1}, 1);
  const RenderRequest request = UnderPanes(GetParam().options, 32);
  EXPECT_TRUE(AreEqual(Visibility(Panes({1}, 0), request), Visibility(ground, request)));
  const Image of_one = Visibility(Panes({1}, 1), request);
  for (Material& material : opaque.materials) material.alpha_mode = AlphaMode::kOpaque;
  EXPECT_TRUE(AreEqual(of_one, Visibility(opaque, request)));
  EXPECT_LT(Mean(of_one), 0.01);
}

// Alpha from a texture that is read between two texels, 0 at the left edge of the pane and 1 at the right one: of a
// small light the shadow is twice as large.
TEST_P(BlendMethodTest, AlphaIsThatOfTheTexture) {
  FlatScene scene = Panes({1}, 1);
  const Rgba texels = {255, 255, 255, 0, 255, 255, 255, 255};
  Texture sampling;
  sampling.wrap_s = sampling.wrap_t = Wrap::kClampToEdge;
  scene.materials[1].base_color_texture.texture = AddTexture(&scene, 2, 1, texels, sampling);
  // Texel centres are at the edges of the pane.
  scene.texcoords.resize(scene.positions.size());
  for (size_t i = 0; i < scene.positions.size(); ++i) scene.texcoords[i] = {0.5f + scene.positions[i].x / 8, 0.5f};
  RenderRequest request = UnderPanes(GetParam().options);
  request.lights = {LightAbove(2, 0.1)};
  const Image v = Visibility(scene, request);
  ASSERT_GT(v.size(), 0u);
  constexpr int kBands = 4;
  const int n = v.width();
  for (int band = 0; band < kBands; ++band) {
    double sum = 0;
    for (int y = 0; y < n; ++y) {
      for (int x = band * n / kBands; x < (band + 1) * n / kBands; ++x) sum += v.at(x, y, 0);
    }
    const double x_m = ((band + 0.5) / kBands - 0.5) * 2;
    const double alpha = 0.5 + x_m / 2 / 4;
    EXPECT_NEAR(sum * kBands / (n * n), 1 - alpha, 2 * bound());
  }
}

// Across the edge of a pane: what the opaque one hides, times alpha.
TEST_P(BlendMethodTest, APenumbraIsTheOpaqueOnesTimesAlpha) {
  const auto with_edge = [](float alpha, AlphaMode mode) {
    FlatScene scene = MakeFlatScene({MakePlate({0, 0, 0}, 8, 8), MakePlate({-2, 1, 0}, 4, 4)});
    scene.materials[1].alpha_mode = mode;
    scene.materials[1].base_color.a = alpha;
    return scene;
  };
  const RenderRequest request = UnderPanes(GetParam().options);
  const Image whole = Visibility(with_edge(1, AlphaMode::kOpaque), request);
  const Image v = Visibility(with_edge(0.5f, AlphaMode::kBlend), request);
  ASSERT_EQ(whole.size(), v.size());
  constexpr int kColumns = 16;  // a quarter of the picture: half a penumbra
  for (int first = 0; first < v.width(); first += kColumns) {
    double hidden = 0, hidden_by_whole = 0;
    for (int y = 0; y < v.height(); ++y) {
      for (int x = first; x < first + kColumns; ++x) {
        hidden += (1.0 - v.at(x, y, 0)) / (kColumns * v.height());
        hidden_by_whole += (1.0 - whole.at(x, y, 0)) / (kColumns * v.height());
      }
    }
    std::printf("columns from %d: hidden %.4f, by the opaque one %.4f\n", first, hidden, hidden_by_whole);
    EXPECT_NEAR(hidden, hidden_by_whole / 2, 2 * bound()) << "a quarter of the pixels, twice the deviation";
  }
}

TEST_P(BlendMethodTest, TheSameRequestHasTheSameBytesOnOneCpuToo) {
  const FlatScene scene = Panes({0.75, 1}, 0.5f);
  const RenderRequest request = UnderPanes(GetParam().options, 32);
  const Image first = Visibility(scene, request);
  EXPECT_TRUE(AreEqual(first, Visibility(scene, request)));
  cpu_set_t all, one;
  ASSERT_EQ(sched_getaffinity(0, sizeof(all), &all), 0);
  CPU_ZERO(&one);
  for (int cpu = 0; cpu < CPU_SETSIZE && CPU_COUNT(&one) == 0; ++cpu) {
    if (CPU_ISSET(cpu, &all)) CPU_SET(cpu, &one);
  }
  ASSERT_EQ(sched_setaffinity(0, sizeof(one), &one), 0);
  EXPECT_TRUE(AreEqual(first, Visibility(scene, request)));
  ASSERT_EQ(sched_setaffinity(0, sizeof(all), &all), 0);
}

INSTANTIATE_TEST_SUITE_P(Methods, BlendMethodTest, testing::ValuesIn(TestMethods()), TestMethodName);

// Rays, shafts and maps test one surface: cells of 4 cm here, since the pane is part of a mesh that reaches far behind
// the light.
TEST_F(BlendTest, RaysShaftsAndMapsSeeTheSameHoles) {
  constexpr double kFar = 160;  // of which a 4096th is 3.9 cm
  GlbMesh pane = MakePlate({0, 1, 0}, 1, 1);
  const GlbMesh far = MakePlate({0, 1 + kFar, 0}, 1, 1);
  const auto first = uint32_t(pane.positions.size());
  pane.positions.insert(pane.positions.end(), far.positions.begin(), far.positions.end());
  for (const uint32_t index : far.indices) pane.indices.push_back(first + index);
  FlatScene scene = MakeFlatScene({pane, MakePlate({0, 0, 0}, 8, 8)});
  scene.materials[0].alpha_mode = AlphaMode::kBlend;
  scene.materials[0].base_color.a = 0.5f;
  RenderRequest request = UnderPanes(HardOptions{2048}, 256);
  request.node_overrides.resize(1);
  request.node_overrides[0].node = 1;  // the ground casts nothing, so that the map is the pane's
  request.node_overrides[0].casts = false;
  request.lights = {LightAbove(2, 0)};
  const Image map = Visibility(scene, request);
  EXPECT_NEAR(Mean(map), 0.5, 0.06) << "676 cells: 3 sigma";
  for (const MethodOptions& method : {MethodOptions(RayOptions{1}), MethodOptions(ShaftOptions{8})}) {
    request.method = method;
    const Image other = Visibility(scene, request);
    ASSERT_EQ(map.size(), other.size());
    int different = 0;
    for (size_t i = 0; i < map.size(); ++i) different += map.data()[i] != other.data()[i];
    std::printf("different pixels: %d\n", different);
    // Half of 2 x 26 lines of 256 pixels are borders of holes. A pixel is 8 texels of the map, whose centres are a
    // quarter of a texel away from it along each axis on average: 208, and twice that for what the ends of borders add.
    EXPECT_LE(different, 2 * 26 * 256 / 32) << method.index();
  }
}

// Against closed forms: half of what the plate hides.
TEST_F(BlendTest, RaysThroughAPaneAreTheClosedFormTimesAlpha) {
  constexpr int kRays = 1024, kPixels = 32;
  FlatScene scene = MakeFlatScene({MakePlate({0, 0, 0}, 8, 8), MakePlate({0, 1, 0}, 1, 1)});
  scene.materials[1].alpha_mode = AlphaMode::kBlend;
  scene.materials[1].base_color.a = 0.5f;
  const Image v = Visibility(scene, UnderPanes(RayOptions{kRays}, kPixels));
  ASSERT_GT(v.size(), 0u);
  double sum = 0, square = 0;
  for (int y = 0; y < kPixels; ++y) {
    for (int x = 0; x < kPixels; ++x) {
      const glm::dvec3 at(((x + 0.5) / kPixels - 0.5) * 2, ((y + 0.5) / kPixels - 0.5) * 2, 2);
      const double hidden = 1 - VisibilityBehindPlate(glm::dvec2(0.25), {0, 0, 1}, glm::dvec2(0.5), at);
      const double error = v.at(x, y, 0) - (1 - hidden / 2);
      sum += error;
      square += error * error;
    }
  }
  constexpr double kDeviation = 0.5 / 32;  // of a pixel, at most: 1024 coins
  EXPECT_LE(std::sqrt(square) / kPixels, 1.1 * kDeviation);
  EXPECT_NEAR(sum / (kPixels * kPixels), 0, 4 * kDeviation / kPixels);
}

// The certificate's rays see the rule too: its interval holds the truth.
TEST_F(BlendTest, ACertificateMeasuresTheNoiseOfHoles) {
  const FlatScene scene = Panes({1}, 0.5f);
  RenderRequest request = UnderPanes(ShaftOptions{8});
  const Image v = Visibility(scene, request);
  request.certify = CertifyOptions{1024, 1024};
  EXPECT_TRUE(AreEqual(v, Visibility(scene, request)));
  const RenderReport told = report();
  ASSERT_TRUE(told.error.measured && told.error.ci95);
  request.certify.reset();
  request.method = RayOptions{4096};
  request.seed = 99;
  const auto error = Compare(Visibility(scene, request), v, nullptr);
  ASSERT_OK(error);
  std::printf("true %.4f, measured %.4f +- %.4f\n", *error->mae_shadowed, *told.error.measured, *told.error.ci95);
  EXPECT_NEAR(*error->mae_shadowed, *told.error.measured, *told.error.ci95);
  EXPECT_LT(*told.error.ci95, *told.error.measured / 2) << "it says something";
}

TEST_F(BlendTest, AutoTakesSamplesEnough) {
  const FlatScene scene = Panes({1}, 0.5f);
  for (const double max_error : {0.03, 0.012}) {
    RenderRequest request = UnderPanes(ShaftOptions{});
    request.is_auto = true;
    request.budget.max_error = max_error;
    const auto pose = BuildPose(scene, 0);
    ASSERT_OK(pose);
    ASSERT_OK(SettleMethod(scene, *pose, uint64_t(request.width) * request.height, &request));
    const Image v = Visibility(scene, request);
    const std::string method = report().method;
    const double predicted = report().error.predicted.value_or(0);
    RenderRequest truth = UnderPanes(RayOptions{4096});
    truth.seed = 99;
    const auto error = Compare(Visibility(scene, truth), v, nullptr);
    ASSERT_OK(error);
    std::printf("%s: budget %.4f, predicted %.4f, true %.4f\n", method.c_str(), max_error, predicted,
                *error->mae_shadowed);
    EXPECT_LE(*error->mae_shadowed, max_error);
    EXPECT_LE(predicted, 2 * *error->mae_shadowed);
    EXPECT_GE(predicted, *error->mae_shadowed / 2);
  }
}

TEST_F(BlendTest, TheCameraDrawsItFromOneHalf) {
  for (const float alpha : {0.49f, 0.5f}) {
    FlatScene scene = Panes({1}, alpha);
    scene.materials[1].emissive = glm::vec3(1);
    const Image frame = RenderFrame(scene, LookDownOn(1, 16));
    for (int i = 0; i < 16; ++i) EXPECT_EQ(frame.at(i, i, 0), alpha < 0.5f ? 0 : 1) << alpha;
  }
}

}  // namespace
}  // namespace halfshade
