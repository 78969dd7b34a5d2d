#include "server/flags.h"

#include <gtest/gtest.h>

#include <string>

namespace halfshade {
namespace {

// The exit code, -1 for one that serves.
int Parse(const char* flag, const std::string& value, DaemonFlags* flags) {
  const char* const arguments[] = {"halfshaded", flag, value.c_str()};
  return ParseDaemonFlags(3, arguments, flags);
}

TEST(FlagsTest, BoundsOfTheStoreAndTheSceneCacheHoldOnBothSides) {
  struct Case {
    const char* flag;
    std::string smallest, largest, below, above;
  };
  const Case cases[] = {{"--scene-store-mb", "1", "1073741824", "0", "1073741825"},
                        {"--scene-cache-mb", "1", "1073741824", "0", "1073741825"},
                        {"--max-unfinished-uploads", "1", "1048576", "0", "1048577"}};
  for (const Case& c : cases) {
    for (const std::string& value : {c.smallest, c.largest}) {
      DaemonFlags flags;
      EXPECT_EQ(Parse(c.flag, value, &flags), -1) << c.flag << " " << value;
      const ServerOptions& options = flags.options;
      const bool is_set = std::to_string(options.scene_store_mb) == value ||
                          std::to_string(options.scene_cache_mb) == value ||
                          std::to_string(options.limits.unfinished_uploads) == value;
      EXPECT_TRUE(is_set) << c.flag << " " << value;
    }
    for (const std::string& value : {c.below, c.above, std::string("x")}) {
      DaemonFlags flags;
      EXPECT_EQ(Parse(c.flag, value, &flags), 64) << c.flag << " " << value;
    }
  }
}

}  // namespace
}  // namespace halfshade
