// input_file and output_file: what is read, and that writing is whole or not at all.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>

#include "client/exit_code.h"
#include "client/input_file.h"
#include "client/output_file.h"
#include "tests/client/temporary_folder.h"
#include "tests/support/status_matchers.h"

namespace halfshade {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

size_t FilesIn(const fs::path& folder) {
  return static_cast<size_t>(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

TEST(InputFileTest, ReadsEveryByteOfARegularFile) {
  const TemporaryFolder folder;
  const std::string bytes("a\0b\r\n", 5);
  const auto read = ReadInputFile(folder.Write("x", bytes));
  ASSERT_OK(read);
  EXPECT_EQ(*read, bytes);
}

TEST(InputFileTest, RefusesWhatIsNoRegularFile) {
  const TemporaryFolder folder;
  ASSERT_EQ(mkfifo((folder / "pipe").c_str(), 0600), 0);
  EXPECT_THAT(ReadInputFile(folder / "absent"),
              StatusIs(absl::StatusCode::kNotFound, HasSubstr("absent: No such file")));
  EXPECT_THAT(ReadInputFile(folder / "pipe"), StatusIs(absl::StatusCode::kNotFound, HasSubstr("not a regular file")));
  EXPECT_THAT(ReadInputFile("/dev/zero"), StatusIs(absl::StatusCode::kNotFound, HasSubstr("not a regular file")));
  EXPECT_THAT(ReadInputFile(folder.path()), StatusIs(absl::StatusCode::kNotFound, HasSubstr("not a regular file")));
}

TEST(InputFileTest, RefusesASparseGiantBeforeTakingMemory) {
  const TemporaryFolder folder;
  const std::string path = folder.Write("giant", "x");
  fs::resize_file(path, 1ull << 40);
  EXPECT_THAT(ReadInputFile(path), StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("1099511627776 bytes")));
}

TEST(OutputFileTest, ReplacesFilesWholeAndLeavesNothingElse) {
  const TemporaryFolder folder;
  const std::string first = folder.Write("a.png", "old"), second = folder / "b.png";
  ASSERT_OK(WriteOutputFiles({{first, "new"}, {second, std::string(1 << 20, 'x')}}));
  EXPECT_EQ(ReadAll(first), "new");
  EXPECT_EQ(ReadAll(second).size(), 1u << 20);
  EXPECT_EQ(FilesIn(folder.path()), 2u);
}

TEST(OutputFileTest, OneTargetThatCannotBeWrittenLeavesTheOthersAsTheyWere) {
  const TemporaryFolder folder;
  const std::string first = folder.Write("a.png", "old");
  const absl::Status status = WriteOutputFiles({{first, "new"}, {folder / "none/b.png", "x"}});
  EXPECT_EQ(ExitCodeOf(status), kExitCannotWrite);
  EXPECT_THAT(status, StatusIs(absl::StatusCode::kDataLoss, HasSubstr("none/b.png")));
  EXPECT_EQ(ReadAll(first), "old");
  EXPECT_EQ(FilesIn(folder.path()), 1u);
}

TEST(OutputFileTest, AFullDiskLeavesNoFile) {
  // A limit on the size of files fails the write where a full disk does.
  const TemporaryFolder folder;
  const std::string target = folder.Write("a.png", "old");
  auto write_with_a_limit = [&] {
    signal(SIGXFSZ, SIG_IGN);
    rlimit limit{};
    limit.rlim_cur = limit.rlim_max = 1000;
    setrlimit(RLIMIT_FSIZE, &limit);
    _exit(ExitCodeOf(WriteOutputFiles({{target, std::string(5000, 'x')}})));
  };
  EXPECT_EXIT(write_with_a_limit(), testing::ExitedWithCode(kExitCannotWrite), "");
  EXPECT_EQ(ReadAll(target), "old");
  EXPECT_EQ(FilesIn(folder.path()), 1u);
}

TEST(OutputFileTest, NeverReplacesADeviceOrAFolder) {
  const TemporaryFolder folder;
  fs::create_directory(folder / "folder.png");
  fs::create_symlink("/dev/null", folder / "device.png");
  EXPECT_EQ(ExitCodeOf(CheckCanWrite(folder / "folder.png")), kExitCannotWrite);
  EXPECT_EQ(ExitCodeOf(CheckCanWrite(folder / "device.png")), kExitCannotWrite);
  EXPECT_EQ(ExitCodeOf(WriteOutputFiles({{folder / "device.png", "x"}})), kExitCannotWrite);
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
}

TEST(OutputFileTest, WritesThroughALinkToAFile) {
  const TemporaryFolder folder;
  const std::string target = folder.Write("real/a.png", "old");
  fs::create_symlink(target, folder / "link.png");
  ASSERT_OK(WriteOutputFiles({{folder / "link.png", "new"}}));
  EXPECT_TRUE(fs::is_symlink(folder / "link.png"));
  EXPECT_EQ(ReadAll(target), "new");
}

TEST(OutputFileTest, ABareNameGoesToTheWorkingFolder) {
  const TemporaryFolder folder;
  const fs::path before = fs::current_path();
  fs::current_path(folder.path());
  const absl::Status check = CheckCanWrite("a.png"), written = WriteOutputFiles({{"a.png", "x"}});
  fs::current_path(before);
  EXPECT_OK(check);
  EXPECT_OK(written);
  EXPECT_EQ(ReadAll(folder / "a.png"), "x");
}

TEST(OutputFileTest, FollowsTheUmask) {
  const TemporaryFolder folder;
  const mode_t before = umask(027);
  ASSERT_OK(WriteOutputFiles({{folder / "a.png", "x"}}));
  umask(before);
  EXPECT_EQ(fs::status(folder / "a.png").permissions(), static_cast<fs::perms>(0640));
}

}  // namespace
}  // namespace halfshade
