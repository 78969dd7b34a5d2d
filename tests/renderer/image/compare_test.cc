#include "renderer/image/compare.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "tests/support/status_matchers.h"

namespace halfshade {
namespace {

using absl::StatusCode;
using testing::HasSubstr;

Image Of(int width, int height, int channels, const std::vector<float>& values) {
  Image image(width, height, channels);
  std::copy(values.begin(), values.end(), image.data());
  return image;
}

// Values that binary floats hold exactly.
//   reference   0     1/4   1/2   1
//   tested      1/8   1/4   1     3/4
//   |error|     1/8   0     1/2   1/4
// shadowed: the first three, (1/8 + 0 + 1/2) / 3 = 5/24. penumbra: 1/4 and 1/2, (0 + 1/2) / 2 = 1/4.
// all: (1/8 + 0 + 1/2 + 1/4) / 4 = 7/32; squares 1/64 + 0 + 1/4 + 1/16 = 21/64, mean 21/256.
const Image kReference = Of(4, 1, 1, {0, 0.25f, 0.5f, 1});
const Image kTested = Of(4, 1, 1, {0.125f, 0.25f, 1, 0.75f});

TEST(CompareTest, FiguresAreThoseWorkedOutByHand) {
  const auto error = Compare(kReference, kTested, nullptr);
  ASSERT_OK(error);
  EXPECT_EQ(error->samples_all, 4u);
  EXPECT_EQ(error->samples_shadowed, 3u);
  EXPECT_EQ(error->samples_penumbra, 2u);
  EXPECT_DOUBLE_EQ(*error->mae_shadowed, 5.0 / 24);
  EXPECT_DOUBLE_EQ(*error->mae_penumbra, 0.25);
  EXPECT_DOUBLE_EQ(*error->mae_all, 7.0 / 32);
  EXPECT_DOUBLE_EQ(*error->rmse_all, std::sqrt(21.0 / 256));
  EXPECT_DOUBLE_EQ(*error->psnr_all, 10 * std::log10(256.0 / 21));
  EXPECT_EQ(error->p999, 0.5) << "rank ceil(.999 * 4) = 4 of 0 1/8 1/4 1/2";
  EXPECT_EQ(error->max, 0.5);
  EXPECT_EQ(error->ssim_all, std::nullopt) << "no window of 11 fits";
}

TEST(CompareTest, TheMaskLeavesPixelsOutOfEverySet) {
  const Image mask = Of(4, 1, 1, {1, 0, 0, 0.001f});
  const auto error = Compare(kReference, kTested, &mask);
  ASSERT_OK(error);
  EXPECT_EQ(error->samples_all, 2u);
  EXPECT_EQ(error->samples_shadowed, 1u);
  EXPECT_EQ(error->samples_penumbra, 0u);
  EXPECT_DOUBLE_EQ(*error->mae_all, (0.125 + 0.25) / 2);
  EXPECT_DOUBLE_EQ(*error->mae_shadowed, 0.125);
  EXPECT_EQ(error->mae_penumbra, std::nullopt) << "of an empty set";
  EXPECT_EQ(error->max, 0.25);
  const Image nothing = Of(4, 1, 1, {0, 0, 0, 0});
  const auto none = Compare(kReference, kTested, &nothing);
  ASSERT_OK(none);
  EXPECT_EQ(none->samples_all, 0u);
  EXPECT_EQ(none->mae_all, std::nullopt);
  EXPECT_EQ(none->max, std::nullopt);
}

TEST(CompareTest, TheMarginsOfTheSetsAre512ths) {
  const float margin = 1.0f / 512;
  const Image reference =
      Of(6, 1, 1, {margin, std::nextafter(margin, 1.0f), 1 - margin, std::nextafter(1 - margin, 0.0f), 0, 1});
  const auto error = Compare(reference, reference, nullptr);
  ASSERT_OK(error);
  EXPECT_EQ(error->samples_penumbra, 2u) << "both margins are outside";
  EXPECT_EQ(error->samples_shadowed, 4u) << "all but 1 - 1/512 and 1";
}

TEST(CompareTest, EveryChannelIsASampleOfItsOwn) {
  const Image reference = Of(1, 2, 2, {0, 1, 0.5f, 1});
  const Image tested = Of(1, 2, 2, {0.5f, 1, 0.5f, 0.75f});
  const Image mask = Of(1, 2, 1, {0, 1});
  EXPECT_DOUBLE_EQ(*Compare(reference, tested, nullptr)->mae_all, 0.75 / 4);
  const auto masked = Compare(reference, tested, &mask);
  EXPECT_EQ(masked->samples_all, 2u);
  EXPECT_DOUBLE_EQ(*masked->mae_all, 0.125);
}

TEST(CompareTest, P999LeavesOutOneInAThousand) {
  // 2000 samples, two of them wrong by 1 and one by 1/2: rank ceil(1998) = 1998 of the sorted errors is 1/2.
  Image reference(2000, 1, 1), tested(2000, 1, 1);
  tested.data()[3] = tested.data()[999] = 1;
  tested.data()[1500] = 0.5f;
  const auto error = Compare(reference, tested, nullptr);
  ASSERT_OK(error);
  EXPECT_EQ(error->p999, 0.5);
  EXPECT_EQ(error->max, 1);
}

TEST(CompareTest, AnImageEqualsItself) {
  Image image(20, 20, 1);
  for (size_t i = 0; i < image.size(); ++i) image.data()[i] = float(i % 7) / 7;
  const auto error = Compare(image, image, nullptr);
  ASSERT_OK(error);
  EXPECT_EQ(error->mae_all, 0);
  EXPECT_EQ(error->rmse_all, 0);
  EXPECT_EQ(error->psnr_all, std::numeric_limits<double>::infinity());
  EXPECT_EQ(error->ssim_all, 1);
}

TEST(CompareTest, SsimOfConstantImagesIsTheLuminanceTerm) {
  // No variance: (2 a b + C1) / (a^2 + b^2 + C1) * C2 / C2. For 1/2 and 1/4, C1 = 1e-4: .2501 / .3126.
  Image a(11, 12, 1), b(11, 12, 1);
  std::fill(a.data(), a.data() + a.size(), 0.5f);
  std::fill(b.data(), b.data() + b.size(), 0.25f);
  EXPECT_EQ(Ssim(a, b, 0).width(), 1);
  EXPECT_EQ(Ssim(a, b, 0).height(), 2);
  EXPECT_NEAR(*Compare(a, b, nullptr)->ssim_all, 0.2501 / 0.3126, 1e-6);
  EXPECT_EQ(Ssim(Image(10, 12, 1), Image(10, 12, 1), 0).size(), 0u) << "no window fits";
}

TEST(CompareTest, SsimOfAStepAgainstItsInverseIsTheFormulaWithTheStepsWeights) {
  // One window. Columns 0 to 5 are 0 and 6 to 10 are 1 in a; b = 1 - a. With s the Gaussian's share of columns 6 to 10:
  // means s and 1 - s, variances s (1 - s) both, covariance -s (1 - s).
  Image a(11, 11, 1), b(11, 11, 1);
  for (int y = 0; y < 11; ++y) {
    for (int x = 0; x < 11; ++x) {
      a.at(x, y, 0) = x > 5 ? 1 : 0;
      b.at(x, y, 0) = 1 - a.at(x, y, 0);
    }
  }
  double right = 0, total = 0;
  for (int i = -5; i <= 5; ++i) {
    const double weight = std::exp(-i * i / 4.5);
    total += weight;
    if (i > 0) right += weight;
  }
  const double s = right / total, v = s * (1 - s);
  const double expected = (2 * v + 1e-4) * (-2 * v + 9e-4) / ((s * s + (1 - s) * (1 - s) + 1e-4) * (2 * v + 9e-4));
  // s = .3670, v = .2323: .4647 * -.4637 / (.5355 * .4655).
  EXPECT_NEAR(expected, -0.8645, 1e-4);
  EXPECT_NEAR(*Compare(a, b, nullptr)->ssim_all, expected, 1e-6);
}

TEST(CompareTest, SsimCountsTheWindowsWhoseCentreTheMaskLetsIn) {
  Image a(12, 11, 1), b(12, 11, 1), mask(12, 11, 1);
  for (int y = 0; y < 11; ++y) b.at(11, y, 0) = 1;  // in the second window alone
  mask.at(5, 5, 0) = 1;
  EXPECT_EQ(Compare(a, b, &mask)->ssim_all, 1);
  mask.at(6, 5, 0) = 1;
  EXPECT_LT(*Compare(a, b, &mask)->ssim_all, 0.9);
  mask = Image(12, 11, 1);
  mask.at(0, 0, 0) = 1;
  EXPECT_EQ(Compare(a, b, &mask)->ssim_all, std::nullopt) << "the centre of no window";
}

TEST(CompareTest, SizesThatDifferAndValuesThatAreNotFiniteAreNamed) {
  EXPECT_THAT(Compare(Image(4, 3, 1), Image(3, 4, 1), nullptr).status(),
              StatusIs(StatusCode::kInvalidArgument, HasSubstr("has 4 x 3 x 1 (width x height x channels), the other "
                                                               "image 3 x 4 x 1")));
  EXPECT_THAT(Compare(Image(4, 3, 1), Image(4, 3, 2), nullptr).status(),
              StatusIs(StatusCode::kInvalidArgument, HasSubstr("4 x 3 x 2")));
  const Image mask(4, 3, 2);
  EXPECT_THAT(Compare(Image(4, 3, 2), Image(4, 3, 2), &mask).status(),
              StatusIs(StatusCode::kInvalidArgument, HasSubstr("one channel")));
  Image broken(4, 3, 2);
  broken.at(1, 2, 1) = std::numeric_limits<float>::infinity();
  EXPECT_THAT(Compare(Image(4, 3, 2), broken, nullptr).status(),
              StatusIs(StatusCode::kInvalidArgument, HasSubstr("tested: the value at pixel 1,2 is not finite")));
}

}  // namespace
}  // namespace halfshade
