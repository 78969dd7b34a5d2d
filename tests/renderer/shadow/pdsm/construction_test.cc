// Every form of construction on maps of made scenes: against each other, against the maps themselves, against closed
// forms.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <tuple>

#include "renderer/shadow/pdsm/event_builder.h"
#include "renderer/shadow/pdsm/events.h"
#include "renderer/shadow/pdsm/slice_builder.h"
#include "tests/renderer/shadow/pdsm/made_maps.h"

namespace halfshade::pdsm {
namespace {

constexpr int kSize = 96;

EventBuilder::Result Build(const MadeMaps& made, EventForm form, float eps, bool is_surface_only = false) {
  EventBuilder builder(made.grid, form);
  for (const SampleMap& map : made.maps) EXPECT_TRUE(builder.Add(map).ok());
  return *builder.Finish({.eps = eps, .is_surface_only = is_surface_only});
}

SliceVolume BuildSlices(const MadeMaps& made, int slices) {
  // At no depth at which a ray of the cases crosses a border: there the function has a jump, and a slice its far side.
  SliceBuilder builder(made.grid, SpaceSlices(slices, 0.61234).Depths());
  for (const SampleMap& map : made.maps) builder.Add(map);
  return builder.Finish();
}

// Hidden fraction at a depth of a ray, asked from the maps; -1 where the ray is within 1e-3 of a texel's border, at
// which forms may differ by rounding.
double AskMaps(const MadeMaps& made, const glm::ivec2& ray, double depth) {
  double hidden = 0;
  for (const SampleMap& map : made.maps) {
    const glm::dvec2 slope = RayOf(made.grid, ray) - map.point * (depth / made.grid.z_near);
    const glm::dvec2 place = (slope - map.corner) / made.grid.MapTexel();
    const glm::ivec2 texel(glm::floor(place));
    const glm::dvec2 from_border = glm::min(glm::fract(place), 1.0 - glm::fract(place));
    if (std::min(from_border.x, from_border.y) < 1e-3) return -1;
    if (texel.x < 0 || texel.y < 0 || texel.x >= made.grid.map_size || texel.y >= made.grid.map_size) continue;
    hidden += map.depths[size_t(texel.y) * made.grid.map_size + texel.x] > depth;
  }
  return hidden / double(made.maps.size());
}

// Clutter of three seeds; a sphere over a plate; maps finer than the PDSM; a light of no width.
std::vector<MadeMaps> Cases() {
  std::vector<MadeMaps> cases;
  for (const uint32_t seed : {1u, 2u, 3u}) cases.push_back(DrawMaps(Clutter(30, seed, 0.5), 8, kSize, kSize));
  MadeOccluders contact;
  contact.light_m = 0.8;
  contact.spheres = {{{0.1, 0, 0.8}, 0.2}};
  contact.plates = {{{-0.5, -0.4}, {0.3, 0.5}, 1.0}};
  cases.push_back(DrawMaps(contact, 16, kSize, kSize));
  cases.push_back(DrawMaps(contact, 8, 2 * kSize + 40, kSize));
  contact.light_m = 0;
  cases.push_back(DrawMaps(contact, 1, kSize, kSize));
  return cases;
}

using EventKey = std::tuple<int, int, float, bool, EventKind, int, int>;
EventKey KeyOf(const Event& event) {
  return {event.ray.x, event.ray.y, event.depth, event.is_entry, event.kind, event.texel.x, event.texel.y};
}

TEST(EventsTest, ScatterFindsTheEventsOfTraversalAndNoOthers) {
  for (const MadeMaps& made : Cases()) {
    for (const SampleMap& map : made.maps) {
      const SamplePath path = MakePath(made.grid, map.point, map.corner);
      std::vector<EventKey> traversed, scattered;
      for (int row = 0; row < made.grid.size; ++row) {
        TraverseRow(made.grid, map, path, row, [&](const Event& event) { traversed.push_back(KeyOf(event)); });
      }
      const TexelSteps steps(made.grid, map, path);
      for (int row = 0; row <= made.grid.map_size; ++row) {
        steps.ScatterRow(row, [&](const Event& event) { scattered.push_back(KeyOf(event)); });
      }
      ASSERT_GT(traversed.size(), 100);
      std::sort(traversed.begin(), traversed.end());
      std::sort(scattered.begin(), scattered.end());
      ASSERT_EQ(traversed, scattered);
    }
  }
}

TEST(EventsTest, FinerMapsHaveAWholeNumberOfTexelsARay) {
  const MadeMaps made = Cases()[4];
  EXPECT_EQ(made.grid.map_texels, 3);
  EXPECT_LE(made.grid.map_size, 2 * kSize + 40);
}

TEST(ConstructionTest, ExactFunctionsSayWhatTheMapsSay) {
  std::mt19937 random(5);
  const auto unit = [&] { return double(random()) / 4294967296.0; };
  for (const MadeMaps& made : Cases()) {
    if (made.maps.size() == 1) continue;  // looks along borders at every depth: the test below
    const AttenuationFunctions functions = Build(made, EventForm::kScatter, 0).functions;
    int asked = 0;
    for (int i = 0; i < 20000; ++i) {
      const glm::ivec2 ray(int(unit() * made.grid.size), int(unit() * made.grid.size));
      const double depth = unit();
      const double truth = AskMaps(made, ray, depth);
      if (truth < 0) continue;
      ++asked;
      const float value = Evaluate(functions.Function(size_t(ray.y) * made.grid.size + ray.x), float(depth));
      ASSERT_NEAR(value, truth, 1e-6) << "ray " << ray.x << "," << ray.y << " depth " << depth;
    }
    EXPECT_GT(asked, 18000);
  }
}

TEST(ConstructionTest, OneSampleInTheMiddleIsTheHardMap) {
  MadeOccluders occluders = Clutter(20, 4, 0);
  const MadeMaps made = DrawMaps(occluders, 1, kSize, kSize);
  const AttenuationFunctions functions = Build(made, EventForm::kScatter, 0).functions;
  const SamplePath path = MakePath(made.grid, made.maps[0].point, made.maps[0].corner);
  ASSERT_EQ(path.steps.size(), 1);  // rays stay in their texel
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {
      const glm::ivec2 texel = glm::ivec2(x, y) + path.steps[0].cell;
      const bool is_inside =
          texel.x >= 0 && texel.y >= 0 && texel.x < made.grid.map_size && texel.y < made.grid.map_size;
      const float depth = is_inside ? made.maps[0].depths[size_t(texel.y) * made.grid.map_size + texel.x] : 0;
      const auto function = functions.Function(size_t(y) * kSize + x);
      ASSERT_EQ(Evaluate(function, depth), 0);
      ASSERT_EQ(Evaluate(function, std::nextafter(depth, 0.0f)), depth > 0 ? 1 : 0);
    }
  }
}

TEST(ConstructionTest, ValuesAreSharesFromZeroAtTheNearPlaneToTheirLastLevel) {
  for (const MadeMaps& made : Cases()) {
    const AttenuationFunctions functions = Build(made, EventForm::kTraversal, 0).functions;
    const auto k = float(made.maps.size());
    for (size_t ray = 0; ray < made.grid.RayCount(); ++ray) {
      const auto function = functions.Function(ray);
      if (function.empty()) continue;
      ASSERT_EQ(function.front().value, 0);
      for (const Vertex& vertex : function) {
        ASSERT_GE(vertex.value, 0);
        ASSERT_LE(vertex.value, 1);
        ASSERT_NEAR(vertex.value * k, std::round(vertex.value * k), 1e-4);
      }
    }
  }
}

TEST(ConstructionTest, CompressedFunctionsStayWithinEpsAtManyDepths) {
  std::mt19937 random(11);
  const MadeMaps made = DrawMaps(Clutter(30, 1, 0.5), 64, kSize, kSize);
  const AttenuationFunctions exact = Build(made, EventForm::kScatter, 0).functions;
  for (const float eps : {0.01f, 0.04f}) {
    const AttenuationFunctions compressed = Build(made, EventForm::kScatter, eps).functions;
    EXPECT_LT(compressed.vertices.size(), exact.vertices.size() / 2);
    for (int i = 0; i < 100000; ++i) {
      const size_t ray = random() % made.grid.RayCount();
      const float depth = float(random()) / 4294967296.0f;
      ASSERT_NEAR(Evaluate(compressed.Function(ray), depth), Evaluate(exact.Function(ray), depth), eps + 2e-7f);
    }
  }
}

TEST(ConstructionTest, SlicesAreTheExactFunctionsAtTheirDepths) {
  for (const MadeMaps& made : Cases()) {
    const SliceVolume volume = BuildSlices(made, 20);
    const AttenuationFunctions exact = Build(made, EventForm::kScatter, 0).functions;
    const auto maps = float(made.maps.size());
    int most = 0;
    for (size_t slice = 0; slice < volume.depths.size(); ++slice) {
      for (size_t ray = 0; ray < made.grid.RayCount(); ++ray) {
        const SliceCounts counts = volume.counts[slice * made.grid.RayCount() + ray];
        ASSERT_EQ(counts.hidden, std::round(Evaluate(exact.Function(ray), volume.depths[slice]) * maps));
        ASSERT_LE(counts.hidden_from_beyond, counts.hidden);
        most = std::max<int>(most, counts.hidden_from_beyond);
      }
    }
    EXPECT_GT(most, 0);
  }
}

TEST(SliceSpacingTest, RisesFromZeroToOneThroughTheFarthestOccluder) {
  for (const int count : {3, 16, 64, 255}) {
    for (const double from : {0.0, 1e-6, 0.1, 0.5, 0.7, 0.999, 1.0, 3.0}) {
      const SliceSpacing spacing = SpaceSlices(count, from);
      const std::vector<float> depths = spacing.Depths();
      ASSERT_EQ(int(depths.size()), count);
      ASSERT_EQ(depths.front(), 0);
      ASSERT_EQ(depths.back(), 1);
      for (int i = 1; i < count; ++i) ASSERT_GT(depths[i], depths[i - 1]) << "count " << count << " from " << from;
      ASSERT_EQ(depths[spacing.behind], spacing.occluders_from);
    }
  }
  const SliceSpacing spacing = SpaceSlices(64, 0.7);
  EXPECT_EQ(spacing.occluders_from, 0.7f);
  EXPECT_EQ(spacing.behind, 16);
}

// A plate hides, from a receiver at depth d of ray (u, v), the samples whose lines meet it.
TEST(ConstructionTest, UnderAPlateTheHiddenShareIsTheClippedRectangles) {
  MadeOccluders occluders;
  occluders.light_m = 0.6;
  occluders.plates = {{{-0.3, -0.2}, {0.25, 0.35}, 1.0}};
  const MadeMaps made = DrawMaps(occluders, 256, 256, 256);
  const AttenuationFunctions functions = Build(made, EventForm::kScatter, 0.01f).functions;
  const double receiver_z = 1.8;
  const double depth = made.grid.z_near / receiver_z;
  double sum = 0;
  int count = 0;
  for (int y = 0; y < made.grid.size; y += 5) {
    for (int x = 0; x < made.grid.size; x += 5) {
      const glm::dvec2 place = RayOf(made.grid, {x, y}) * receiver_z;
      const double share = HiddenByPlate(occluders, place, receiver_z);
      const double value = Evaluate(functions.Function(size_t(y) * made.grid.size + x), float(depth));
      if (share > 0.002) {
        sum += std::abs(value - share);
        ++count;
      }
    }
  }
  ASSERT_GT(count, 500);
  // Half a texel's slope h z/(2 L (z - 1)) = .007 at the borders, the bound of compression .01, and 256 samples.
  EXPECT_LT(sum / count, 0.012);
}

TEST(ConstructionTest, ThreadsChangeNothing) {
  const MadeMaps made = DrawMaps(Clutter(30, 2, 0.5), 16, kSize, kSize);
  const auto parallel = Build(made, EventForm::kScatter, 0.02f);
  const SliceVolume parallel_slices = BuildSlices(made, 16);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const auto serial = Build(made, EventForm::kScatter, 0.02f);
  ASSERT_EQ(parallel.functions.first, serial.functions.first);
  for (size_t i = 0; i < serial.functions.vertices.size(); ++i) {
    ASSERT_EQ(parallel.functions.vertices[i].depth, serial.functions.vertices[i].depth);
    ASSERT_EQ(parallel.functions.vertices[i].value, serial.functions.vertices[i].value);
  }
  ASSERT_EQ(parallel_slices.counts, BuildSlices(made, 16).counts);
}

TEST(ConstructionTest, TooManyEventsAreRefusedWithTheFigures) {
  const MadeMaps made = Cases()[0];
  EventBuilder all(made.grid, EventForm::kScatter);
  ASSERT_TRUE(all.Add(made.maps[0]).ok());
  const auto count = uint64_t(std::llround(all.Finish({})->raw.mean * double(made.grid.RayCount())));
  EventBuilder enough(made.grid, EventForm::kScatter, count);
  EXPECT_TRUE(enough.Add(made.maps[0]).ok());
  EventBuilder short_by_one(made.grid, EventForm::kScatter, count - 1);
  const absl::Status status = short_by_one.Add(made.maps[0]);
  EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_THAT(std::string(status.message()), testing::HasSubstr(std::to_string(count)));
}

TEST(ConstructionTest, StopsBetweenChunksOfRows) {
  const MadeMaps made = Cases()[0];
  for (const int allowed : {0, 1, 100}) {
    EventBuilder builder(made.grid, EventForm::kScatter);
    ASSERT_TRUE(builder.Add(made.maps[0]).ok());
    int asked = 0;
    const auto result =
        builder.Finish({.stop = [&] { return asked++ < allowed ? absl::OkStatus() : absl::CancelledError("stop"); }});
    // 96 rows are two chunks.
    EXPECT_EQ(asked, std::min(allowed + 1, 2));
    EXPECT_EQ(result.ok(), allowed == 100);
  }
}

// Where a map shows a surface on a ray, its events are kept: there, and where all is hidden or nothing, the value is
// the exact one but for eps.
TEST(ConstructionTest, OfSurfacesAloneTheValueStaysWithinEpsAtSurfaces) {
  const MadeMaps made = DrawMaps(Clutter(30, 1, 0.5), 64, kSize, kSize);
  const AttenuationFunctions exact = Build(made, EventForm::kScatter, 0).functions;
  const AttenuationFunctions all = Build(made, EventForm::kScatter, 0.01f).functions;
  const AttenuationFunctions at_surfaces = Build(made, EventForm::kScatter, 0.01f, true).functions;
  std::printf("vertices a ray: %.1f exact, %.1f compressed, %.1f at surfaces\n", CountVertices(exact).mean,
              CountVertices(all).mean, CountVertices(at_surfaces).mean);
  EXPECT_LT(at_surfaces.vertices.size(), all.vertices.size());
  uint64_t surfaces = 0, off = 0;
  for (const SampleMap& map : made.maps) {
    const SamplePath path = MakePath(made.grid, map.point, map.corner);
    for (int row = 0; row < made.grid.size; ++row) {
      TraverseRow(made.grid, map, path, row, [&](const Event& event) {
        if (event.kind != EventKind::kTop) return;
        const size_t ray = size_t(event.ray.y) * made.grid.size + event.ray.x;
        ASSERT_NEAR(Evaluate(at_surfaces.Function(ray), event.depth), Evaluate(exact.Function(ray), event.depth),
                    0.01f + 2e-7f);
        ++surfaces;
      });
    }
  }
  EXPECT_GT(surfaces, 1000);
  for (size_t ray = 0; ray < made.grid.RayCount(); ++ray) {
    for (const Vertex& vertex : exact.Function(ray)) {
      off += std::abs(Evaluate(at_surfaces.Function(ray), vertex.depth) - vertex.value) > 0.1f;
    }
    ASSERT_NEAR(Evaluate(at_surfaces.Function(ray), 0), Evaluate(exact.Function(ray), 0), 0.01f + 2e-7f);
  }
  EXPECT_GT(off, 0) << "between surfaces nothing is promised, or nothing would be saved";
}

TEST(GridTest, WindowsThatALightFillsMoveTheNearPlane) {
  GridNeeds needs;
  needs.rays = {-1, -1, 1, 1};
  needs.maps = {{-1, -1, 1, 1}};
  needs.half_edges = {0.5, 0.1};
  needs.z_near = 1e-6;
  needs.map_size = needs.pdsm_size = 64;
  const Grid grid = MakeGrid(needs);
  EXPECT_GT(grid.z_near, 1e-3);
  const SamplePath path = MakePath(grid, {0.5, 0.1}, MapCorner(grid, needs.maps[0], 0));
  EXPECT_LE(path.steps.size(), 2 * kMaxCrossings + 1);
  EXPECT_GT(path.steps.size(), kMaxCrossings / 2);
  needs.z_near = 1;
  EXPECT_EQ(MakeGrid(needs).z_near, 1);
}

}  // namespace
}  // namespace halfshade::pdsm
