// PDSM on maps that GL draws: its forms against each other, and its pictures against closed forms and other methods.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <tuple>

#include "renderer/light/sample_points.h"
#include "renderer/scene/pose.h"
#include "renderer/scene_loader/scene_loader.h"
#include "renderer/shadow/pdsm/draw_sample_maps.h"
#include "renderer/shadow/pdsm/event_builder.h"
#include "renderer/shadow/pdsm/events.h"
#include "tests/support/closed_forms.h"
#include "tests/support/flat_scene_builder.h"
#include "tests/support/render_fixture.h"
#include "tests/support/scene_makers.h"

namespace halfshade {
namespace {

using pdsm::Event;
using pdsm::EventKind;

struct Drawn {
  pdsm::Grid grid;
  std::vector<pdsm::SampleMap> maps;
};

Drawn Draw(const FlatScene& scene, const AreaLight& light, int k, int size) {
  gl::ProgramCache programs(&TestContext());
  gl::Pacer pacer(TestContext(), [] { return absl::OkStatus(); });
  const DrawContext draw = {&TestContext(), &programs, &pacer};
  const auto pose = BuildPose(scene, 0, {});
  const auto on_context = SceneOnContext::Create(draw, scene);
  const auto occluders =
      OccludersOnContext::Create(draw, scene, **on_context, BuildLightSpaceOccluders(scene, *pose, light));
  const std::vector<glm::dvec2> points = SobolLightPoints(light, k, 0);
  Drawn drawn;
  drawn.grid = pdsm::GridOf((*occluders)->hull(), glm::dvec2(light.width_m, light.height_m) / 2.0, points, size, size);
  EXPECT_OK(pdsm::DrawSampleMaps(draw, **occluders, drawn.grid, points, [&](const pdsm::SampleMap& map) {
    drawn.maps.push_back(map);
    return absl::OkStatus();
  }));
  return drawn;
}
Drawn Draw(const MadeScene& made, int k, int size) {
  return Draw(MakeFlatScene(made.meshes), RequestFor(made).lights[0], k, size);
}

using EventKey = std::tuple<int, int, float, bool, EventKind, int, int>;
EventKey KeyOf(const Event& event) {
  return {event.ray.x, event.ray.y, event.depth, event.is_entry, event.kind, event.texel.x, event.texel.y};
}

TEST(PdsmMapsTest, OfDrawnMapsToScatterFindsTheEventsOfTraversal) {
  for (const auto& [name, seed] : {std::pair{"S2", 0u}, {"S3", 0u}, {"S5", 0u}, {"S5", 1u}, {"S5", 2u}}) {
    const Drawn drawn = Draw(MakeScene(name, {.seed = seed, .light_share = 0.5}), 4, 128);
    for (const pdsm::SampleMap& map : drawn.maps) {
      const pdsm::SamplePath path = pdsm::MakePath(drawn.grid, map.point, map.corner);
      std::vector<EventKey> traversed, scattered;
      for (int row = 0; row < drawn.grid.size; ++row) {
        pdsm::TraverseRow(drawn.grid, map, path, row, [&](const Event& event) { traversed.push_back(KeyOf(event)); });
      }
      const pdsm::TexelSteps steps(drawn.grid, map, path);
      for (int row = 0; row <= drawn.grid.map_size; ++row) {
        steps.ScatterRow(row, [&](const Event& event) { scattered.push_back(KeyOf(event)); });
      }
      ASSERT_GT(traversed.size(), 1000) << name;
      std::sort(traversed.begin(), traversed.end());
      std::sort(scattered.begin(), scattered.end());
      ASSERT_EQ(traversed, scattered) << name << ", seed " << seed;
    }
  }
}

TEST(PdsmMapsTest, EveryMapHoldsItsOccludersInsideAnEmptyBorder) {
  for (const char* name : {"S2", "S5"}) {
    const Drawn drawn = Draw(MakeScene(name, {.light_share = 0.5}), 4, 128);
    const int size = drawn.grid.map_size;
    for (const pdsm::SampleMap& map : drawn.maps) {
      EXPECT_GT(*std::max_element(map.depths.begin(), map.depths.end()), 0);
      for (int i = 0; i < size; ++i) {
        for (const int at : {i, i * size, (size - 1) * size + i, i * size + size - 1}) ASSERT_EQ(map.depths[at], 0);
      }
    }
  }
}

struct Counts {
  pdsm::FunctionCounts raw, kept;
  double megabytes = 0;
};
Counts CountEvents(const Drawn& drawn, float eps) {
  pdsm::EventBuilder builder(drawn.grid, pdsm::EventForm::kScatter);
  for (const pdsm::SampleMap& map : drawn.maps) EXPECT_OK(builder.Add(map));
  const auto result = builder.Finish({.eps = eps});
  return {result->raw, pdsm::CountVertices(result->functions), double(result->functions.SizeBytes()) * 1e-6};
}

// The paper's 63 -> 5 on average and 482 -> 40 at most, of which it never says eps. k = 64, m = n = 512, light .2.
TEST(PdsmMapsTest, CompressionLeavesFewEventsWhereEpsSpansSomeSteps) {
  std::vector<std::pair<std::string, Drawn>> scenes;
  for (const char* name : {"S2", "S3", "S5"}) {
    scenes.emplace_back(name, Draw(MakeScene(name, {.light_share = 0.2}), 64, 512));
  }
  if (const char* folder = std::getenv("HALFSHADE_TEST_DATA"); folder != nullptr) {
    std::ifstream file(std::string(folder) + "/scenes/nefertiti/nefertiti.glb", std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(file), {}};
    const auto scene = LoadGltf(bytes, {}, {});
    ASSERT_OK(scene);
    AreaLight light;  // of the folder's view
    light.center_ws = {-296.153, 872.616, 197.385};
    light.axis_u_ws = glm::normalize(glm::dvec3(-0.5547, 0, -0.83205));
    light.normal_ws = glm::normalize(glm::dvec3(0.314276, -0.925923, -0.209517));
    light.axis_v_ws = glm::cross(light.normal_ws, light.axis_u_ws);
    light.width_m = light.height_m = 230.351;
    scenes.emplace_back("nefertiti", Draw(*scene, light, 64, 512));
  }
  for (const auto& [name, drawn] : scenes) {
    Counts counts;
    for (const float eps : {0.01f, 0.02f, 0.04f}) {
      const double before = counts.kept.mean;
      counts = CountEvents(drawn, eps);
      std::printf("%s, eps %.2f: events %.1f mean, %u most -> %.1f mean, %u most, %.1f MB\n", name.c_str(), double(eps),
                  counts.raw.mean, counts.raw.most, counts.kept.mean, counts.kept.most, counts.megabytes);
      EXPECT_LT(counts.kept.mean, before == 0 ? counts.raw.mean : before);
    }
    EXPECT_LT(counts.kept.mean, counts.raw.mean / 4) << name;
    EXPECT_LT(counts.kept.most, counts.raw.most / 4) << name;
  }
}

// The paper's "stable in k": with more samples an eps spans more of their steps.
TEST(PdsmMapsTest, CompressedFunctionsDoNotGrowWithTheSamples) {
  double before = 1e9;
  for (const int k : {16, 32, 64, 128}) {
    const Counts counts = CountEvents(Draw(MakeScene("S5", {.light_share = 0.2}), k, 128), 0.04f);
    std::printf("S5, k %d, eps .04: %.1f events -> %.1f, %.2f MB\n", k, counts.raw.mean, counts.kept.mean,
                counts.megabytes);
    EXPECT_LT(counts.megabytes, before);
    before = counts.megabytes;
  }
}

// The plate of PlateTest: edge .8 at height 1 over a plane, a square light of edge .4 at height 2.
class PdsmPlateTest : public testing::Test {
 protected:
  PdsmPlateTest() : scene_(MakeFlatScene({MakePlate({0, 1, 0}, 0.8, 0.8)})) {
    request_.ground = Ground{0.0008, 8};  // 1e-4 of its size lower, and no occluder
    request_.camera = LookDown(0.5, 3.2);
    request_.width = request_.height = kPixels;
    request_.lights = {LightAbove(2, 0.4)};
  }
  // Mean error over the shadow, and the largest change between neighbours along the middle row.
  std::pair<double, double> Errors(const PdsmOptions& options) {
    request_.method = options;
    const Image v = RenderVisibility(scene_, request_);
    double sum = 0, step = 0;
    int shadowed = 0;
    for (int y = 0; y < kPixels; ++y) {
      for (int x = 0; x < kPixels; ++x) {
        const glm::dvec3 receiver(((x + 0.5) / kPixels - 0.5) * 3.2, ((y + 0.5) / kPixels - 0.5) * 3.2, 2);
        const double truth = VisibilityBehindPlate({0.2, 0.2}, {0, 0, 1}, {0.4, 0.4}, receiver);
        if (truth >= 1 - 1.0 / 512) continue;
        sum += std::abs(v.at(x, y, 0) - truth);
        ++shadowed;
      }
    }
    for (int x = 1; x < kPixels; ++x) {
      step = std::max(step, double(std::abs(v.at(x, kPixels / 2, 0) - v.at(x - 1, kPixels / 2, 0))));
    }
    EXPECT_GT(shadowed, 1000);
    return {sum / shadowed, step};
  }
  static constexpr int kPixels = 128;
  FlatScene scene_;
  RenderRequest request_;
};

TEST_F(PdsmPlateTest, EveryLayoutAndConstructionIsWithinItsBound) {
  struct Row {
    const char* name;
    PdsmConstruction construction;
    PdsmLayout layout;
  };
  for (const Row& row : {Row{"traversal", PdsmConstruction::kTraversal, PdsmLayout::kIndexed},
                         Row{"scatter", PdsmConstruction::kScatter, PdsmLayout::kIndexed},
                         Row{"slices, volume", PdsmConstruction::kSlices, PdsmLayout::kVolume}}) {
    PdsmOptions options = {.k = 64, .map_size = 256, .pdsm_size = 256};
    options.construction = row.construction;
    options.layout = row.layout;
    const double error = Errors(options).first;
    std::printf("%s: mae_shadowed %.5f\n", row.name, error);
    // .003 of 64 samples and of maps of 256, a quarter of their texel's slope; and half of compression's bound, or a
    // thousandth between slices.
    EXPECT_LE(error, row.layout == PdsmLayout::kIndexed ? 0.008 : 0.004) << row.name;
  }
}

TEST_F(PdsmPlateTest, EveryFilterIsWithinItsBoundAndWiderOnesAreSmoother) {
  double step_before = 1;
  for (const PdsmFilter filter :
       {PdsmFilter::kNearest, PdsmFilter::kBilinear, PdsmFilter::kWide2, PdsmFilter::kWide3}) {
    // A coarse PDSM, so that its texels are wider than pixels.
    const auto [error, step] = Errors({.k = 64, .map_size = 64, .pdsm_size = 64, .filter = filter});
    std::printf("filter %d: mae_shadowed %.5f, largest step %.3f\n", int(filter), error, step);
    EXPECT_LE(error, filter == PdsmFilter::kBilinear ? 0.008 : 0.02);
    EXPECT_LT(step, step_before);
    step_before = step;
  }
}

TEST_F(PdsmPlateTest, APointLightsShadowIsHardButOneTexelAroundItsEdge) {
  request_.lights = {LightAbove(2, 0)};
  for (const PdsmLayout layout : {PdsmLayout::kVolume, PdsmLayout::kIndexed}) {
    PdsmOptions options = {.k = 4, .map_size = 256, .pdsm_size = 256, .filter = PdsmFilter::kNearest};
    options.layout = layout;
    if (layout == PdsmLayout::kIndexed) options.construction = PdsmConstruction::kScatter;
    request_.method = options;
    const Image v = RenderVisibility(scene_, request_);
    request_.method = HardOptions{256};
    const Image hard = RenderVisibility(scene_, request_);
    int different = 0;
    for (size_t i = 0; i < v.size(); ++i) {
      ASSERT_TRUE(v.data()[i] == 0 || v.data()[i] == 1);
      different += v.data()[i] != hard.data()[i];
    }
    // The square's edge is 4 x 64 pixels long; texels of both are a quarter of a pixel wide.
    EXPECT_LE(different, 4 * 64 / 4);
    EXPECT_GT(std::count(v.data(), v.data() + v.size(), 0.0f), 3000);
  }
}

// Mean errors over shadowed pixels of a made scene, light .2 of its extent.
class PdsmClassTest : public testing::Test {
 protected:
  void Use(const char* name) {
    const MadeScene made = MakeScene(name, {.light_share = 0.2});
    scene_ = MakeFlatScene(made.meshes);
    request_ = RequestFor(made);
    request_.width = 160;
    request_.height = 90;
    request_.method = RayOptions{1024};
    truth_ = RenderVisibility(scene_, request_);
  }
  double ErrorOf(const MethodOptions& method) {
    request_.method = method;
    const Image v = RenderVisibility(scene_, request_);
    double sum = 0;
    int shadowed = 0;
    for (size_t i = 0; i < v.size(); ++i) {
      if (truth_.data()[i] >= 1 - 1.0f / 512) continue;
      sum += std::abs(v.data()[i] - truth_.data()[i]);
      ++shadowed;
    }
    EXPECT_GT(shadowed, 500);
    return sum / shadowed;
  }
  static PdsmOptions Indexed(int k) {
    PdsmOptions options = {.k = k, .eps = std::max(0.01f, 0.5f / float(k))};
    options.construction = PdsmConstruction::kScatter;
    options.layout = PdsmLayout::kIndexed;
    return options;
  }
  FlatScene scene_;
  RenderRequest request_;
  Image truth_;
};

TEST_F(PdsmClassTest, OfSelfShadowingSolidsItIsAboutAsGoodAsItsMaps) {
  for (const char* name : {"S2", "S3"}) {
    Use(name);
    const double maps = ErrorOf(MultiMapOptions{64, 512});
    const double volume = ErrorOf(PdsmOptions{});
    std::printf("%s: multi_map %.5f, pdsm %.5f\n", name, maps, volume);
    EXPECT_LE(volume, 1.1 * maps + 0.001) << name;  // A tenth over: no worse than its maps; a thousandth of noise
  }
}

TEST_F(PdsmClassTest, SixteenSoftSamplesDoAboutWhatSixtyFourDo) {
  for (const char* name : {"S2", "S3"}) {
    Use(name);
    PdsmOptions soft = Indexed(16);
    soft.has_soft_events = true;
    soft.eps = 0.002f;
    const double few = ErrorOf(Indexed(16)), many = ErrorOf(Indexed(64)), cells = ErrorOf(soft);
    std::printf("%s: k 16 %.5f, k 64 %.5f, k 16 soft %.5f\n", name, few, many, cells);
    EXPECT_LE(cells, 0.6 * few);
    EXPECT_LE(cells, 1.4 * many);
  }
}

TEST_F(PdsmClassTest, OfLeavesSlicesAmongTheOccludersAndSurfacesAloneAreNearlyAsGoodAsAllEvents) {
  Use("S5");
  PdsmOptions surfaces = Indexed(64);
  surfaces.is_surface_only = true;
  const double events = ErrorOf(Indexed(64)), alone = ErrorOf(surfaces), volume = ErrorOf(PdsmOptions{});
  std::printf("S5: all events %.5f, at surfaces %.5f, slices %.5f\n", events, alone, volume);
  EXPECT_LE(alone, 1.05 * events);
  EXPECT_LE(volume, 1.25 * events);  // even slices: 1.4
}

// A room around light and camera: what is nearest to the light's plane is beside it, and slices of even depth would
// hold everything else in one or two.
TEST(PdsmTest, InARoomFunctionsTakeThePlaceOfSlices) {
  const FlatScene scene = MakeFlatScene(
      {MakePlate({0, 0, 0}, 4, 4), MakeBox({-1.6, 1.5, 0}, {0.1, 3, 3}), MakeBox({0.3, 0.4, 0.1}, {0.5, 0.8, 0.5})});
  RenderRequest request;
  request.camera = LookFrom({1.6, 2.4, 2.6}, {0, 0.3, 0});
  request.width = request.height = 96;
  request.lights = {LightAbove(2.8, 0.8)};
  request.method = RayOptions{1024};
  const Image truth = RenderVisibility(scene, request);
  request.method = PdsmOptions{};
  RenderReport report;
  const Image v = RenderVisibility(scene, request, &report);
  ASSERT_EQ(v.size(), truth.size());
  double error = 0;
  int shadowed = 0;
  for (size_t i = 0; i < v.size(); ++i) {
    if (truth.data()[i] >= 1 - 1.0f / 512) continue;
    error += std::abs(v.data()[i] - truth.data()[i]);
    ++shadowed;
  }
  std::printf("room: mae_shadowed %.4f over %d pixels\n", error / shadowed, shadowed);
  EXPECT_GT(shadowed, 500);
  EXPECT_LE(error / shadowed, 0.02) << "64 samples, and maps of 512 over half of the space";
  std::string layout;
  for (const auto& [name, value] : report.options) layout = name == "layout" ? value : layout;
  EXPECT_EQ(layout, "INDEXED");
}

}  // namespace
}  // namespace halfshade
