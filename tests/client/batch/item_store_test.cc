#include "client/batch/item_store.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <thread>

#include "client/batch/request_digest.h"
#include "client/exit_code.h"
#include "client/output_file.h"
#include "server/digest.h"
#include "tests/client/temporary_folder.h"
#include "tests/server/fault_files.h"
#include "tests/support/status_matchers.h"

namespace halfshade {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;

std::vector<std::string> NamesIn(const fs::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder)) names.push_back(entry.path().filename());
  std::sort(names.begin(), names.end());
  return names;
}

BatchLine LineOf(const std::string& id) {
  BatchLine line{id, {}};
  line.request.set_scene("scenes/" + std::string(64, '0'));
  line.request.set_width(uint32_t(id[0]));
  line.request.add_outputs();
  line.request.add_outputs()->set_kind(v1::OUTPUT_KIND_VISIBILITY);
  return line;
}

v1::RenderResponse ResponseOf(const std::string& id) {
  v1::RenderResponse response;
  for (const char* kind : {"FRAME", "VISIBILITY"}) {
    v1::OutputImage* image = response.add_images();
    image->set_data(id + " " + kind + std::string(1000, '.'));
    v1::OutputKind value{};
    EXPECT_TRUE(v1::OutputKind_Parse(std::string("OUTPUT_KIND_") + kind, &value));
    image->set_kind(value);
    image->set_encoding(v1::ENCODING_PNG);
    response.mutable_report()->add_outputs()->set_pixel_sha256(Sha256Hex(image->data()));
  }
  response.mutable_report()->set_content_key("key of " + id);
  return response;
}

absl::Status Store(const TemporaryFolder& folder, const std::string& id, FileOperations* files = SystemFiles()) {
  return StoreItem(folder.path(), LineOf(id), ResponseOf(id), files);
}

// Every line in the manifest is of an item that is whole.
void ExpectTruthful(const TemporaryFolder& folder) {
  const auto manifest = ReadManifest(folder.path());
  ASSERT_OK(manifest);
  for (const auto& [id, line] : *manifest) {
    EXPECT_TRUE(IsWhole(folder.path(), line, RequestDigest(LineOf(id).request))) << id;
  }
}

void ExpectWhole(const TemporaryFolder& folder, const std::vector<std::string>& ids) {
  ExpectTruthful(folder);
  std::vector<std::string> names = {"manifest.jsonl"}, in_manifest;
  for (const std::string& id : ids) {
    names.push_back(id + ".frame.png");
    names.push_back(id + ".visibility.png");
  }
  std::sort(names.begin(), names.end());
  EXPECT_EQ(NamesIn(folder.path()), names);
  const auto manifest = ReadManifest(folder.path());
  ASSERT_OK(manifest);
  for (const auto& [id, line] : *manifest) in_manifest.push_back(id);
  EXPECT_EQ(in_manifest, ids);
}

TEST(ItemStoreTest, ALineTellsIdFilesDigestsContentKeyAndReport) {
  const TemporaryFolder folder;
  ASSERT_OK(Store(folder, "a"));
  ASSERT_OK(Store(folder, "b"));
  ExpectWhole(folder, {"a", "b"});
  const std::string text = ReadAll(folder / "manifest.jsonl");
  const auto line = nlohmann::json::parse(text.substr(0, text.find('\n')));
  EXPECT_EQ(line["id"], "a");
  EXPECT_EQ(line["files"][1]["name"], "a.visibility.png");
  EXPECT_EQ(line["files"][1]["sha256"], Sha256Hex(ReadAll(folder / "a.visibility.png")));
  EXPECT_EQ(line["files"][1]["bytes"], ReadAll(folder / "a.visibility.png").size());
  EXPECT_EQ(line["outputs"][1]["file"], "a.visibility.png");
  EXPECT_EQ(line["outputs"][1]["kind"], "VISIBILITY");
  EXPECT_EQ(line["outputs"][1]["pixelSha256"], Sha256Hex(ResponseOf("a").images(1).data()));
  EXPECT_EQ(line["contentKey"], "key of a");
  EXPECT_EQ(line["report"]["contentKey"], "key of a");
}

