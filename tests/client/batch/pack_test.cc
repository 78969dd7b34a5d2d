#include "client/batch/pack.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "client/batch/item_store.h"
#include "server/digest.h"
#include "tests/client/temporary_folder.h"
#include "tests/support/status_matchers.h"

namespace halfshade {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

// A frame of 700 bytes.
void Store(const TemporaryFolder& folder, const std::string& id) {
  BatchLine line{id, {}};
  line.request.set_scene("scenes/" + std::string(64, '0'));
  v1::RenderResponse response;
  response.add_images()->set_data(std::string(700, id[0]));
  response.mutable_report()->add_outputs();
  ASSERT_OK(StoreItem(folder / "out", line, response));
}

std::string LinesOf(const std::string& command) {
  std::string text;
  FILE* pipe = popen(command.c_str(), "r");
  for (int c; (c = std::fgetc(pipe)) != EOF;) text += char(c);
  EXPECT_EQ(pclose(pipe), 0) << command;
  return text;
}

class PackTest : public testing::Test {
 protected:
  PackTest() {
    fs::create_directories(folder_ / "out");
    fs::create_directories(folder_ / "tar");
    for (const char* id : {"c", "a", "b"}) Store(folder_, id);
  }
  absl::StatusOr<Packed> Pack(uint64_t max_bytes) { return PackItems(folder_ / "out", folder_ / "tar", max_bytes); }
  const TemporaryFolder folder_;
};

TEST_F(PackTest, TarReadsWhatTheFolderHolds) {
  const auto packed = Pack(1 << 20);
  ASSERT_OK(packed);
  EXPECT_EQ(packed->items, 3u);
  EXPECT_EQ(packed->shards, 1u);
  const std::string tar = folder_ / "tar/shard-000000.tar";
  EXPECT_EQ(LinesOf("tar tf " + tar), "a.frame.png\na.json\nb.frame.png\nb.json\nc.frame.png\nc.json\n");
  EXPECT_EQ(LinesOf("tar xOf " + tar + " b.frame.png"), std::string(700, 'b'));
  EXPECT_EQ(LinesOf("tar xOf " + tar + " b.json"), ReadManifest(folder_ / "out")->at("b").text + "\n");
  const std::string bytes = ReadAll(tar);
  ASSERT_OK(Pack(1 << 20));
  EXPECT_EQ(ReadAll(tar), bytes) << "the same items make the same file";
}

TEST_F(PackTest, AShardEndsBeforeItsLimitAndAlwaysHasAnItem) {
  const auto member_bytes = [](size_t bytes) { return 512 + (bytes + 511) / 512 * 512; };
  const uint64_t item_bytes = member_bytes(700) + member_bytes(ReadManifest(folder_ / "out")->at("a").text.size() + 1);
  EXPECT_EQ(Pack(2 * item_bytes + TarEnd().size())->shards, 2u);
  EXPECT_EQ(fs::file_size(folder_ / "tar/shard-000000.tar"), 2 * item_bytes + TarEnd().size());
  EXPECT_EQ(Pack(2 * item_bytes + TarEnd().size() - 1)->shards, 3u);
  EXPECT_EQ(Pack(1)->shards, 3u);
  EXPECT_EQ(LinesOf("tar tf " + (folder_ / "tar/shard-000002.tar")), "c.frame.png\nc.json\n");
}

TEST_F(PackTest, PacksOnlyWhatHasItsDigest) {
  folder_.Write("out/b.frame.png", std::string(700, 'x'));
  EXPECT_THAT(Pack(1 << 20), StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("b.frame.png: is not what")));
  EXPECT_TRUE(fs::is_empty(folder_ / "tar"));
  const std::string secret = "secret";
  folder_.Write("secret", secret);
  folder_.Write("out/manifest.jsonl", R"({"id":"a","requestSha256":"","files":[{"name":"../secret","sha256":")" +
                                          Sha256Hex(secret) + "\"}]}\n");
  EXPECT_THAT(Pack(1 << 20), StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("../secret: is not what")));
  fs::remove(folder_ / "out/manifest.jsonl");
  EXPECT_THAT(Pack(1 << 20), StatusIs(absl::StatusCode::kNotFound, HasSubstr("manifest.jsonl")));
}

TEST(TarMemberTest, TakesTheLongestNameOfAnItem) {
  const TemporaryFolder folder;
  const std::string name = std::string(kMaxIdLength, 'i') + ".soft_shadow_map.exr";
  ASSERT_LE(name.size(), 100u);
  folder.Write("x.tar", TarMember(name, "") + TarMember("e", std::string(512, 'e')) + TarEnd());
  EXPECT_EQ(LinesOf("tar tf " + (folder / "x.tar")), name + "\ne\n");
}

}  // namespace
}  // namespace halfshade
