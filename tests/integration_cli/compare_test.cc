// `halfshade compare` from outside: figures, sizes, exit codes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

#include "tests/client/temporary_folder.h"
#include "tests/integration_cli/process.h"

namespace halfshade {
namespace {

using testing::HasSubstr;

std::string Floats(const std::vector<float>& values) {
  std::string bytes(values.size() * sizeof(float), '\0');
  std::memcpy(bytes.data(), values.data(), bytes.size());
  return bytes;
}

class CompareCommandTest : public testing::Test {
 protected:
  CompareCommandTest() {
    folder_.Write("a.f32", Floats({0, 0.25f, 0.5f, 1}));
    folder_.Write("b.f32", Floats({0.125f, 0.25f, 1, 0.75f}));
    folder_.Write("mask.f32", Floats({1, 0, 0, 1}));
    folder_.Write("nan.f32", Floats({0, 0, NAN, 0}));
  }
  Ran Run(const std::vector<std::string>& arguments) { return RunHalfshade(arguments, folder_.path()); }
  const TemporaryFolder folder_;
};

TEST_F(CompareCommandTest, PrintsEveryFigureWithItsSet) {
  const Ran ran = Run({"compare", "a.f32", "b.f32", "--size", "4x1"});
  ASSERT_EQ(ran.exit_code, 0) << ran.err;
  EXPECT_EQ(ran.out,
            "mae_shadowed  0.208333     shadowed, 3 samples\n"
            "mae_penumbra  0.25         penumbra, 2 samples\n"
            "mae_all       0.21875      all, 4 samples\n"
            "rmse_all      0.286411     all, 4 samples\n"
            "psnr_all      10.8602      all, 4 samples\n"
            "ssim_all      -            all, 4 samples\n"
            "p999          0.5          all, 4 samples\n"
            "max           0.5          all, 4 samples\n");
}

TEST_F(CompareCommandTest, JsonHasTheSameAndTheMaskLeavesPixelsOut) {
  const Ran ran = Run({"compare", "a.f32", "b.f32", "--size", "4x1", "--mask", "mask.f32", "--json"});
  ASSERT_EQ(ran.exit_code, 0) << ran.err;
  const nlohmann::json json = nlohmann::json::parse(ran.out);
  EXPECT_EQ(json["samples"]["all"], 2);
  EXPECT_EQ(json["mae_all"], 0.1875);
  EXPECT_TRUE(json["mae_penumbra"].is_null());
  const Ran same = Run({"compare", "a.f32", "a.f32", "--size", "4x1", "--json"});
  EXPECT_EQ(nlohmann::json::parse(same.out)["psnr_all"], "Infinity");
}

TEST_F(CompareCommandTest, FaultsExitAsTheyShould) {
  struct Case {
    std::vector<std::string> arguments;
    int exit_code;
    std::string message;
  };
  const Case cases[] = {
      {{"a.f32"}, 64, "B"},
      {{"a.f32", "b.f32"}, 64, "--size"},
      {{"a.f32", "b.f32", "--size", "0x4"}, 64, "--size"},
      {{"a.f32", "none.f32", "--size", "4x1"}, 66, "none.f32"},
      {{"a.f32", "b.f32", "--size", "3x1"}, 65, "a.f32: 16 bytes"},
      {{"a.f32", "b.f32", "--size", "4x1", "--mask", "none.png"}, 66, "none.png"},
      {{"a.f32", "nan.f32", "--size", "4x1"}, 65, "tested: the value at pixel 2,0 is not finite"},
      {{"a.gif", "b.f32", "--size", "4x1"}, 65, "a.gif"},
  };
  for (const Case& c : cases) {
    std::vector<std::string> arguments = {"compare"};
    arguments.insert(arguments.end(), c.arguments.begin(), c.arguments.end());
    const Ran ran = Run(arguments);
    EXPECT_EQ(ran.exit_code, c.exit_code) << testing::PrintToString(arguments) << ran.err;
    EXPECT_THAT(ran.err, HasSubstr(c.message)) << testing::PrintToString(arguments);
    EXPECT_EQ(ran.out, "");
  }
  folder_.Write("two.f32", Floats({0, 0, 0, 0, 0, 0, 0, 0}));
  const Ran ran = Run({"compare", "a.f32", "two.f32", "--size", "4x1"});
  EXPECT_EQ(ran.exit_code, 65);
  EXPECT_THAT(ran.err, HasSubstr("the reference has 4 x 1 x 1 (width x height x channels), the other image 4 x 1 x 2"));
}

}  // namespace
}  // namespace halfshade
