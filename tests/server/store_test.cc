#include "server/store.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <thread>

#include "server/status.h"
#include "tests/server/fault_files.h"
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
    options_.max_bytes = max_bytes;
    auto store = Store::Open(folder_, options_);
    EXPECT_OK(store);
    return store.ok() ? *std::move(store) : nullptr;
  }
  // An upload of `bytes` that is cut after `taken` of them.
  static void Cut(Store& store, const std::string& bytes, size_t taken) {
    auto writer = store.Write(StoreKind::kBlob, Sha256Hex(bytes), bytes.size());
    ASSERT_OK(writer);
    ASSERT_OK((*writer)->Append(bytes.substr(0, taken)));
  }
  static absl::Status Finish(Store& store, const std::string& bytes, size_t offset) {
    const auto writer = store.Write(StoreKind::kBlob, Sha256Hex(bytes), bytes.size(), offset);
    if (!writer.ok()) return writer.status();
    const absl::Status status = (*writer)->Append(bytes.substr(offset));
    return status.ok() ? (*writer)->Commit() : status;
  }
  std::string Read(const fs::path& path) const {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  StoreOptions options_;
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

TEST_F(StoreTest, ABlobThatIsCutStaysUnfinishedAndGoesOnAtEveryByte) {
  for (size_t cut = 1; cut < bytes_.size(); ++cut) {
    const auto store = Open();
    Cut(*store, bytes_, cut);
    EXPECT_FALSE(store->Has(StoreKind::kBlob, digest_));
    EXPECT_EQ(store->Query(digest_).committed_bytes, cut);
    EXPECT_FALSE(store->Query(digest_).is_complete);
    EXPECT_EQ(store->size_bytes(), cut);
    ASSERT_OK(Finish(*store, bytes_, cut));
    EXPECT_EQ(*store->Get(StoreKind::kBlob, digest_), bytes_);
    EXPECT_EQ(store->Query(digest_).committed_bytes, bytes_.size());
    EXPECT_TRUE(store->Query(digest_).is_complete);
    EXPECT_EQ(store->size_bytes(), bytes_.size());
    EXPECT_TRUE(fs::is_empty(folder_ / "incoming"));
    ASSERT_OK(store->Remove(StoreKind::kBlob, {digest_}));
    EXPECT_EQ(store->size_bytes(), 0u);
  }
}

TEST_F(StoreTest, AnUnfinishedBlobIsThereAfterARestart) {
  Cut(*Open(), bytes_, 4);
  const auto store = Open();
  EXPECT_EQ(store->Query(digest_).committed_bytes, 4u);
  EXPECT_EQ(store->size_bytes(), 4u);
  ASSERT_OK(Finish(*store, bytes_, 4));
  EXPECT_EQ(*store->Get(StoreKind::kBlob, digest_), bytes_);
}

TEST_F(StoreTest, AnOffsetLeavesNoGapAndWhatIsBeyondItIsDropped) {
  const auto store = Open();
  Cut(*store, bytes_, 6);
  EXPECT_THAT(store->Write(StoreKind::kBlob, digest_, bytes_.size(), 7),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("offset_bytes: 7; the next byte is 6")));
  { ASSERT_OK(store->Write(StoreKind::kBlob, digest_, bytes_.size(), 2)); }
  EXPECT_EQ(store->Query(digest_).committed_bytes, 2u);
  EXPECT_EQ(fs::file_size(folder_ / "incoming" / digest_), 2u);
  { ASSERT_OK(store->Write(StoreKind::kBlob, digest_, bytes_.size(), 0)); }
  EXPECT_TRUE(fs::is_empty(folder_ / "incoming")) << "nothing is left to go on from";
  EXPECT_EQ(store->size_bytes(), 0u);
}

TEST_F(StoreTest, ABeginningThatIsNotTheBlobsGoesWithTheDigest) {
  const auto store = Open();
  Cut(*store, bytes_, 4);
  std::ofstream(folder_ / "incoming" / digest_) << "none";
  EXPECT_THAT(Finish(*store, bytes_, 4), StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("digest: ")));
  EXPECT_EQ(store->Query(digest_).committed_bytes, 0u);
  EXPECT_EQ(store->size_bytes(), 0u);
  EXPECT_TRUE(fs::is_empty(folder_ / "incoming"));
  EXPECT_OK(Finish(*store, bytes_, 0));
}

