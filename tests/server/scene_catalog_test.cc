// Scenes that are made, deleted and loaded at the same time, and what becomes of their blobs.
#include "server/scene_catalog.h"

#include <gtest/gtest.h>

#include <condition_variable>
#include <filesystem>
#include <fstream>
#include <thread>

#include "client/glb_writer.h"
#include "server/digest.h"
#include "server/scene_name.h"
#include "tests/client/temporary_folder.h"
#include "tests/support/flat_scene_builder.h"
#include "tests/support/status_matchers.h"

namespace halfshade {
namespace {

using testing::HasSubstr;

// Holds whoever opens one file until it is let go.
class GateFiles : public FileOperations {
 public:
  void Hold(const std::string& end_of_path) {
    const std::lock_guard lock(mutex_);
    held_ = end_of_path;
  }
  void LetGo() {
    const std::lock_guard lock(mutex_);
    held_ = "";
    changed_.notify_all();
  }
  void WaitUntilSomeoneWaits() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return waiting_ > 0; });
  }
  int Open(const std::string& path, int flags, mode_t mode) override {
    {
      std::unique_lock lock(mutex_);
      if (!held_.empty() && path.ends_with(held_)) {
        ++waiting_;
        changed_.notify_all();
        changed_.wait(lock, [this] { return held_.empty(); });
        --waiting_;
      }
    }
    return FileOperations::Open(path, flags, mode);
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::string held_;
  int waiting_ = 0;
};

class SceneCatalogTest : public testing::Test {
 protected:
  void SetUp() override { Open(); }
  void Open() {
    catalog_.reset();
    cache_ = std::make_unique<SceneCache>(64 << 20);
    store_.reset();
    StoreOptions options{64 << 20};
    options.files = &files_;
    auto store = Store::Open(folder_.path(), options);
    ASSERT_OK(store);
    store_ = *std::move(store);
    auto catalog = SceneCatalog::Open(store_.get(), cache_.get(), limits_);
    ASSERT_OK(catalog);
    catalog_ = *std::move(catalog);
  }
  std::string Put(const std::string& bytes) {
    const std::string digest = Sha256Hex(bytes);
    EXPECT_OK(store_->Put(StoreKind::kBlob, digest, bytes));
    return digest;
  }
  bool HasBlob(const std::string& digest) const { return store_->Has(StoreKind::kBlob, digest); }
  absl::Status Create(const std::string& root, const std::map<std::string, std::string>& files = {},
                      bool validate_only = false) {
    v1::CreateSceneRequest request;
    request.set_root_digest(root);
    for (const auto& [uri, digest] : files) (*request.mutable_files())[uri] = digest;
    request.set_validate_only(validate_only);
    return catalog_->Create(request).status();
  }
  absl::Status Load(const std::string& name) {
    double load_ms = 0;
    return catalog_->Load(name, &load_ms).status();
  }
  void Damage(const std::string& file) const {
    ASSERT_TRUE(std::filesystem::exists(folder_ / file));
    std::ofstream(folder_ / file) << "damaged";
  }

  const TemporaryFolder folder_;
  GateFiles files_;
  Limits limits_;
  std::unique_ptr<Store> store_;
  std::unique_ptr<SceneCache> cache_;
  std::unique_ptr<SceneCatalog> catalog_;
  const std::string plate_ = WriteGlb({MakePlate({0, 0, 0}, 1, 1)});
  const std::string other_ = WriteGlb({MakePlate({0, 1, 0}, 2, 1)});
  const std::string extra_ = std::string(5000, 'x');  // more than the scenes take in memory
};

TEST_F(SceneCatalogTest, DeleteFreesTheBlobsThatNoOtherSceneUsesAlsoAfterARestart) {
  const std::string plate = Put(plate_), other = Put(other_), extra = Put(extra_), loose = Put("no scene's");
  ASSERT_OK(Create(plate, {{"x", extra}}));
  ASSERT_OK(Create(plate, {{"x", extra}}));
  ASSERT_OK(Create(other, {{"x", extra}}));
  Open();
  ASSERT_OK(catalog_->Delete(SceneName(plate, {{"x", extra}})));
  EXPECT_FALSE(HasBlob(plate));
  EXPECT_TRUE(HasBlob(extra));
  EXPECT_OK(Load(SceneName(other, {{"x", extra}})));
  ASSERT_OK(catalog_->Delete(SceneName(other, {{"x", extra}})));
  EXPECT_FALSE(HasBlob(extra));
  EXPECT_TRUE(HasBlob(loose)) << "an upload whose scene is still to come";
  EXPECT_EQ(store_->size_bytes(), std::string("no scene's").size());
  EXPECT_THAT(catalog_->Delete(SceneName(other, {{"x", extra}})),
              StatusIs(absl::StatusCode::kNotFound, HasSubstr("is not here")));
}

TEST_F(SceneCatalogTest, ASceneThatLoadsForLongHoldsUpNobodyElse) {
  const std::string plate = Put(plate_), other = Put(other_), third = Put(WriteGlb({MakePlate({0, 2, 0}, 1, 3)}));
  ASSERT_OK(Create(other));
  files_.Hold("blobs/" + plate);
  std::thread slow([&] { EXPECT_OK(Create(plate)); });
  files_.WaitUntilSomeoneWaits();
  EXPECT_OK(Create(third));
  EXPECT_OK(catalog_->Delete(SceneName(other, {})));
  EXPECT_OK(Load(SceneName(third, {})));
  EXPECT_THAT(Load(SceneName(plate, {})), StatusIs(absl::StatusCode::kNotFound, HasSubstr("create it")));
  files_.LetGo();
  slow.join();
  EXPECT_OK(Load(SceneName(plate, {})));
}

