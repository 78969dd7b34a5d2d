#include "server/store.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "tests/support/status_matchers.h"

namespace halfshade {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

class StoreTest : public testing::Test {
 protected:
  void SetUp() override { folder_ = fs::temp_directory_path() / ("store_test_" + std::to_string(getpid())); }
  void TearDown() override { fs::remove_all(folder_); }
  std::unique_ptr<Store> Open(uint64_t max_bytes = 1 << 20) {
    auto store = Store::Open(folder_, max_bytes);
    EXPECT_OK(store);
    return store.ok() ? *std::move(store) : nullptr;
  }
  fs::path folder_;
  const std::string bytes_ = "some bytes";
  const std::string digest_ = Sha256Hex(bytes_);
};

TEST_F(StoreTest, WhatIsCommittedIsThereAfterARestart) {
  ASSERT_OK(Open()->Put(StoreKind::kBlob, digest_, bytes_));
  const auto store = Open();
  EXPECT_TRUE(store->Has(StoreKind::kBlob, digest_));
  EXPECT_EQ(*store->Get(StoreKind::kBlob, digest_), bytes_);
  EXPECT_EQ(store->size_bytes(), bytes_.size());
}

TEST_F(StoreTest, WrongBytesAreNeverVisible) {
  const auto store = Open();
  EXPECT_THAT(store->Put(StoreKind::kBlob, std::string(64, '0'), bytes_),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("digest: ")));
  EXPECT_FALSE(store->Has(StoreKind::kBlob, std::string(64, '0')));
  EXPECT_TRUE(fs::is_empty(folder_ / "incoming"));
}

TEST_F(StoreTest, AnUncommittedWriteLeavesNothing) {
  const auto store = Open();
  {
    auto writer = store->Write(StoreKind::kBlob, digest_, bytes_.size());
    ASSERT_OK(writer);
    ASSERT_OK((*writer)->Append("some"));
    EXPECT_FALSE(fs::is_empty(folder_ / "incoming"));
  }
  EXPECT_TRUE(fs::is_empty(folder_ / "incoming"));
  EXPECT_FALSE(store->Has(StoreKind::kBlob, digest_));
}

TEST_F(StoreTest, AHalfWrittenFileOfACrashIsSweptAtTheNextStart) {
  Open();
  std::ofstream(folder_ / "incoming" / "7") << "half";
  Open();
  EXPECT_TRUE(fs::is_empty(folder_ / "incoming"));
}

TEST_F(StoreTest, ADamagedFileIsRefusedAndRemoved) {
  const auto store = Open();
  ASSERT_OK(store->Put(StoreKind::kBlob, digest_, bytes_));
  std::ofstream(folder_ / "blobs" / digest_) << "other bytes";
  EXPECT_THAT(store->Get(StoreKind::kBlob, digest_), StatusIs(absl::StatusCode::kDataLoss, HasSubstr(digest_)));
  EXPECT_FALSE(store->Has(StoreKind::kBlob, digest_));
}

TEST_F(StoreTest, TheBoundHoldsOnBothSides) {
  const auto store = Open(bytes_.size());
  EXPECT_THAT(store->Write(StoreKind::kBlob, digest_, bytes_.size() + 1),
              StatusIs(absl::StatusCode::kResourceExhausted, HasSubstr("0 of 10 bytes are taken, 11 more do not fit")));
  EXPECT_OK(store->Put(StoreKind::kBlob, digest_, bytes_));
}

TEST_F(StoreTest, ATemporaryStoreGoesWithItsOwner) {
  fs::path mine;
  {
    auto store = Store::Open("", 100);
    ASSERT_OK(store);
    ASSERT_OK((*store)->Put(StoreKind::kBlob, digest_, bytes_));
  }
  for (const auto& entry : fs::directory_iterator(fs::temp_directory_path())) {
    if (fs::exists(entry.path() / "blobs" / digest_)) mine = entry.path();
  }
  EXPECT_TRUE(mine.empty()) << mine;
}

TEST_F(StoreTest, RemovedIsGone) {
  const auto store = Open();
  ASSERT_OK(store->Put(StoreKind::kScene, digest_, bytes_));
  store->Remove(StoreKind::kScene, digest_);
  EXPECT_THAT(store->Get(StoreKind::kScene, digest_), StatusIs(absl::StatusCode::kNotFound, Not(HasSubstr("damaged"))));
  EXPECT_TRUE(store->List(StoreKind::kScene).empty());
}

}  // namespace
}  // namespace halfshade
