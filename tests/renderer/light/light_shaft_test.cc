#include "renderer/light/light_shaft.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace halfshade {
namespace {

class Random {
 public:
  double Uniform(double low, double high) { return low + (high - low) * double(engine_()) / 4294967296.0; }
  glm::dvec3 Point(double size) { return {Uniform(-size, size), Uniform(-size, size), Uniform(-size, size)}; }

 private:
  std::mt19937 engine_{11};
};

bool MeetsBox(const glm::dvec3& from, const glm::dvec3& to, const Box3f& box) {
  double begin = 0, end = 1;
  for (int axis = 0; axis < 3; ++axis) {
    const double way = to[axis] - from[axis];
    const double a = (box.min[axis] - from[axis]) / way, b = (box.max[axis] - from[axis]) / way;
    begin = std::max(begin, std::min(a, b));
    end = std::min(end, std::max(a, b));
  }
  return begin <= end;
}

struct Made {
  std::array<glm::dvec3, 4> light;
  Box3d receivers;
};

Made MakeShaft(Random* random) {
  const glm::dvec3 center = random->Point(2), u = random->Point(0.5), v = random->Point(0.5);
  Made made{{center - u - v, center + u - v, center - u + v, center + u + v}, {}};
  const glm::dvec3 middle = random->Point(2);
  made.receivers.Add(middle - glm::abs(random->Point(0.4)));
  made.receivers.Add(middle + glm::abs(random->Point(0.4)));
  return made;
}

TEST(LightShaftTest, WhatMissesItMeetsNoSegment) {
  Random random;
  int missed = 0, met = 0;
  for (int i = 0; i < 20000; ++i) {
    const Made made = MakeShaft(&random);
    Box3f box;
    box.Add(glm::vec3(random.Point(1.5)));
    box.Add(box.min + glm::vec3(glm::abs(random.Point(0.8))));
    const bool misses = LightShaft(made.light, made.receivers).Misses(box);
    missed += misses;
    bool meets = false;
    for (int k = 0; k < 64 && !meets; ++k) {
      const double a = random.Uniform(0, 1), b = random.Uniform(0, 1);
      const glm::dvec3 on_light =
          glm::mix(glm::mix(made.light[0], made.light[1], a), glm::mix(made.light[2], made.light[3], a), b);
      const glm::dvec3 share(random.Uniform(0, 1), random.Uniform(0, 1), random.Uniform(0, 1));
      meets = MeetsBox(glm::mix(made.receivers.min, made.receivers.max, share), on_light, box);
    }
    met += meets;
    ASSERT_FALSE(misses && meets) << i;
  }
  // It is of use: of the boxes that no segment met, most are seen to miss.
  EXPECT_GT(met, 1000);
  EXPECT_GT(missed, (20000 - met) * 8 / 10);
}

TEST(LightShaftTest, ASlantedShaftIsNotItsBox) {
  const std::array<glm::dvec3, 4> light = {{{-0.1, 2, -0.1}, {0.1, 2, -0.1}, {-0.1, 2, 0.1}, {0.1, 2, 0.1}}};
  Box3d receivers;
  receivers.Add({2.9, 0, -0.1});
  receivers.Add({3.1, 0, 0.1});
  const LightShaft shaft(light, receivers);
  const auto cube = [](float x, float y) {
    Box3f box;
    box.Add({x - 0.05f, y - 0.05f, -0.05f});
    box.Add({x + 0.05f, y + 0.05f, 0.05f});
    return box;
  };
  // Above x = 1.5 it reaches from y = .9333 to 1.0667.
  EXPECT_TRUE(shaft.Misses(cube(1.5f, 0.82f)));
  EXPECT_FALSE(shaft.Misses(cube(1.5f, 0.93f)));
  EXPECT_FALSE(shaft.Misses(cube(1.5f, 1.07f)));
  EXPECT_TRUE(shaft.Misses(cube(1.5f, 1.18f)));
  EXPECT_FALSE(shaft.Misses(cube(3, 0)));
}

TEST(LightShaftTest, WhatLiesBelowTheReceiversPlaneIsCutOff) {
  const std::array<glm::dvec3, 4> light = {{{-1, 2, -1}, {1, 2, -1}, {-1, 2, 1}, {1, 2, 1}}};
  Box3d receivers;
  receivers.Add({-1, 0, -1});
  receivers.Add({1, 0, 1});
  LightShaft shaft(light, receivers);
  Box3f ground, plate;
  ground.Add({-5, -0.1f, -5});
  ground.Add({5, 0, 5});
  plate = ground;
  plate.Add({0, 0.1f, 0});
  EXPECT_FALSE(shaft.Misses(ground));
  shaft.CutBelow({0, 1, 0}, 1e-6);
  EXPECT_TRUE(shaft.Misses(ground));
  EXPECT_FALSE(shaft.Misses(plate));
}

}  // namespace
}  // namespace halfshade
