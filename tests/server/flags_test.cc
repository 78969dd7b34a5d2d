#include "server/flags.h"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace halfshade