TEST_F(StoreTest, OnlyResumableFilesOfACrashAreKept) {
  Open();
  std::ofstream(folder_ / "incoming" / "scene-7") << "half";
  std::ofstream(folder_ / "incoming" / std::string(64, '0')) << "";
  std::ofstream(folder_ / "incoming" / digest_) << "some";
  const auto store = Open();
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_ / "incoming"), {}), 1);
  EXPECT_EQ(store->Query(digest_).committed_bytes, 4u);
}

TEST_F(StoreTest, TheSecondWriterIsToldToComeBackUntilTheFirstIsSilentForLong) {
  options_.yield_after = std::chrono::seconds(60);
  auto store = Open();
  auto first = *store->Write(StoreKind::kBlob, digest_, bytes_.size());
  ASSERT_OK(first->Append("some"));
  const absl::Status refused = store->Write(StoreKind::kBlob, digest_, bytes_.size()).status();
  EXPECT_THAT(refused, StatusIs(absl::StatusCode::kResourceExhausted, HasSubstr("another call is uploading")));
  EXPECT_NE(PushbackMs(refused), "");
  ASSERT_OK(first->Append(" bytes"));
  ASSERT_OK(first->Commit());
  EXPECT_THAT(store->Write(StoreKind::kBlob, digest_, bytes_.size()),
              StatusIs(absl::StatusCode::kAlreadyExists, HasSubstr("is here")));
  ASSERT_OK(store->Remove(StoreKind::kBlob, {digest_}));
  first.reset();
  store.reset();

  options_.yield_after = std::chrono::milliseconds(0);
  store = Open();
  first = *store->Write(StoreKind::kBlob, digest_, bytes_.size());
  ASSERT_OK(first->Append("some"));
  auto second = store->Write(StoreKind::kBlob, digest_, bytes_.size());
  ASSERT_OK(second);
  EXPECT_THAT(first->Append(" bytes"), StatusIs(absl::StatusCode::kUnavailable, HasSubstr("another call goes on")));
  EXPECT_THAT(first->Commit(), StatusIs(absl::StatusCode::kUnavailable, HasSubstr("another call goes on")));
  first.reset();
  ASSERT_OK((*second)->Append(bytes_));
  ASSERT_OK((*second)->Commit());
  EXPECT_EQ(*store->Get(StoreKind::kBlob, digest_), bytes_);
  EXPECT_EQ(store->size_bytes(), bytes_.size());
}

TEST_F(StoreTest, WhereRoomIsNeededTheLongestUntouchedUnfinishedBlobsGoFirst) {
  auto store = Open(100);
  const std::string a(40, 'a'), b(40, 'b'), c(40, 'c');
  Cut(*store, a, 30);
  Cut(*store, b, 30);
  store->Write(StoreKind::kBlob, Sha256Hex(a), a.size(), 30).value()->Append("a").IgnoreError();  // touched
  store.reset();
  fs::last_write_time(folder_ / "incoming" / Sha256Hex(a), fs::file_time_type::clock::now() + std::chrono::hours(1));
  store = Open(100);
  EXPECT_THAT(
      store->Write(StoreKind::kBlob, Sha256Hex("x"), 101),
      StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("size_bytes: 101; the scene store holds at most 100")));
  EXPECT_EQ(store->Query(Sha256Hex(b)).committed_bytes, 30u) << "not for one that cannot fit";
  ASSERT_OK(store->Put(StoreKind::kBlob, Sha256Hex(c), c));
  EXPECT_EQ(store->Query(Sha256Hex(b)).committed_bytes, 0u);
  EXPECT_EQ(store->Query(Sha256Hex(a)).committed_bytes, 31u);
  EXPECT_EQ(store->size_bytes(), 71u);
  // 40 are whole; 61 more do not fit, whoever else goes; 60 do.
  EXPECT_THAT(store->Write(StoreKind::kBlob, digest_, 61),
              StatusIs(absl::StatusCode::kResourceExhausted,
                       HasSubstr("40 of 100 bytes are taken, 61 more do not fit; delete scenes")));
  EXPECT_EQ(store->Query(Sha256Hex(a)).committed_bytes, 31u);
  EXPECT_OK(store->Write(StoreKind::kBlob, digest_, 60));
  EXPECT_EQ(store->Query(Sha256Hex(a)).committed_bytes, 0u);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_ / "incoming"), {}), 0);
}

TEST_F(StoreTest, WhatUploadsUnderWayWillTakeIsTakenAndMayCome) {
  const auto store = Open(100);
  auto writer = store->Write(StoreKind::kBlob, digest_, 60);
  ASSERT_OK(writer);
  EXPECT_EQ(store->size_bytes(), 60u) << "announced";
  const absl::Status status = store->Write(StoreKind::kBlob, Sha256Hex("x"), 41).status();
  EXPECT_THAT(status,
              StatusIs(absl::StatusCode::kResourceExhausted,
                       HasSubstr("60 of 100 bytes are taken, 41 more do not fit beside the uploads under way")));
  EXPECT_NE(PushbackMs(status), "");
  EXPECT_OK(store->Write(StoreKind::kBlob, Sha256Hex("x"), 40));
}

