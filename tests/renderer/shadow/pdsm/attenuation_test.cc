#include "renderer/shadow/pdsm/attenuation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace halfshade::pdsm {
namespace {

// A step function of `events` events of 1/k, entries and exits of k samples.
std::vector<Vertex> RandomSteps(std::mt19937& random, int k, int events) {
  std::vector<float> depths;
  for (int i = 0; i < events; ++i) depths.push_back(float(random() % 1000003 + 1) / 1000004.0f);
  std::sort(depths.rbegin(), depths.rend());
  std::vector<Vertex> steps;
  int hidden = 0;
  for (const float depth : depths) {
    const int next = hidden == 0 ? 1 : hidden == k ? k - 1 : hidden + (random() % 3 > 0 ? 1 : -1);
    steps.push_back({depth, float(hidden) / float(k)});
    steps.push_back({depth, float(next) / float(k)});
    hidden = next;
  }
  return steps;
}

TEST(EvaluateTest, IsZeroBeforeTheFirstVertexAndKeepsTheLastValue) {
  const std::vector<Vertex> function = {{0.8f, 0}, {0.8f, 0.5f}, {0.4f, 1}};
  EXPECT_EQ(Evaluate(function, 1), 0);
  EXPECT_EQ(Evaluate(function, 0.81f), 0);
  EXPECT_FLOAT_EQ(Evaluate(function, 0.6f), 0.75f);
  EXPECT_EQ(Evaluate(function, 0.1f), 1);
  EXPECT_EQ(Evaluate(function, 0), 1);
  EXPECT_EQ(Evaluate({}, 0.5f), 0);
}

TEST(EvaluateTest, AtAJumpHasTheValueNearerToTheLight) {
  const std::vector<Vertex> function = {{0.8f, 0}, {0.8f, 0.5f}, {0.4f, 0.5f}, {0.4f, 1}};
  EXPECT_EQ(Evaluate(function, 0.8f), 0);
  EXPECT_EQ(Evaluate(function, std::nextafter(0.8f, 0.0f)), 0.5f);
  EXPECT_EQ(Evaluate(function, 0.4f), 0.5f);
  EXPECT_EQ(Evaluate(function, std::nextafter(0.4f, 0.0f)), 1);
}

TEST(CompressTest, StaysWithinItsBoundAndWithinZeroAndOneAtEveryDepth) {
  std::mt19937 random(7);
  for (const float eps : {0.0f, 0.008f, 0.01f, 0.04f}) {
    for (int trial = 0; trial < 40; ++trial) {
      const std::vector<Vertex> function = RandomSteps(random, 64, 1 + int(random() % 300));
      std::vector<Vertex> compressed;
      Compress(function, eps, &compressed);
      std::vector<float> depths = {0, 1};
      for (const Vertex& vertex : function) {
        depths.insert(depths.end(),
                      {vertex.depth, std::nextafter(vertex.depth, 0.0f), std::nextafter(vertex.depth, 1.0f)});
      }
      for (int i = 0; i < 600; ++i) depths.push_back(float(random()) / 4294967296.0f);
      for (const float depth : depths) {
        const float value = Evaluate(compressed, depth);
        ASSERT_GE(value, 0);
        ASSERT_LE(value, 1);
        // Interpolating in floats adds an ulp.
        ASSERT_NEAR(value, Evaluate(function, depth), eps + 2e-7f) << "eps " << eps << " depth " << depth;
      }
      EXPECT_EQ(Evaluate(compressed, 1), 0);
    }
  }
}

TEST(CompressTest, KeepsBothEndsOfAJumpThatTheBoundDoesNotSpan) {
  std::vector<Vertex> compressed;
  Compress(std::vector<Vertex>{{0.5f, 0}, {0.5f, 1}}, 0.01f, &compressed);
  ASSERT_EQ(compressed.size(), 2);
  EXPECT_EQ(compressed[0].depth, 0.5f);
  EXPECT_EQ(compressed[1].depth, 0.5f);
  EXPECT_EQ(compressed[1].value, 1);
}

TEST(CompressTest, ARampOfManyStepsIsTwoVerticesAndAStep) {
  std::vector<Vertex> ramp;
  for (int i = 0; i < 64; ++i) {
    ramp.push_back({0.9f - 0.01f * float(i), float(i) / 64});
    ramp.push_back({0.9f - 0.01f * float(i), float(i + 1) / 64});
  }
  std::vector<Vertex> compressed;
  Compress(ramp, 1.0f / 64, &compressed);
  EXPECT_LE(compressed.size(), 4);
  EXPECT_GE(compressed.size(), 2);
}

TEST(CompressTest, WhatIsWithinTheBoundOfZeroIsNothing) {
  std::vector<Vertex> compressed;
  Compress(std::vector<Vertex>{{0.5f, 0}, {0.5f, 0.01f}}, 0.011f, &compressed);
  EXPECT_TRUE(compressed.empty());
  Compress(std::vector<Vertex>{{0.5f, 0}, {0.5f, 0.01f}}, 0.009f, &compressed);
  EXPECT_FALSE(compressed.empty());
}

AttenuationFunctions OneFunction(const std::vector<Vertex>& vertices) {
  FunctionRow row;
  row.vertices = vertices;
  row.counts = {uint32_t(vertices.size())};
  return JoinRows({row});
}

TEST(AddTest, IsTheSumOfBothCutAtOneAtEveryDepth) {
  std::mt19937 random(3);
  for (int trial = 0; trial < 200; ++trial) {
    std::vector<Vertex> of[2];
    for (auto& function : of) Compress(RandomSteps(random, 16, 1 + int(random() % 60)), 0.02f, &function);
    const AttenuationFunctions sum = Add(OneFunction(of[0]), OneFunction(of[1]));
    ASSERT_EQ(sum.size, 1);
    std::vector<float> depths = {0, 1};
    for (const auto& function : of) {
      for (const Vertex& vertex : function) {
        depths.insert(depths.end(),
                      {vertex.depth, std::nextafter(vertex.depth, 0.0f), std::nextafter(vertex.depth, 1.0f)});
      }
    }
    for (int i = 0; i < 200; ++i) depths.push_back(float(random()) / 4294967296.0f);
    for (const float depth : depths) {
      const float expected = std::min(1.0f, Evaluate(of[0], depth) + Evaluate(of[1], depth));
      ASSERT_NEAR(Evaluate(sum.Function(0), depth), expected, 2e-5) << "depth " << depth;
    }
  }
}

TEST(AddTest, OfNothingIsTheOther) {
  const std::vector<Vertex> function = {{0.8f, 0}, {0.8f, 0.5f}, {0.4f, 1}};
  for (const AttenuationFunctions& sum :
       {Add(OneFunction(function), OneFunction({})), Add(OneFunction({}), OneFunction(function))}) {
    ASSERT_EQ(sum.vertices.size(), function.size());
    for (size_t i = 0; i < function.size(); ++i) {
      EXPECT_EQ(sum.vertices[i].depth, function[i].depth);
      EXPECT_EQ(sum.vertices[i].value, function[i].value);
    }
  }
}

}  // namespace
}  // namespace halfshade::pdsm
