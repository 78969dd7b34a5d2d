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
  ASSERT_EQ(json["cases"].size(), 1u);
  EXPECT_GE(json["cases"][0]["rows"].size(), 10u);
  for (const auto& row : json["cases"][0]["rows"]) {
    EXPECT_FALSE(row.contains("failure")) << row;
    EXPECT_GE(row["mae_shadowed"], 0);
    EXPECT_GT(row["cpu_ms"], 0);
  }
  for (const auto& curve : json["curves"]) EXPECT_EQ(curve["failure"], "") << curve;
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