TEST_F(StoreTest, TheNumberOfUnfinishedBlobsIsBounded) {
  options_.max_unfinished = 2;
  const auto store = Open();
  const std::string a = "aaaa", b = "bbbb", c = "cccc";
  Cut(*store, a, 1);
  Cut(*store, b, 2);
  EXPECT_EQ(store->Query(Sha256Hex(a)).committed_bytes, 1u);
  Cut(*store, c, 3);
  EXPECT_EQ(store->Query(Sha256Hex(a)).committed_bytes, 0u) << "the longest untouched";
  EXPECT_EQ(store->Query(Sha256Hex(b)).committed_bytes, 2u);
  const auto first = store->Write(StoreKind::kBlob, Sha256Hex(b), 4, 2);
  const auto second = store->Write(StoreKind::kBlob, Sha256Hex(c), 4, 3);
  ASSERT_OK(first);
  ASSERT_OK(second);
  const absl::Status status = store->Write(StoreKind::kBlob, Sha256Hex(a), 4).status();
  EXPECT_THAT(status, StatusIs(absl::StatusCode::kResourceExhausted, HasSubstr("at most 2 uploads at a time; 2 are")));
  EXPECT_NE(PushbackMs(status), "");
}

TEST_F(StoreTest, AStoreBelongsToOneProcess) {
  const auto store = Open();
  EXPECT_THAT(Store::Open(folder_, options_),
              StatusIs(absl::StatusCode::kFailedPrecondition, HasSubstr("another process has it")));
}

TEST_F(StoreTest, AValueCutShortOrFlippedAtAnyByteIsRefusedRemovedAndTakenAgain) {
  const auto store = Open();
  const fs::path path = folder_ / "blobs" / digest_;
  for (size_t at = 0; at < bytes_.size(); ++at) {
    for (const bool is_cut : {true, false}) {
      ASSERT_OK(store->Put(StoreKind::kBlob, digest_, bytes_));
      std::string damaged = is_cut ? bytes_.substr(0, at) : bytes_;
      if (!is_cut) damaged[at] = char(damaged[at] ^ 1);
      std::ofstream(path, std::ios::binary) << damaged;
      EXPECT_THAT(store->Get(StoreKind::kBlob, digest_), StatusIs(absl::StatusCode::kDataLoss, HasSubstr(digest_)));
      EXPECT_FALSE(store->Has(StoreKind::kBlob, digest_));
      EXPECT_FALSE(fs::exists(path));
      EXPECT_EQ(store->size_bytes(), 0u);
    }
  }
}

TEST_F(StoreTest, AFileThatGrewIsReadNoFurtherThanItsSize) {
  const auto store = Open();
  ASSERT_OK(store->Put(StoreKind::kBlob, digest_, bytes_));
  std::ofstream(folder_ / "blobs" / digest_, std::ios::app) << std::string(1 << 20, 'x');
  EXPECT_THAT(store->Get(StoreKind::kBlob, digest_), StatusIs(absl::StatusCode::kDataLoss, HasSubstr(digest_)));
}

TEST_F(StoreTest, AFileThatIsGoneIsNotFoundAndNotCounted) {
  const auto store = Open();
  ASSERT_OK(store->Put(StoreKind::kBlob, digest_, bytes_));
  fs::remove(folder_ / "blobs" / digest_);
  EXPECT_THAT(store->Get(StoreKind::kBlob, digest_), StatusIs(absl::StatusCode::kNotFound, HasSubstr("is not here")));
  EXPECT_EQ(store->size_bytes(), 0u);
}