TEST_F(SceneCatalogTest, BlobsOfACreateUnderWayStayAndGoWhenItFails) {
  for (const bool succeeds : {true, false}) {
    const std::string first = Put(plate_), extra = Put(extra_);
    const std::string root = Put(succeeds ? other_ : "no glTF");
    ASSERT_OK(Create(first, {{"x", extra}}));
    files_.Hold("blobs/" + root);
    std::thread slow([&] { EXPECT_EQ(Create(root, {{"x", extra}}).ok(), succeeds); });
    files_.WaitUntilSomeoneWaits();
    ASSERT_OK(catalog_->Delete(SceneName(first, {{"x", extra}})));
    EXPECT_FALSE(HasBlob(first));
    EXPECT_TRUE(HasBlob(extra)) << "another one is about to read it";
    files_.LetGo();
    slow.join();
    EXPECT_EQ(HasBlob(extra), succeeds);
    EXPECT_TRUE(HasBlob(root)) << "an upload like any other";
    EXPECT_EQ(catalog_->Delete(SceneName(root, {{"x", extra}})).ok(), succeeds);
  }
}

TEST_F(SceneCatalogTest, ASceneThatIsDeletedWhileItIsMadeAgainIsThereOrNotNeverHalf) {
  const std::string name = SceneName(Sha256Hex(plate_), {});
  for (int i = 0; i < 30; ++i) {
    const std::string plate = Put(plate_);
    ASSERT_OK(Create(plate));
    absl::Status created;
    std::thread make([&] { created = Create(plate); });
    std::thread remove([&] { EXPECT_OK(catalog_->Delete(name)); });
    make.join();
    remove.join();
    EXPECT_TRUE(created.ok() || absl::IsNotFound(created)) << created;
    cache_->Forget(name);
    const absl::Status loaded = Load(name);
    EXPECT_EQ(loaded.ok(), catalog_->Has(name)) << loaded;
    EXPECT_TRUE(!catalog_->Has(name) || HasBlob(plate));
  }
}

TEST_F(SceneCatalogTest, ADamagedBlobIsNotFoundAndTheSceneIsWellWhenItIsUploadedAgain) {
  const std::string plate = Put(plate_);
  const std::string name = SceneName(plate, {});
  ASSERT_OK(Create(plate));
  Damage("blobs/" + plate);
  Open();
  EXPECT_THAT(Load(name), StatusIs(absl::StatusCode::kNotFound, HasSubstr(plate + " was damaged")));
  EXPECT_THAT(Create(plate), StatusIs(absl::StatusCode::kNotFound, HasSubstr(plate + " is not here; upload it")));
  Put(plate_);
  EXPECT_OK(Load(name));
}

TEST_F(SceneCatalogTest, ADamagedManifestIsNoSceneAndIsMadeAgain) {
  const std::string plate = Put(plate_), other = Put(other_);
  const std::string name = SceneName(plate, {});
  ASSERT_OK(Create(plate));
  ASSERT_OK(Create(other));
  Damage(name);
  Open();
  EXPECT_EQ(catalog_->List("", 9), std::vector<std::string>{SceneName(other, {})});
  EXPECT_THAT(Load(name), StatusIs(absl::StatusCode::kNotFound, HasSubstr("create it")));
  EXPECT_OK(Create(plate));
  EXPECT_OK(catalog_->Delete(name));
  EXPECT_FALSE(HasBlob(plate));
}

TEST_F(SceneCatalogTest, ACachedSceneWhoseBlobIsGoneIsNotAcknowledged) {
  const std::string plate = Put(plate_);
  ASSERT_OK(Create(plate));
  ASSERT_OK(store_->Remove(StoreKind::kBlob, {plate}));
  EXPECT_THAT(Create(plate), StatusIs(absl::StatusCode::kNotFound, HasSubstr(plate)));
}

TEST_F(SceneCatalogTest, ValidateOnlyKeepsNothing) {
  const std::string plate = Put(plate_);
  EXPECT_OK(Create(plate, {}, true));
  EXPECT_FALSE(catalog_->Has(SceneName(plate, {})));
  EXPECT_EQ(cache_->counters().bytes, 0u);
}

TEST_F(SceneCatalogTest, BlobsOverTheScenesBoundAreNotEvenRead) {
  const std::string plate = Put(plate_), extra = Put(extra_);
  limits_.scene_bytes = plate_.size() + extra_.size() - 1;
  Open();
  files_.Hold("blobs/" + plate);  // reading it would wait for ever
  EXPECT_THAT(Create(plate, {{"x", extra}}),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("/: " + std::to_string(plate_.size() + extra_.size()) +
                                 " bytes with all files; at most " + std::to_string(limits_.scene_bytes))));
  files_.LetGo();
  ++limits_.scene_bytes;
  Open();
  EXPECT_OK(Create(plate, {{"x", extra}}));
}

}  // namespace
}  // namespace halfshade
