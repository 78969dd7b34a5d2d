#include "client/batch/sample.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/glm.hpp>
#include <map>
#include <nlohmann/json.hpp>

#include "client/batch/batch_file.h"
#include "client/batch/item_geometry.h"
#include "tests/support/status_matchers.h"

namespace halfshade {
namespace {

using nlohmann::json;
using testing::HasSubstr;

LineSampler Make(const json& fields) {
  json line = {{"id", "t"}, {"scene", "s.glb"}};
  line.update(fields);
  auto sampler = LineSampler::Create(line.dump(), "/folder");
  EXPECT_OK(sampler);
  return *std::move(sampler);
}

json Draw(const LineSampler& sampler, uint64_t index, uint64_t seed = 1) {
  const auto line = sampler.Line(seed, index);
  EXPECT_OK(line);
  return line.ok() ? json::parse(*line) : json();
}

void ExpectFault(const json& fields, const std::string& message) {
  json line = {{"id", "t"}, {"scene", "s.glb"}};
  line.update(fields);
  EXPECT_THAT(LineSampler::Create(line.dump(), "/folder"),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr(message)));
}

glm::dvec3 Vector(const json& v) { return {v["x"], v["y"], v["z"]}; }

TEST(SampleTest, ALineIsALineOfABatchWithItsOwnIdAndAnAbsoluteScene) {
  const json line = Draw(Make({{"width", 64}}), 12);
  EXPECT_EQ(line, json({{"id", "t-000012"}, {"scene", "/folder/s.glb"}, {"width", 64}}));
  EXPECT_OK(ReadBatchLine(line.dump(), "/elsewhere"));
}

TEST(SampleTest, SeedAndIndexDecideAndNothingElse) {
  const json width = {{"$integer", {1, 1'000'000}}};
  const LineSampler one = Make({{"width", width}}), more = Make({{"width", width}, {"height", {{"$integer", {1, 9}}}}});
  EXPECT_EQ(Draw(one, 5), Draw(one, 5));
  EXPECT_NE(Draw(one, 5)["width"], Draw(one, 6)["width"]);
  EXPECT_NE(Draw(one, 5)["width"], Draw(one, 5, 2)["width"]);
  EXPECT_EQ(Draw(one, 5)["width"], Draw(more, 5)["width"]) << "a field more changes no other";
  // By hand: 53 bits of SHA-256("1\n5\n/width/$integer").
  EXPECT_EQ(Draw(one, 5)["width"], 1 + int(0.8372570247357559 * 1e6));
}

TEST(SampleTest, NumbersFillTheirRange) {
  const LineSampler sampler =
      Make({{"seed", {{"$integer", {3, 5}}}},
            {"shading", {{"exposureEv", {{"$uniform", {-2, 2}}}}}},
            {"fog", {{"densityPerM", {{"$log", {0.01, 1}}}}}},
            {"method", {{"$choice", {{{"ray", {{"rays", {{"$choice", {16, 64}}}}}}}, {{"shaft", json::object()}}}}}}});
  std::map<int, int> seeds, rays;
  int below_middle = 0, below_tenth = 0, shafts = 0;
  constexpr int kLines = 3000;
  for (int i = 0; i < kLines; ++i) {
    const json line = Draw(sampler, uint64_t(i));
    ++seeds[line["seed"]];
    const double ev = line["shading"]["exposureEv"], density = line["fog"]["densityPerM"];
    EXPECT_TRUE(ev >= -2 && ev <= 2 && density >= 0.01 && density <= 1);
    below_middle += ev < 0;
    below_tenth += density < 0.1;
    shafts += line["method"].contains("shaft");
    if (line["method"].contains("ray")) ++rays[line["method"]["ray"]["rays"]];
  }
  // Of n lines with chance p, n p +- 5 sqrt(n p (1 - p)).
  const auto expect_share = [](int count, double of, double p) {
    EXPECT_NEAR(count, of * p, 5 * std::sqrt(of * p * (1 - p)));
  };
  EXPECT_EQ(seeds.size(), 3u);
  for (const auto& [seed, count] : seeds) expect_share(count, kLines, 1.0 / 3);
  expect_share(below_middle, kLines, 0.5);
  expect_share(below_tenth, kLines, 0.5);
  expect_share(shafts, kLines, 0.5);
  expect_share(rays[16], kLines, 0.25);
  expect_share(rays[64], kLines, 0.25);
}

TEST(SampleTest, CamerasFillTheirPartOfTheSphereEvenly) {
  const LineSampler sampler = Make({{"camera",
                                     {{"lookAt",
                                       {{"target", {{"x", 1}}},
                                        {"eye",
                                         {{"$hemisphere",
                                           {{"target", {1, 0, 0}},
                                            {"radius", {2, 3}},
                                            {"elevation_deg", {0, 90}},
                                            {"azimuth_deg", {0, 180}}}}}}}}}}});
  constexpr int kLines = 2000;
  int low = 0;
  glm::dvec3 sum(0);
  for (int i = 0; i < kLines; ++i) {
    const glm::dvec3 from_target = Vector(Draw(sampler, uint64_t(i))["camera"]["lookAt"]["eye"]) - glm::dvec3(1, 0, 0);
    const double radius = glm::length(from_target);
    EXPECT_TRUE(radius > 2 - 1e-6 && radius < 3 + 1e-6);
    EXPECT_GE(from_target.y, 0);
    EXPECT_GE(from_target.x, -1e-6) << "azimuths from +z over +x to -z";
    sum += from_target / radius;
    low += from_target.y < radius / 2;  // half of a hemisphere's area
  }
  EXPECT_NEAR(low, kLines / 2, 5 * std::sqrt(kLines / 4.0));
  EXPECT_NEAR(sum.y / kLines, 0.5, 0.04);
  EXPECT_NEAR(sum.z / kLines, 0, 0.06);
}

TEST(SampleTest, ALightEmitsTowardItsTarget) {
  const LineSampler sampler = Make({{"camera", {{"lookAt", {{"eye", {{"z", 9}}}, {"target", {{"y", 0.5}}}}}}},
                                    {"lights",
                                     {{{"$light",
                                        {{"target", {0, 0.5, 0}},
                                         {"radius", {3, 5}},
                                         {"elevation_deg", {20, 90}},
                                         {"width_m", {0.001, 1}},
                                         {"height_m", {2, 2}}}},
                                       {"radiance", {{"r", {{"$uniform", {1, 2}}}}}}}}}});
  for (uint64_t i = 0; i < 50; ++i) {
    const auto line = ReadBatchLine(Draw(sampler, i).dump(), "/");
    ASSERT_OK(line);
    const auto geometry = ItemGeometry(line->request);  // as the server reads it
    ASSERT_OK(geometry);
    const auto& light = (*geometry)["lights"][0];
    glm::dmat4 light_from_world;
    for (int k = 0; k < 16; ++k) light_from_world[k / 4][k % 4] = light["lightFromWorld"][size_t(k)];
    const glm::dvec4 target = light_from_world * glm::dvec4(0, 0.5, 0, 1);
    EXPECT_NEAR(glm::length(glm::dvec2(target)), 0, 1e-6);
    EXPECT_TRUE(target.z > 3 - 1e-6 && target.z < 5 + 1e-6) << target.z;
    EXPECT_NEAR(double(light["heightM"]), 2, 1e-8);
    EXPECT_GE(double(light["radiance"][0]), 1);
  }
}

TEST(SampleTest, NamesWhatIsNoDraw) {
  ExpectFault({{"width", {{"$uniform", {2, 1}}}}}, "/width/$uniform: must be [a, b], two numbers with a <= b");
  ExpectFault({{"width", {{"$uniform", {1}}}}}, "/width/$uniform: must be [a, b]");
  ExpectFault({{"width", {{"$log", {0, 1}}}}}, "/width/$log: must be over 0");
  ExpectFault({{"width", {{"$integer", {0.5, 1}}}}}, "/width/$integer: must be whole");
  ExpectFault({{"width", {{"$choice", json::array()}}}}, "/width/$choice: must be a list");
  ExpectFault({{"width", {{"$normal", {0, 1}}}}}, "/width/$normal: no such draw");
  ExpectFault({{"width", {{"$uniform", {1, 2}}, {"x", 1}}}}, "/width: $uniform stands with other keys");
  const auto eye = [](const json& hemisphere) -> json {
    return {{"camera", {{"lookAt", {{"eye", {{"$hemisphere", hemisphere}}}}}}}};
  };
  ExpectFault(eye({{"radius", {0, 1}}}), "/camera/lookAt/eye/$hemisphere/radius: must be [a, b] with 0 < a");
  ExpectFault(eye(json::object()), "/camera/lookAt/eye/$hemisphere/radius");
  ExpectFault(eye({{"radius", {1, 1}}, {"elevation_deg", {0, 91}}}), "elevation_deg: must lie within -90 to 90");
  ExpectFault(eye({{"radius", {1, 1}}, {"center", {0, 0, 0}}}), "$hemisphere/center: no such key");
  ExpectFault({{"lights", {{{"$light", {{"radius", {1, 1}}, {"width_m", {1, 1}}}}}}}},
              "/lights/0/$light/height_m: missing");
  ExpectFault({{"with", 1}}, "with");
  ExpectFault({{"id", 7}}, "/id: must be a string");
}

}  // namespace
}  // namespace halfshade
