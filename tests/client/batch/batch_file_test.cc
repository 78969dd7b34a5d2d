#include "client/batch/batch_file.h"

#include <gtest/gtest.h>

#include <map>
#include <set>

#include "client/exit_code.h"
#include "tests/client/temporary_folder.h"
#include "tests/support/status_matchers.h"

namespace halfshade {
namespace {

using absl::StatusCode;
using testing::ElementsAre;
using testing::HasSubstr;

std::string MessageOf(const std::string& text) {
  const auto line = ReadBatchLine(text, "/folder");
  return line.ok() ? "OK" : std::string(line.status().message());
}

TEST(BatchLineTest, IsARequestAndAnId) {
  const auto line =
      ReadBatchLine(R"({"id": "a-B_9", "scene": "s/x.glb", "width": 64, "lights": [{"twoSided": true}]})", "/folder");
  ASSERT_OK(line);
  EXPECT_EQ(line->id, "a-B_9");
  EXPECT_EQ(line->request.scene(), "/folder/s/x.glb");
  EXPECT_EQ(line->request.width(), 64u);
  EXPECT_TRUE(line->request.lights(0).two_sided());
  const std::string name = "scenes/" + std::string(64, 'a');
  const auto named = ReadBatchLine(R"({"id":"a","scene":")" + name + "\"}", "/folder");
  ASSERT_OK(named);
  EXPECT_EQ(named->request.scene(), name);
  EXPECT_EQ(ReadBatchLine(R"({"id":"a","scene":"/x.glb"})", "/folder")->request.scene(), "/x.glb");
}

TEST(BatchLineTest, NamesTheFieldAtFault) {
  EXPECT_EQ(MessageOf("nope"), "is not a JSON object");
  EXPECT_EQ(MessageOf("[]"), "is not a JSON object");
  EXPECT_EQ(MessageOf(R"({"id":"a","scene":"x")"), "is not a JSON object");
  EXPECT_EQ(MessageOf(R"({"scene":"x"})"), "id: missing");
  EXPECT_EQ(MessageOf(R"({"id":7,"scene":"x"})"), "id: must be a string");
  EXPECT_EQ(MessageOf(R"({"id":"a"})"), "scene: missing");
  EXPECT_THAT(MessageOf(R"({"id":"a","scene":"x","with":1})"), HasSubstr("with"));
  EXPECT_THAT(MessageOf(R"({"id":"a","scene":"x","camera":{"lookAt":{"eye":{"w":1}}}})"),
              HasSubstr("camera.look_at.eye"));
  EXPECT_THAT(MessageOf(R"({"id":"a","scene":"x","width":"wide"})"), HasSubstr("width"));
}

TEST(BatchLineTest, AnIdIsAFileNameOnEverySystemAndInEveryTar) {
  for (const char* bad : {"", "a/b", "..", "a.b", "a b", "\\u0000", "\\u00e9"}) {
    EXPECT_THAT(MessageOf(std::string(R"({"scene":"x","id":")") + bad + "\"}"), HasSubstr("must be 1 to 80 of A-Z"))
        << bad;
  }
  const auto of_length = [](size_t length) {
    return MessageOf(R"({"scene":"x","id":")" + std::string(length, 'a') + "\"}");
  };
  EXPECT_EQ(of_length(kMaxIdLength), "OK");
  EXPECT_THAT(of_length(kMaxIdLength + 1), HasSubstr("id: 'aaa"));
}

