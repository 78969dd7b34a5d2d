#include "client/private_folder.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <stdlib.h>
#include <unistd.h>

#include <filesystem>

#include "tests/client/temporary_folder.h"
#include "tests/support/status_matchers.h"

namespace halfshade {
namespace {

namespace fs = std::filesystem;

// gtest runs DeathTest suites first: they fork, and other tests leave threads behind.
TEST(PrivateFolderDeathTest, IsGoneWhenASignalEndsTheProcessWhichDiesOfIt) {
  const TemporaryFolder parent;
  setenv("TMPDIR", parent.path().c_str(), 1);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    auto be_ended = [signal] {
      const auto folder = PrivateFolder::Create();
      if (!folder.ok() || !fs::is_directory(folder->path())) _exit(1);
      std::ofstream(folder->path() + "/blob") << "x";
      kill(getpid(), signal);
      sleep(20);
    };
    EXPECT_EXIT(be_ended(), testing::KilledBySignal(signal), "");
    EXPECT_TRUE(fs::is_empty(parent.path()));
  }
  unsetenv("TMPDIR");
}

TEST(PrivateFolderTest, IsGoneWithItsOwner) {
  std::string path;
  {
    const auto folder = PrivateFolder::Create();
    ASSERT_OK(folder);
    path = folder->path();
    EXPECT_TRUE(fs::is_directory(path));
  }
  EXPECT_FALSE(fs::exists(path));
}

}  // namespace
}  // namespace halfshade