TEST_F(StoreTest, ReadersWritersAndRemoversSeeWholeValuesOrNone) {
  const auto store = Open();
  const std::string bytes(300'000, 'x'), digest = Sha256Hex(bytes);
  std::vector<std::thread> threads;
  std::atomic<int> whole{0}, writing{2};
  for (int t = 0; t < 2; ++t) {
    threads.emplace_back([&] {
      while (writing > 0) {
        const auto got = store->Get(StoreKind::kBlob, digest);
        EXPECT_TRUE(got.ok() ? *got == bytes : absl::IsNotFound(got.status())) << got.status();
        whole += got.ok();
      }
    });
    threads.emplace_back([&] {
      // Until some reader has come between a put and its removal, however the threads are scheduled.
      for (int i = 0; i < 50 || (whole == 0 && i < 5000); ++i) {
        const absl::Status put = store->Put(StoreKind::kBlob, digest, bytes);
        EXPECT_TRUE(put.ok() || absl::IsResourceExhausted(put)) << put;
        EXPECT_OK(store->Remove(StoreKind::kBlob, {digest}));
      }
      --writing;
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_GT(whole, 0);
  ASSERT_OK(store->Remove(StoreKind::kBlob, {digest}));
  EXPECT_EQ(store->size_bytes(), 0u);
}

// Every call that the store makes fails once, in every way: what was acknowledged is there, what was not is invisible
// or to be gone on with, the count is exact, and the next try succeeds.
TEST_F(StoreTest, AFaultAtAnyCallLeavesNothingTorn) {
  options_.sync_bytes = 50'000;
  const std::string big(90'000, 'b');  // one sync on the way
  int faults = 0;
  for (const int error : {ENOSPC, EIO, EDQUOT, 0 /* short write */}) {
    for (int nth = 1;; ++nth) {
      fs::remove_all(folder_);
      FaultFiles files;
      options_.files = &files;
      auto store = Open(1 << 20);
      ASSERT_OK(store->Put(StoreKind::kBlob, digest_, bytes_));
      Cut(*store, big, 5);
      files.FailAt(nth, error);
      absl::Status status = Finish(*store, big, 5);
      if (status.ok()) status = store->Put(StoreKind::kScene, Sha256Hex("s"), "s");
      if (!files.has_failed()) {
        EXPECT_OK(status);
        break;
      }
      ++faults;
      if (!status.ok()) {
        const bool is_full = error == ENOSPC || error == EDQUOT;
        EXPECT_EQ(status.code(), is_full ? absl::StatusCode::kResourceExhausted : absl::StatusCode::kInternal)
            << nth << " " << status;
      }
      for (const bool is_restarted : {false, true}) {
        if (is_restarted) {
          store.reset();
          store = Open(1 << 20);
        }
        EXPECT_EQ(*store->Get(StoreKind::kBlob, digest_), bytes_);
        uint64_t on_disk = 0;
        for (const auto& entry : fs::recursive_directory_iterator(folder_)) {
          if (entry.is_regular_file()) on_disk += entry.file_size();
        }
        EXPECT_EQ(store->size_bytes(), on_disk) << nth;
        const Store::Progress progress = store->Query(Sha256Hex(big));
        if (progress.is_complete) {
          EXPECT_EQ(*store->Get(StoreKind::kBlob, Sha256Hex(big)), big);
        } else if (progress.committed_bytes > 0) {
          EXPECT_EQ(Read(folder_ / "incoming" / Sha256Hex(big)), big.substr(0, progress.committed_bytes)) << nth;
        }
      }
      const uint64_t committed = store->Query(Sha256Hex(big)).committed_bytes;
      const absl::Status again = Finish(*store, big, committed);
      EXPECT_TRUE(again.ok() || absl::IsAlreadyExists(again)) << again;
      EXPECT_OK(store->Put(StoreKind::kScene, Sha256Hex("s"), "s"));
      EXPECT_EQ(*store->Get(StoreKind::kBlob, Sha256Hex(big)), big);
      EXPECT_EQ(store->size_bytes(), bytes_.size() + big.size() + 1);
    }
  }
  EXPECT_GE(faults, 40) << "the seam must be on the way";
}

TEST_F(StoreTest, AReadThatFailsIsNoDamage) {
  FaultFiles files;
  options_.files = &files;
  const auto store = Open();
  ASSERT_OK(store->Put(StoreKind::kBlob, digest_, bytes_));
  for (const int nth : {1, 2}) {  // open, read
    files.FailAt(nth, EIO);
    EXPECT_THAT(store->Get(StoreKind::kBlob, digest_), StatusIs(absl::StatusCode::kInternal, HasSubstr(digest_)));
    EXPECT_EQ(*store->Get(StoreKind::kBlob, digest_), bytes_);
  }
}

TEST_F(StoreTest, ATemporaryStoreGoesWithItsOwner) {
  // A place for temporary files of its own: other tests have stores in the common one.
  const fs::path place = fs::path(testing::TempDir()) / ("temporary_store_" + std::to_string(getpid()));
  fs::create_directory(place);
  setenv("TMPDIR", place.c_str(), 1);
  {
    auto store = Store::Open("", StoreOptions{100});
    ASSERT_OK(store);
    ASSERT_OK((*store)->Put(StoreKind::kBlob, digest_, bytes_));
    EXPECT_FALSE(fs::is_empty(place));
  }
  EXPECT_TRUE(fs::is_empty(place));
  unsetenv("TMPDIR");
  fs::remove_all(place);
}

TEST_F(StoreTest, RemovedIsGone) {
  const auto store = Open();
  ASSERT_OK(store->Put(StoreKind::kScene, digest_, bytes_));
  EXPECT_OK(store->Remove(StoreKind::kScene, {digest_}));
  EXPECT_THAT(store->Get(StoreKind::kScene, digest_), StatusIs(absl::StatusCode::kNotFound, Not(HasSubstr("damaged"))));
  EXPECT_TRUE(store->List(StoreKind::kScene).empty());
}

// Light data: under a key that is not its digest, replaced by what comes later, and first to go.
class LightDataInStoreTest : public StoreTest {
 protected:
  static std::string Key(int i) { return Sha256Hex("key " + std::to_string(i)); }
};

TEST_F(LightDataInStoreTest, StandsUnderAnyKeyIsReplacedAndOutlivesARestart) {
  {
    const auto store = Open();
    ASSERT_OK(store->Put(StoreKind::kDerived, Key(0), "first"));
    ASSERT_OK(store->Put(StoreKind::kDerived, Key(0), "second one"));
    EXPECT_EQ(store->size_bytes(), 10u);
  }
  const auto store = Open();
  EXPECT_EQ(*store->Get(StoreKind::kDerived, Key(0)), "second one");
  EXPECT_EQ(store->size_bytes(), 10u);
  ASSERT_OK(store->Remove(StoreKind::kDerived, {Key(0)}));
  EXPECT_EQ(store->size_bytes(), 0u);
  EXPECT_EQ(store->Get(StoreKind::kDerived, Key(0)).status().code(), absl::StatusCode::kNotFound);
}

TEST_F(LightDataInStoreTest, TheLongestUntouchedGoesForOthersAndForBlobs) {
  const auto store = Open(100);
  for (int i = 0; i < 3; ++i) ASSERT_OK(store->Put(StoreKind::kDerived, Key(i), std::string(30, 'a')));
  ASSERT_OK(store->Get(StoreKind::kDerived, Key(0)));
  ASSERT_OK(store->Put(StoreKind::kDerived, Key(3), std::string(30, 'b')));
  EXPECT_FALSE(store->Has(StoreKind::kDerived, Key(1)));
  for (const int i : {0, 2, 3}) EXPECT_TRUE(store->Has(StoreKind::kDerived, Key(i))) << i;
  const std::string blob(45, 'x');
  ASSERT_OK(store->Put(StoreKind::kBlob, Sha256Hex(blob), blob));
  EXPECT_FALSE(store->Has(StoreKind::kDerived, Key(2)));
  EXPECT_FALSE(store->Has(StoreKind::kDerived, Key(0)));
  EXPECT_TRUE(store->Has(StoreKind::kDerived, Key(3)));
  EXPECT_EQ(store->size_bytes(), 75u);
}

TEST_F(LightDataInStoreTest, TakesNoRoomFromBlobsOrUploadsUnderWay) {
  const auto store = Open(100);
  ASSERT_OK(store->Put(StoreKind::kBlob, digest_, bytes_));
  const std::string cut(60, 'y');
  Cut(*store, cut, 40);
  EXPECT_OK(store->Put(StoreKind::kDerived, Key(0), std::string(50, 'a')));
  EXPECT_EQ(store->Put(StoreKind::kDerived, Key(1), std::string(51, 'a')).code(), absl::StatusCode::kResourceExhausted);
  EXPECT_TRUE(store->Has(StoreKind::kBlob, digest_));
  EXPECT_EQ(store->Query(Sha256Hex(cut)).committed_bytes, 40u);
  EXPECT_TRUE(store->Has(StoreKind::kDerived, Key(0))) << "nothing goes where that is not enough";
}

TEST_F(LightDataInStoreTest, OneThatIsShorterThanItWasIsDataLoss) {
  const auto store = Open();
  ASSERT_OK(store->Put(StoreKind::kDerived, Key(0), "some light data"));
  fs::resize_file(folder_ / "derived" / Key(0), 4);
  EXPECT_EQ(store->Get(StoreKind::kDerived, Key(0)).status().code(), absl::StatusCode::kDataLoss);
  EXPECT_FALSE(store->Has(StoreKind::kDerived, Key(0)));
}

}  // namespace
}  // namespace halfshade
