// Soft events: each sample stands for its stratum of the light. Against closed forms, on maps of made scenes.
#include "renderer/shadow/pdsm/soft_events.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <cstdio>

#include "tests/renderer/shadow/pdsm/made_maps.h"

namespace halfshade::pdsm {
namespace {

MadeMaps DrawStrata(const MadeOccluders& occluders, int k, int size) {
  std::vector<glm::dvec2> points;
  for (const Stratum& stratum : Strata(glm::dvec2(occluders.light_m / 2), k)) points.push_back(stratum.middle);
  return DrawMapsFrom(occluders, points, size, size);
}

EventBuilder::Result BuildSoft(const MadeMaps& made, double light_m, float eps) {
  SoftEventBuilder builder(made.grid);
  const std::vector<Stratum> strata = Strata(glm::dvec2(light_m / 2), int(made.maps.size()));
  for (size_t i = 0; i < strata.size(); ++i) EXPECT_TRUE(builder.Add(made.maps[i], strata[i]).ok());
  return *builder.Finish({.eps = eps});
}

EventBuilder::Result BuildHard(const MadeMaps& made, float eps) {
  EventBuilder builder(made.grid, EventForm::kScatter);
  for (const SampleMap& map : made.maps) EXPECT_TRUE(builder.Add(map).ok());
  return *builder.Finish({.eps = eps});
}

double ValueOf(const std::vector<SlopeEvent>& events, double depth) {
  double value = 0;
  for (const SlopeEvent& event : events) {
    if (event.depth > depth) value += event.step + double(event.slope) * (event.depth - depth);
  }
  return value;
}

TEST(StrataTest, ShareTheLightOut) {
  for (const int k : {1, 4, 8, 16, 32, 256}) {
    for (const glm::dvec2 half : {glm::dvec2(1, 1), glm::dvec2(1, 0.3), glm::dvec2(0.2, 0), glm::dvec2(0, 3)}) {
      const std::vector<Stratum> strata = Strata(half, k);
      ASSERT_EQ(strata.size(), size_t(k));
      glm::dvec2 low(1e9), high(-1e9), sum(0);
      for (const Stratum& stratum : strata) {
        low = glm::min(low, stratum.middle - stratum.half);
        high = glm::max(high, stratum.middle + stratum.half);
        sum += stratum.middle;
        if (half.x > 0 && half.y > 0) {
          EXPECT_NEAR(stratum.half.x * stratum.half.y * k, half.x * half.y, 1e-12);
        } else {
          EXPECT_NEAR((stratum.half.x + stratum.half.y) * k, half.x + half.y, 1e-12);
        }
      }
      EXPECT_NEAR(glm::length(low + half) + glm::length(high - half) + glm::length(sum), 0, 1e-12);
    }
  }
}

// l(d) = across (d_p - d_e) / (d_p - d): the share of [low, high] above it, exactly at the ramp's vertices and within a
// few hundredths between.
TEST(RampTest, IsTheShareOfTheStratumThatTheEdgeHasSwept) {
  for (const double sign : {1.0, -1.0}) {
    std::vector<SlopeEvent> events;
    AppendRamp({.occluder_depth = 0.8,
                .depth = 0.5,
                .across = 0.3 * sign,
                .low = sign > 0 ? 0.2 : -0.4,
                .high = sign > 0 ? 0.4 : -0.2},
               0, &events);
    EXPECT_LE(events.size(), size_t(kRampPieces + 1));
    for (double depth = 0; depth < 0.8; depth += 0.01) {
      const double l = 0.3 * 0.3 / (0.8 - depth);
      EXPECT_NEAR(ValueOf(events, depth), std::clamp((0.4 - l) / 0.2, 0.0, 1.0), 0.02) << "depth " << depth;
    }
  }
}

TEST(RampTest, OfAnEdgeThatIsMetBeyondInfinityBeginsBefore) {
  std::vector<SlopeEvent> events;
  // l at depth 0 is .3 .9 / .5 = .54 of a stratum from .2 to .8: met at .3 only at depth -.4.
  AppendRamp({.occluder_depth = 0.5, .depth = -0.4, .across = 0.3, .low = 0.2, .high = 0.8}, 0, &events);
  EXPECT_NEAR(ValueOf(events, 0), (0.8 - 0.54) / 0.6, 1e-6);
}

TEST(RampTest, OfNoExtentIsTheSamplesStep) {
  std::vector<SlopeEvent> events;
  AppendRamp({.occluder_depth = 0.8, .depth = 0.5, .across = 0.3, .low = 0.3, .high = 0.3, .sign = -1}, 0, &events);
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].depth, 0.5f);
  EXPECT_EQ(events[0].step, -1);
  EXPECT_EQ(events[0].slope, 0);
}

// Under a plate, 16 samples that stand for their strata against as many and sixteen times as many that stand for
// themselves.
TEST(SoftEventsTest, UnderAPlateSixteenSamplesDoWhatManyDo) {
  MadeOccluders occluders;
  occluders.light_m = 0.6;
  occluders.plates = {{{-0.3, -0.2}, {0.25, 0.35}, 1.0}};
  const auto error_of = [&](const MadeMaps& made, const AttenuationFunctions& functions) {
    const double receiver_z = 1.8;
    double sum = 0;
    int count = 0;
    for (int y = 0; y < made.grid.size; y += 3) {
      for (int x = 0; x < made.grid.size; x += 3) {
        const glm::dvec2 place = RayOf(made.grid, {x, y}) * receiver_z;
        const double share = HiddenByPlate(occluders, place, receiver_z);
        if (share < 0.002) continue;
        sum += std::abs(
            Evaluate(functions.Function(size_t(y) * made.grid.size + x), float(made.grid.z_near / receiver_z)) - share);
        ++count;
      }
    }
    EXPECT_GT(count, 500);
    return sum / count;
  };
  const MadeMaps strata = DrawStrata(occluders, 16, 256), few = DrawMaps(occluders, 16, 256, 256),
                 many = DrawMaps(occluders, 256, 256, 256);
  const auto soft = BuildSoft(strata, 0.6, 0.002f);
  const double soft_error = error_of(strata, soft.functions);
  const double hard_error = error_of(few, BuildHard(few, 0).functions);
  const double many_error = error_of(many, BuildHard(many, 0).functions);
  std::printf("k 16 hard %.4f, soft %.4f (%.1f vertices a ray); k 256 hard %.4f\n", hard_error, soft_error,
              CountVertices(soft.functions).mean, many_error);
  EXPECT_LT(soft_error, 0.5 * hard_error);
  EXPECT_LT(soft_error, 2 * many_error);
}

TEST(SoftEventsTest, ThreadsChangeNothing) {
  const MadeMaps made = DrawStrata(Clutter(30, 2, 0.5), 16, 96);
  const auto parallel = BuildSoft(made, 0.5, 0.01f);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const auto serial = BuildSoft(made, 0.5, 0.01f);
  ASSERT_EQ(parallel.functions.first, serial.functions.first);
  for (size_t i = 0; i < serial.functions.vertices.size(); ++i) {
    ASSERT_EQ(parallel.functions.vertices[i].depth, serial.functions.vertices[i].depth);
    ASSERT_EQ(parallel.functions.vertices[i].value, serial.functions.vertices[i].value);
  }
}

}  // namespace
}  // namespace halfshade::pdsm