TEST(BatchLineTest, RefusesWhatIsNestedTooDeepForARecursiveReader) {
  const auto nested = [](int depth) {
    return R"({"id":"a","scene":"x","y":)" + std::string(size_t(depth), '[') + std::string(size_t(depth), ']') + "}";
  };
  EXPECT_THAT(MessageOf(nested(98)), HasSubstr("Cannot find field"));
  EXPECT_EQ(MessageOf(nested(200'000)), "nested deeper than 100");
}

TEST(ItemFileNamesTest, NameIdKindAndEncoding) {
  BatchLine line{"i", {}};
  EXPECT_THAT(*ItemFileNames(line), ElementsAre("i.frame.png"));
  const auto add = [&](v1::OutputKind kind, v1::Encoding encoding, const std::string& layer = "") {
    v1::Output* output = line.request.add_outputs();
    output->set_kind(kind);
    output->set_encoding(encoding);
    output->set_layer(layer);
  };
  add(v1::OUTPUT_KIND_UNSPECIFIED, v1::ENCODING_UNSPECIFIED);
  add(v1::OUTPUT_KIND_VISIBILITY, v1::ENCODING_EXR_HALF, "v");
  add(v1::OUTPUT_KIND_DEPTH, v1::ENCODING_RAW_F32);
  add(v1::OUTPUT_KIND_DEPTH, v1::ENCODING_EXR_FLOAT, "z");
  add(v1::OUTPUT_KIND_PENUMBRA_WIDTH, v1::ENCODING_TIFF);
  add(v1::OUTPUT_KIND_ALBEDO, v1::ENCODING_JPEG);
  add(v1::OUTPUT_KIND_SOFT_SHADOW_MAP, v1::ENCODING_RAW_F16);
  EXPECT_THAT(*ItemFileNames(line), ElementsAre("i.frame.png", "i.layers.exr", "i.depth.f32", "",
                                                "i.penumbra_width.tif", "i.albedo.jpg", "i.soft_shadow_map.f16"));
  add(v1::OUTPUT_KIND_FRAME, v1::ENCODING_PNG);
  EXPECT_THAT(ItemFileNames(line), StatusIs(StatusCode::kInvalidArgument,
                                            "outputs[7]: its file would be i.frame.png, as that of outputs[0]"));
}

TEST(ItemFileNamesTest, NameTheOutputThatHasNone) {
  BatchLine line{"i", {}};
  line.request.add_outputs()->set_kind(v1::OutputKind(99));
  EXPECT_THAT(ItemFileNames(line), StatusIs(StatusCode::kInvalidArgument, "outputs[0].kind: 99; no such kind"));
  line.request.mutable_outputs(0)->set_kind(v1::OUTPUT_KIND_FRAME);
  line.request.mutable_outputs(0)->set_encoding(v1::Encoding(99));
  EXPECT_THAT(ItemFileNames(line), StatusIs(StatusCode::kInvalidArgument, "outputs[0].encoding: 99; no such encoding"));
}

std::string Line(const std::string& id, const std::string& scene, int light) {
  return R"({"id":")" + id + R"(","scene":")" + scene + R"(","seed":)" + std::to_string(light) + "}\n";
}

TEST(BatchFileTest, OrdersByWhatAServerCachesAndNamesBadLines) {
  const TemporaryFolder folder;
  const std::string path = folder.Write(
      "r.jsonl", Line("a", "y", 1) + Line("b", "x", 2) + "\n  \r\n" + Line("c", "y", 2) + "{}\n" + Line("d", "x", 3) +
                     Line("e", "x", 2) + Line("a", "z", 1) + R"({"id":"f","scene":"x","seed":3})");
  const auto batch = ReadBatchFile(path);
  ASSERT_OK(batch);
  ASSERT_EQ(batch->items.size(), 6u);
  std::map<std::string, const BatchItem*> items;
  std::vector<std::string> runs;  // of one scene and light
  for (const BatchItem& item : batch->items) {
    items[item.id] = &item;
    const std::string run = item.scene + std::to_string(item.light_key);
    if (runs.empty() || runs.back() != run) runs.push_back(run);
    EXPECT_EQ(ReadBatchLine(batch->TextOf(item), batch->folder)->id, item.id);
  }
  EXPECT_EQ(std::set<std::string>(runs.begin(), runs.end()).size(), runs.size()) << "nothing is come back to";
  EXPECT_EQ(runs.size(), 4u);
  EXPECT_EQ(items["b"]->light_key, items["e"]->light_key);
  EXPECT_NE(items["b"]->light_key, items["d"]->light_key);
  EXPECT_EQ(items["f"]->line, 10u) << "the last line needs no end";
  EXPECT_EQ(items["a"]->scene, folder / "y");
  ASSERT_EQ(batch->failures.size(), 2u);
  EXPECT_EQ(batch->failures[0].line, 6u);
  EXPECT_THAT(batch->failures[0].status, StatusIs(StatusCode::kInvalidArgument, "id: missing"));
  EXPECT_EQ(batch->failures[1].line, 9u);
  EXPECT_THAT(batch->failures[1].status, StatusIs(StatusCode::kInvalidArgument, "id: a; line 1 has it too"));
  EXPECT_THAT(ReadBatchFile(folder / "none"), StatusIs(StatusCode::kNotFound, HasSubstr("none")));
}

TEST(ShardTest, ReadsItsForm) {
  for (const char* bad : {"", "1", "1/", "/2", "2/2", "-1/2", "0/0", "0/2 ", "a/b", "0/1000001"}) {
    EXPECT_EQ(ExitCodeOf(ReadShard(bad).status()), kExitUsage) << bad;
  }
  const auto shard = ReadShard("999999/1000000");
  ASSERT_OK(shard);
  EXPECT_EQ(shard->index, 999'999u);
  EXPECT_EQ(shard->count, 1'000'000u);
}

TEST(ShardTest, ShardsAreDisjointCompleteAndEven) {
  for (const size_t size : {0, 1, 7, 100}) {
    std::vector<BatchItem> items(size);
    for (size_t i = 0; i < size; ++i) items[i].line = i;
    for (const size_t count : {1, 2, 3, 8, 101}) {
      std::vector<size_t> lines;
      for (size_t index = 0; index < count; ++index) {
        const std::vector<BatchItem> of_shard = ItemsOf({index, count}, items);
        EXPECT_LE(of_shard.size(), size / count + 1);
        EXPECT_GE(of_shard.size(), size / count);
        for (const BatchItem& item : of_shard) lines.push_back(item.line);
      }
      ASSERT_EQ(lines.size(), size);
      for (size_t i = 0; i < size; ++i) EXPECT_EQ(lines[i], i);
    }
  }
}

}  // namespace
}  // namespace halfshade