TEST(ItemStoreTest, TrustsDigestsAlone) {
  const TemporaryFolder folder;
  ASSERT_OK(Store(folder, "a"));
  const ManifestLine line = ReadManifest(folder.path())->at("a");
  const std::string request = RequestDigest(LineOf("a").request), frame = ReadAll(folder / "a.frame.png");
  EXPECT_TRUE(IsWhole(folder.path(), line, request));
  EXPECT_FALSE(IsWhole(folder.path(), line, RequestDigest(LineOf("b").request))) << "of another request";
  std::string flipped = frame;
  flipped[500] = 'x';
  folder.Write("a.frame.png", flipped);
  EXPECT_FALSE(IsWhole(folder.path(), line, request)) << "the same length, one byte off";
  folder.Write("a.frame.png", frame);
  EXPECT_TRUE(IsWhole(folder.path(), line, request));
  fs::remove(folder / "a.frame.png");
  EXPECT_FALSE(IsWhole(folder.path(), line, request));
}

TEST(ItemStoreTest, ALineThatIsTornAtAnyByteIsNeitherReadNorInTheWay) {
  const TemporaryFolder folder;
  ASSERT_OK(Store(folder, "a"));
  const std::string first = ReadAll(folder / "manifest.jsonl");
  ASSERT_OK(Store(folder, "b"));
  const std::string both = ReadAll(folder / "manifest.jsonl");
  for (size_t size = first.size(); size < both.size(); ++size) {
    folder.Write("manifest.jsonl", both.substr(0, size));
    const auto manifest = ReadManifest(folder.path());
    ASSERT_OK(manifest);
    ASSERT_EQ(manifest->size(), 1u) << size;
    if (size % 16 != 0) continue;  // writing to disk takes its time
    ASSERT_OK(Store(folder, "b"));
    ASSERT_EQ(ReadAll(folder / "manifest.jsonl"), both) << size;
    folder.Write("manifest.jsonl", both.substr(0, size));
    ASSERT_OK(CleanUp(folder.path(), {"b"}, {}));
    ASSERT_EQ(ReadAll(folder / "manifest.jsonl"), first) << size;
  }
}

// After the nth file operation failed: what the manifest has is whole, nothing is left over, and the item can be
// stored.
void ExpectSoundAfterEveryFault(int error, const std::string& first) {
  int faults = 0;
  for (int nth = 1;; ++nth) {
    const TemporaryFolder folder;
    if (!first.empty()) {
      ASSERT_OK(Store(folder, first));
    }
    FaultFiles files;
    files.FailAt(nth, error);
    const absl::Status status = Store(folder, "b", &files);
    if (!files.has_failed()) {
      ASSERT_OK(status);
      break;
    }
    ++faults;
    EXPECT_EQ(ExitCodeOf(status), kExitCannotWrite) << nth;
    ExpectTruthful(folder);
    for (const std::string& name : NamesIn(folder.path())) EXPECT_EQ(TargetOfTemporary(name), "") << nth;
    ASSERT_OK(Store(folder, "b"));
    if (first.empty()) {
      ExpectWhole(folder, {"b"});
    } else {
      ExpectWhole(folder, {first, "b"});
    }
  }
  // open, write, sync and rename of two files, the folder's and the manifest's open, and syncs.
  EXPECT_GE(faults, error == 0 ? 3 : 12);
}

TEST(ItemStoreTest, AFullDiskAtAnyCallLeavesOnlyWholeItems) { ExpectSoundAfterEveryFault(ENOSPC, "a"); }
TEST(ItemStoreTest, AnIoErrorAtAnyCallLeavesOnlyWholeItems) { ExpectSoundAfterEveryFault(EIO, "a"); }
TEST(ItemStoreTest, AFaultAtTheFirstItemLeavesOnlyWholeItems) { ExpectSoundAfterEveryFault(ENOSPC, ""); }

