#include "server/flags.h"

#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <tuple>

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
  for (const auto& [flag, field] :
       {Bound{"--gl-scene-mb", &ServerOptions::gl_scene_mb}, Bound{"--light-cache-mb", &ServerOptions::light_cache_mb},
        Bound{"--ray-scene-mb", &ServerOptions::ray_scene_mb}}) {
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

TEST(FlagsTest, BoundsOfTimesAndCountsHoldOnBothSides) {
  const auto times = [](ServerOptions& options) { return &options.connections; };
  struct Number {
    const char* flag;
    std::function<int*(ServerOptions&)> field;
    std::string smallest, largest, below, above;
  };
  const Number numbers[] = {
      {"--handshake-ms", [&](auto& o) { return &times(o)->handshake_ms; }, "1", "86400000", "0", "86400001"},
      {"--connection-age-ms", [&](auto& o) { return &times(o)->age_ms; }, "1", "86400000", "0", "86400001"},
      {"--connection-age-grace-ms", [&](auto& o) { return &times(o)->age_grace_ms; }, "1", "86400000", "0", "86400001"},
      {"--connection-idle-ms", [&](auto& o) { return &times(o)->idle_ms; }, "1", "86400000", "0", "86400001"},
      {"--keepalive-ms", [&](auto& o) { return &times(o)->keepalive_ms; }, "1", "86400000", "0", "86400001"},
      {"--keepalive-timeout-ms", [&](auto& o) { return &times(o)->keepalive_timeout_ms; }, "1", "86400000", "0",
       "86400001"},
      {"--canary-ms", [](auto& o) { return &o.canary_ms; }, "10", "3600000", "9", "3600001"},
      {"--contexts", [](auto& o) { return &o.contexts; }, "1", "64", "0", "65"},
      {"--grace-s", [](auto& o) { return &o.grace_s; }, "0", "3600", "-1", "3601"},
      {"--lame-duck-s", [](auto& o) { return &o.lame_duck_s; }, "0", "3600", "-1", "3601"},
      {"--stream-stall-s", [](auto& o) { return &o.stream_stall_s; }, "1", "3600", "0", "3601"}};
  for (const Number& n : numbers) {
    for (const std::string& value : {n.smallest, n.largest}) {
      ServerOptions options;
      EXPECT_EQ(Parse(n.flag, value.c_str(), &options), -1) << n.flag << " " << value;
      EXPECT_EQ(std::to_string(*n.field(options)), value) << n.flag;
    }
    for (const std::string& value : {n.below, n.above, std::string("x")}) {
      ServerOptions options;
      EXPECT_EQ(Parse(n.flag, value.c_str(), &options), 64) << n.flag << " " << value;
    }
  }
}

TEST(FlagsTest, WordsAreThoseThatTheHelpNames) {
  for (const auto& [flag, good, bad] :
       {std::tuple("--log-format", "json", "xml"), std::tuple("--log-format", "text", ""),
        std::tuple("--log-level", "off", "loud"), std::tuple("--gl", "osmesa", "vulkan")}) {
    ServerOptions options;
    EXPECT_EQ(Parse(flag, good, &options), -1) << flag << " " << good;
    EXPECT_EQ(Parse(flag, bad, &options), 64) << flag << " " << bad;
  }
}

TEST(FlagsTest, AddressesBeyondLoopbackNeedAWordThatTheyAreMeant) {
  ServerOptions options;
  for (const char* flag : {"--listen", "--admin"}) {
    EXPECT_EQ(Parse(flag, "0.0.0.0:1", &options), 64) << flag;
    EXPECT_EQ(Parse(flag, "127.0.0.1:1", &options), -1) << flag;
    EXPECT_EQ(Parse(flag, "unix:here", &options), -1) << flag;
  }
  EXPECT_EQ(Parse("--admin", "off", &options), -1);
}

TEST(FlagsTest, ScenesAreReadByTheProgramBesideUnlessTold) {
  ServerOptions options;
  EXPECT_EQ(Parse("--queue", "1", &options), -1);
  EXPECT_TRUE(options.fence.loader.ends_with("/halfshade-scene-loader")) << options.fence.loader;
  EXPECT_EQ(Parse("--scene-loader", "/opt/loader", &options), -1);
  EXPECT_EQ(options.fence.loader, "/opt/loader");
  EXPECT_EQ(Parse("--scene-loader", "none", &options), -1);
  EXPECT_EQ(options.fence.loader, "");
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
                        {"--max-unfinished-uploads", "1", "1048576", "0", "1048577"},
                        {"--loader-memory-mb", "64", "1048576", "63", "1048577"},
                        {"--loader-cpu-s", "1", "3600", "0", "3601"},
                        {"--loader-wall-s", "1", "3600", "0", "3601"}};
  for (const Case& c : cases) {
    for (const std::string& value : {c.smallest, c.largest}) {
      ServerOptions options;
      EXPECT_EQ(Parse(c.flag, value.c_str(), &options), -1) << c.flag << " " << value;
      const bool is_set =
          std::to_string(options.scene_store_mb) == value || std::to_string(options.scene_cache_mb) == value ||
          std::to_string(options.result_cache_mb) == value || std::to_string(options.view_cache_mb) == value ||
          std::to_string(options.limits.unfinished_uploads) == value ||
          std::to_string(options.fence.memory_mb) == value || std::to_string(options.fence.cpu_s) == value ||
          std::to_string(options.fence.wall_s) == value;
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
