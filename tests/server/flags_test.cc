#include "server/flags.h"

#include <gtest/gtest.h>

#include <string>

namespace halfshade {
namespace {

// -1: accepted.
int Parse(const char* flag, const char* value, ServerOptions* options) {
  const char* arguments[] = {"halfshaded", flag, value};
  DaemonFlags flags;
  const int result = ParseDaemonFlags(3, arguments, &flags);
  *options = flags.options;
  return result;
}

TEST(FlagsTest, BoundsOfGlMemoryAreOneMegabyteToAPetabyte) {
  struct Bound {
    const char* flag;
    uint64_t ServerOptions::*field;
  };
  for (const auto& [flag, field] : {Bound{"--gl-scene-mb", &ServerOptions::gl_scene_mb},
                                    Bound{"--light-cache-mb", &ServerOptions::light_cache_mb}}) {
    ServerOptions options;
    EXPECT_EQ(Parse(flag, "1", &options), -1) << flag;
    EXPECT_EQ(options.*field, 1u);
    EXPECT_EQ(Parse(flag, "1073741824", &options), -1) << flag;
    EXPECT_EQ((options.*field) << 20, 1ull << 50);
    EXPECT_EQ(Parse(flag, "0", &options), 64) << flag;
    EXPECT_EQ(Parse(flag, "1073741825", &options), 64) << flag;
    EXPECT_EQ(Parse(flag, "-1", &options), 64) << flag;
    EXPECT_EQ(Parse(flag, "much", &options), 64) << flag;
  }
}

TEST(FlagsTest, FlagsOfLaterVersionsSaySo) {
  ServerOptions options;
  testing::internal::CaptureStderr();
  EXPECT_EQ(Parse("--tls-cert", "a.pem", &options), 64);
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "--tls-cert: not available in this version\n");
}

TEST(FlagsTest, BoundsOfTheStoreAndTheCachesHoldOnBothSides) {
  struct Case {
    const char* flag;
    std::string smallest, largest, below, above;
  };
  const Case cases[] = {{"--scene-store-mb", "1", "1073741824", "0", "1073741825"},
                        {"--scene-cache-mb", "1", "1073741824", "0", "1073741825"},
                        {"--view-cache-mb", "1", "1073741824", "0", "1073741825"},
                        {"--result-cache-mb", "0", "1073741824", "-1", "1073741825"},
                        {"--max-unfinished-uploads", "1", "1048576", "0", "1048577"}};
  for (const Case& c : cases) {
    for (const std::string& value : {c.smallest, c.largest}) {
      ServerOptions options;
      EXPECT_EQ(Parse(c.flag, value.c_str(), &options), -1) << c.flag << " " << value;
      const bool is_set =
          std::to_string(options.scene_store_mb) == value || std::to_string(options.scene_cache_mb) == value ||
          std::to_string(options.result_cache_mb) == value || std::to_string(options.view_cache_mb) == value ||
          std::to_string(options.limits.unfinished_uploads) == value;
      EXPECT_TRUE(is_set) << c.flag << " " << value;
    }
    for (const std::string& value : {c.below, c.above, std::string("x")}) {
      ServerOptions options;
      EXPECT_EQ(Parse(c.flag, value.c_str(), &options), 64) << c.flag << " " << value;
    }
  }
}

}  // namespace
}  // namespace halfshade