TEST(ItemStoreTest, AWriteThatFallsShortIsGoneOnWithOrUndone) {
  int failed = 0, went_on = 0;
  for (int nth = 2; nth <= 7; ++nth) {
    const TemporaryFolder folder;
    ASSERT_OK(Store(folder, "a"));
    FaultFiles files;
    files.FailAt(nth, 0);
    const absl::Status status = Store(folder, "b", &files);
    (status.ok() ? went_on : failed) += 1;
    ExpectTruthful(folder);
    ASSERT_OK(Store(folder, "b"));
    ExpectWhole(folder, {"a", "b"});
  }
  EXPECT_GT(failed, 0);
  EXPECT_GT(went_on, 0);
}

TEST(ItemStoreTest, CleanUpTakesOwnLeftoversAndNothingElse) {
  const TemporaryFolder folder;
  for (const char* id : {"a", "b", "c"}) ASSERT_OK(Store(folder, id));
  folder.Write(".a.frame.png.0123456789abcdef.part", "x");
  folder.Write(".z.frame.png.0123456789abcdef.part", "another batch is writing");
  folder.Write(".a.frame.png.0123.part", "no name of ours");
  folder.Write("manifest.jsonl", "garbage\n" + ReadAll(folder / "manifest.jsonl") + "{\"id\":\"to");
  ASSERT_OK(CleanUp(folder.path(), {"a", "b"}, {"b"}));
  const auto manifest = ReadManifest(folder.path());
  ASSERT_OK(manifest);
  EXPECT_EQ(manifest->size(), 2u);
  EXPECT_TRUE(manifest->contains("b") && manifest->contains("c"));
  EXPECT_EQ(ReadAll(folder / "manifest.jsonl"), manifest->at("b").text + "\n" + manifest->at("c").text + "\n");
  EXPECT_FALSE(fs::exists(folder / ".a.frame.png.0123456789abcdef.part"));
  EXPECT_TRUE(fs::exists(folder / ".z.frame.png.0123456789abcdef.part"));
  EXPECT_TRUE(fs::exists(folder / ".a.frame.png.0123.part"));
}

TEST(ItemStoreTest, AFaultInCleanUpLeavesTheOldManifestOrTheNew) {
  for (int nth = 1;; ++nth) {
    const TemporaryFolder folder;
    for (const char* id : {"a", "b"}) ASSERT_OK(Store(folder, id));
    const std::string before = ReadAll(folder / "manifest.jsonl");
    FaultFiles files;
    files.FailAt(nth, ENOSPC);
    const absl::Status status = CleanUp(folder.path(), {"a", "b"}, {"b"}, &files);
    const std::string after = ReadAll(folder / "manifest.jsonl");
    EXPECT_TRUE(after == before || after == ReadManifest(folder.path())->at("b").text + "\n") << nth;
    for (const std::string& name : NamesIn(folder.path())) EXPECT_EQ(TargetOfTemporary(name), "") << nth;
    if (!files.has_failed()) {
      EXPECT_OK(status);
      EXPECT_GT(nth, 6);
      break;
    }
    EXPECT_EQ(ExitCodeOf(status), kExitCannotWrite) << nth;
  }
}

TEST(ItemStoreTest, ManyMayWriteWhileOneCleansUp) {
  const TemporaryFolder folder;
  ASSERT_OK(Store(folder, "a"));
  std::vector<std::thread> threads;
  for (char id = 'b'; id <= 'g'; ++id) {
    threads.emplace_back([&folder, id] {
      for (int i = 0; i < 2; ++i) EXPECT_OK(Store(folder, std::string(1, id)));
    });
  }
  threads.emplace_back([&] {
    for (int i = 0; i < 20; ++i) EXPECT_OK(CleanUp(folder.path(), {"none"}, {}));
  });
  for (std::thread& thread : threads) thread.join();
  ExpectWhole(folder, {"a", "b", "c", "d", "e", "f", "g"});
}

TEST(ItemStoreTest, AResponseThatDoesNotFitIsNoItem) {
  const TemporaryFolder folder;
  v1::RenderResponse response = ResponseOf("a");
  response.mutable_images()->RemoveLast();
  EXPECT_THAT(StoreItem(folder.path(), LineOf("a"), response),
              StatusIs(absl::StatusCode::kInternal, "the server sent 1 images, not 2"));
  EXPECT_THAT(NamesIn(folder.path()), ElementsAre());
}

}  // namespace
}  // namespace halfshade
