// The whole of the bench, once and small: that nothing in it is broken.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/client/temporary_folder.h"
#include "tests/integration_cli/process.h"

namespace halfshade {
namespace {

TEST(BenchCommandTest, TheSmokeSuiteMeasuresEverySettingOfEveryMethod) {
  TemporaryFolder folder;
  const Ran ran = RunHalfshade({"bench", "--suite", "smoke", "-o", "out"}, folder.path());
  ASSERT_EQ(ran.exit_code, 0) << ran.err;
  EXPECT_THAT(ran.out, testing::HasSubstr("mae_shad."));
  std::ifstream file(folder.path() / "out/bench.json");
  const auto json = nlohmann::json::parse(file);
  ASSERT_EQ(json["cases"].size(), 2u);
  EXPECT_GE(json["cases"][0]["rows"].size(), 10u);
  for (const auto& bench_case : json["cases"]) {
    for (const auto& row : bench_case["rows"]) {
      EXPECT_FALSE(row.contains("failure")) << row;
      EXPECT_GE(row["mae_shadowed"], 0);
      EXPECT_GT(row["cpu_ms"], 0);
    }
  }
  // Two roads to one truth: a filter with the weights, and lights with them.
  for (const auto& row : json["cases"][1]["rows"]) EXPECT_LE(row["mae_shadowed"], 0.02) << row;
  EXPECT_EQ(json["cases"][1]["rows"][1]["steps_wall_ms"][2][0], "blur_rows");
  for (const auto& curve : json["curves"]) EXPECT_EQ(curve["failure"], "") << curve;
  ASSERT_EQ(json["sequences"].size(), 3u);
  for (const auto& sequence : json["sequences"]) {
    EXPECT_FALSE(sequence.contains("failure")) << sequence;
    EXPECT_LE(sequence["mae_shadowed"], 0.02) << sequence;  // of a budget of .01, against 512 rays at a small size
    EXPECT_GT(sequence["lit_tiles"], 0) << sequence;
    EXPECT_FALSE(sequence["skips"].empty()) << sequence;
  }
  EXPECT_GT(json["replies"][0]["plan_ms"], 0);
  for (const char* name : {"index.html", "bench.csv", "bench.txt"}) {
    EXPECT_TRUE(std::ifstream(folder.path() / "out" / name).good()) << name;
  }
}

TEST(BenchCommandTest, NeedsAFolderAndKnowsItsSuites) {
  TemporaryFolder folder;
  EXPECT_EQ(RunHalfshade({"bench"}, folder.path()).exit_code, 64);
  EXPECT_EQ(RunHalfshade({"bench", "--suite", "huge", "-o", "out"}, folder.path()).exit_code, 64);
}

}  // namespace
}  // namespace halfshade
