// What must hold wherever the scene stands, however large it is, and whatever the light's size and axes are.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <glm/gtc/matrix_transform.hpp>
#include <set>

#include "tests/stress/stress_fixture.h"

namespace halfshade {
namespace {

class NumericalStressTest : public StressTest {};
INSTANTIATE_TEST_SUITE_P(Methods, NumericalStressTest, testing::ValuesIn(TestMethods()), TestMethodName);

TEST(TestMethodsTest, AreAllThatAreRegistered) {
  std::set<std::string> tested;
  for (const TestMethod& method : TestMethods()) tested.insert(method.name);
  const std::vector<std::string> registered = RegisteredMethods();
  EXPECT_EQ(tested, std::set<std::string>(registered.begin(), registered.end()));
}

TEST(WhatMethodsCannotTest, NamesRegisteredMethodsAndReasons) {
  std::vector<std::string> registered = RegisteredMethods();
  for (const TestMethod& form : SoftShadowMapForms()) registered.push_back(form.name);
  for (const auto& [name, why] : WhatMethodsCannot()) {
    const std::string method = name.substr(name.find('/') + 1);
    EXPECT_NE(std::find(registered.begin(), registered.end(), method), registered.end()) << name;
    EXPECT_FALSE(why.empty()) << name;
  }
}

TEST_P(NumericalStressTest, UniformScaleChangesAlmostNothing) {
  const Image one = Render(Still());
  for (const double scale : {1e-6, 1e-3, 3.0, 1e3, 1e6}) {
    const Difference d = Between(one, Render(Moved(Still(), glm::dmat4(1), scale)), 2e-3);
    Row("scale", d.is_finite && d.share_over <= 1e-3, std::to_string(scale) + ": " + Text(d));
  }
}

TEST_P(NumericalStressTest, TranslationByManyExtentsChangesAlmostNothing) {
  const Image one = Render(Still());
  for (const double extents : {1.0, 1e2, 1e4}) {
    const glm::dmat4 move = glm::translate(glm::dmat4(1), glm::dvec3(8, 2, -5) * extents);
    const Difference d = Between(one, Render(Moved(Still(), move)), 1e-3);
    Row("translation", d.is_finite && d.share_over <= 1e-3, std::to_string(extents) + " extents: " + Text(d));
  }
  const Image far = Render(Moved(Still(), glm::translate(glm::dmat4(1), glm::dvec3(1e9, 0, 0))));
  Row("far translation", IsInRange(far), "finite and in [0,1]");
}

// The same oblong light by other axes: turned by 90 and 180 degrees, its edges swapped where they must be, and
// everything mirrored (which swaps u and v, for a light's frame is right-handed).
TEST_P(NumericalStressTest, TurningMirroringAndSwappingTheLightsAxesChangesNothingButItsSamples) {
  View still = Still();
  still.light.height_m = 0.6;
  const AreaLight light = still.light;
  const glm::dvec3 u = light.axis_u_ws, v = light.axis_v_ws;
  const Image one = Render(still, GetParam().Fine());
  const auto check = [&](const char* name, const Image& other) {
    const Difference d = Between(one, other, 1e-6);
    const double samples = GetParam().fine_samples;
    const bool holds = samples > 0 ? d.max <= 2 / std::sqrt(samples) && d.mean <= 1e-3 : d.max <= 1e-6;
    Row("turned light", d.is_finite && holds, std::string(name) + ": " + Text(d));
  };
  View turned = still;
  turned.light.axis_u_ws = v;
  turned.light.axis_v_ws = -u;
  std::swap(turned.light.width_m, turned.light.height_m);
  check("90 degrees", Render(turned, GetParam().Fine()));
  turned = still;
  turned.light.axis_u_ws = -u;
  turned.light.axis_v_ws = -v;
  check("180 degrees", Render(turned, GetParam().Fine()));

  View mirrored = Moved(still, glm::scale(glm::dmat4(1), glm::dvec3(-1, 1, 1)));
  std::swap(mirrored.light.axis_u_ws, mirrored.light.axis_v_ws);
  std::swap(mirrored.light.width_m, mirrored.light.height_m);
  mirrored.camera.right_ws = -mirrored.camera.right_ws;
  const Image flipped = Render(mirrored, GetParam().Fine());
  Image back = flipped;
  for (int y = 0; y < flipped.height(); ++y) {
    for (int x = 0; x < flipped.width(); ++x) back.at(x, y, 0) = flipped.at(flipped.width() - 1 - x, y, 0);
  }
  check("mirror", back);
}

// Visibility is additive over the light: the mean of q x q sub-lights is the whole, and nearer to the truth the more
// they are.
TEST_P(NumericalStressTest, TheMeanOfSubLightsIsTheLightAndComesNearerToTheTruthTheMoreTheyAre) {
  const View whole = Still();
  const Image truth = Render(whole, RayOptions{16384}, kStressSize, 7);
  double last = 1;
  bool shrinks = true;
  std::string figure = "mean errors";
  std::vector<Image> means;
  for (const int q : {1, 2, 4}) {
    RenderRequest request;
    request.camera = whole.camera;
    request.width = request.height = kStressSize;
    request.method = GetParam().options;
    for (int i = 0; i < q * q; ++i) {
      AreaLight part = whole.light;
      part.width_m /= q;
      part.height_m /= q;
      part.center_ws += part.axis_u_ws * ((i % q - (q - 1) / 2.0) * part.width_m) +
                        part.axis_v_ws * ((i / q - (q - 1) / 2.0) * part.height_m);
      request.lights.push_back(part);
    }
    const Image parts = RenderVisibility(whole.scene, request);
    ASSERT_EQ(parts.channels(), q * q);
    Image mean(kStressSize, kStressSize, 1);
    for (size_t i = 0; i < parts.size(); ++i) mean.data()[i / size_t(q * q)] += parts.data()[i] / float(q * q);
    const double error = Between(truth, mean, 1).mean;
    shrinks = shrinks && error < last;
    last = error;
    char text[40];
    std::snprintf(text, sizeof(text), ", %d x %d: %.5f", q, q, error);
    figure += text;
    means.push_back(std::move(mean));
  }
  Row("sub-lights", shrinks, figure);
  if (GetParam().name != "ray") return;
  const double noise = Between(means[0], Render(whole, GetParam().options, kStressSize, 1), 1).mean / 2;
  for (size_t i : {1, 2}) {
    const double difference = Between(means[0], means[i], 1).mean;
    Row("sub-lights", difference <= 2 * noise,
        "whole against parts " + std::to_string(difference) + ", its noise " + std::to_string(noise));
  }
}

TEST_P(NumericalStressTest, ALargerLightHasNoLargerUmbraAndNoSmallerPenumbra) { LightGrows(); }

TEST_P(NumericalStressTest, ATinyLightIsAPointButForItsSilhouettes) {
  const Difference d = Between(Render(Still(0)), Render(Still(3e-7)), 1e-3);
  // A texel is below a pixel here: the silhouettes are some 300 of 9216 pixels long.
  Row("tiny light", d.is_finite && d.share_over <= 0.01, Text(d));
}

TEST_P(NumericalStressTest, LinesPointsAndThinLightsAreFiniteAndBetweenTheirEnds) {
  for (const glm::dvec2 size : {glm::dvec2(1, 0), glm::dvec2(0, 1), glm::dvec2(0, 0), glm::dvec2(1, 1e-3)}) {
    View view = Still();
    view.light.width_m = size.x;
    view.light.height_m = size.y;
    Row("thin light", IsInRange(Render(view)), std::to_string(size.x) + " x " + std::to_string(size.y));
  }
}

}  // namespace
}  // namespace halfshade
