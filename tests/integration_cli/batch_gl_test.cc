// `halfshade batch`, run as a user does: whole items whatever is killed, shards, failures.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <random>
#include <sstream>
#include <thread>

#include "client/glb_writer.h"
#include "server/digest.h"
#include "tests/client/temporary_folder.h"
#include "tests/integration_cli/process.h"

namespace halfshade {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::HasSubstr;

// A plate over a floor, `height_m` above it.
std::string PlateOverFloor(float height_m) {
  auto quad = [](const std::string& name, float half, float y) {
    GlbMesh mesh;
    mesh.name = name;
    mesh.positions = {{-half, y, -half}, {-half, y, half}, {half, y, half}, {half, y, -half}};
    mesh.indices = {0, 1, 2, 0, 2, 3};
    return mesh;
  };
  return WriteGlb({quad("floor", 4, 0), quad("plate", 0.5f, height_m)});
}

// Of the n-th camera on a circle and the n-th kind of light.
json LineOf(int n, int scenes) {
  const double angle = 0.37 * n;
  return {
      {"id", "item-" + std::to_string(n)},
      {"scene", "scene" + std::to_string(n % scenes) + ".glb"},
      {"width", 160},
      {"height", 96},
      {"camera",
       {{"lookAt",
         {{"eye", {{"x", 5 * std::cos(angle)}, {"y", 4}, {"z", 5 * std::sin(angle)}}}, {"target", {{"y", 0.1}}}}}}},
      {"lights",
       {{{"center", {{"y", 4}}}, {"edgeU", {{"x", 1 + n % 2}}}, {"edgeV", {{"z", 1}}}, {"direction", {{"y", -1}}}}}},
      {"method", {{"ray", {{"rays", 64}}}}},
      {"outputs", {{{"kind", "OUTPUT_KIND_VISIBILITY"}}, {{"kind", "OUTPUT_KIND_FRAME"}}}}};
}

class BatchCommandTest : public testing::Test {
 protected:
  void WriteScenes(int scenes) {
    for (int i = 0; i < scenes; ++i) {
      folder_.Write("scene" + std::to_string(i) + ".glb", PlateOverFloor(0.5f + 0.25f * float(i)));
    }
  }
  std::string WriteLines(int items, int scenes) {
    std::string text;
    for (int n = 0; n < items; ++n) text += LineOf(n, scenes).dump() + "\n";
    folder_.Write("requests.jsonl", text);
    return text;
  }
  Ran Run(const std::vector<std::string>& arguments) { return RunHalfshade(arguments, folder_.path()); }

  std::vector<json> Manifest(const std::string& out) const {
    std::vector<json> lines;
    std::istringstream text(ReadAll(folder_ / (out + "/manifest.jsonl")));
    for (std::string line; std::getline(text, line);) lines.push_back(json::parse(line, nullptr, false));
    return lines;
  }
  // id -> pixel digests; every file is there as its line says, no item stands twice, and nothing else is in the folder.
  std::map<std::string, std::string> WholeItems(const std::string& out) const {
    std::map<std::string, std::string> digests;
    size_t files = 1;
    for (const json& line : Manifest(out)) {
      if (!line.is_object()) {
        ADD_FAILURE() << "a torn line";
        continue;
      }
      std::string& digest = digests[line["id"]];
      EXPECT_EQ(digest, "") << line["id"] << " stands twice";
      for (const json& output : line["outputs"]) digest += std::string(output["pixelSha256"]) + " ";
      for (const json& file : line["files"]) {
        EXPECT_EQ(Sha256Hex(ReadAll(folder_ / (out + "/" + std::string(file["name"])))), file["sha256"]);
        ++files;
      }
    }
    EXPECT_EQ(size_t(std::distance(fs::directory_iterator(folder_ / out), fs::directory_iterator())), files);
    return digests;
  }
  const TemporaryFolder folder_;
};

TEST_F(BatchCommandTest, TenKillsOfClientAndServerInTurnLeaveWhatAnUnbrokenRunDoes) {
  constexpr int kItems = 100, kScenes = 4, kKills = 10;
  WriteScenes(kScenes);
  WriteLines(kItems, kScenes);
  ASSERT_EQ(Run({"batch", "requests.jsonl", "-o", "unbroken"}).exit_code, 0);
  const auto unbroken = WholeItems("unbroken");
  ASSERT_EQ(unbroken.size(), size_t(kItems));

  std::mt19937 random(20250202);
  auto server = std::make_unique<ServerProcess>(std::vector<std::string>{"--log-level", "off"});
  const std::string address = server->address();
  const std::vector<std::string> batch = {"batch", "requests.jsonl", "-o",       "out",  "--jobs",
                                          "3",     "--resume",       "--server", address};
  auto client = std::make_unique<ClientProcess>(batch, folder_.path().string());
  std::map<std::string, fs::file_time_type> written;  // items that a manifest told, and when
  size_t finished = 0;                                // lines when the last kill was over
  for (int kill = 0; kill < kKills; ++kill) {
    while (client->IsAlive() && Manifest("out").size() <= finished) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    ASSERT_TRUE(client->IsAlive()) << "the batch was too short for kill " << kill;
    std::this_thread::sleep_for(std::chrono::microseconds(std::uniform_int_distribution(0, 20'000)(random)));
    if (kill % 2 == 0) {
      client->Kill();
      client = std::make_unique<ClientProcess>(batch, folder_.path().string());
    } else {
      server->Kill();  // with its scenes: the client brings them again
      server = std::make_unique<ServerProcess>(std::vector<std::string>{"--listen", address, "--log-level", "off"});
      ASSERT_EQ(server->address(), address);
    }
    for (const json& line : Manifest("out")) {
      if (!line.is_object()) continue;  // its end is on its way
      const std::string id = line["id"];
      written.try_emplace(id, fs::last_write_time(folder_ / ("out/" + id + ".frame.png")));
    }
    finished = Manifest("out").size();
  }
  EXPECT_EQ(client->Wait(), 0) << "a server that comes back ends no batch";
  EXPECT_EQ(WholeItems("out"), unbroken);
  EXPECT_GE(written.size(), size_t(kKills));
  for (const auto& [id, time] : written) {
    EXPECT_EQ(fs::last_write_time(folder_ / ("out/" + id + ".frame.png")), time) << id << " was rendered again";
  }
}

TEST_F(BatchCommandTest, AResumedRunTrustsDigestsAlone) {
  WriteScenes(2);
  WriteLines(6, 2);
  ASSERT_EQ(Run({"batch", "requests.jsonl", "-o", "out"}).exit_code, 0);
  const auto before = WholeItems("out");
  const Ran again = Run({"batch", "requests.jsonl", "-o", "out"});
  EXPECT_EQ(again.exit_code, 64);
  EXPECT_THAT(again.err, HasSubstr("--resume"));
  folder_.Write("out/item-1.frame.png", "torn");
  fs::remove(folder_ / "out/item-2.visibility.png");
  folder_.Write("out/.item-3.frame.png.0123456789abcdef.part", "left by a kill");
  folder_.Write("out/manifest.jsonl", ReadAll(folder_ / "out/manifest.jsonl") + R"({"id":"item-)");
  const Ran resumed = Run({"batch", "requests.jsonl", "-o", "out", "--resume", "--json"});
  ASSERT_EQ(resumed.exit_code, 0) << resumed.err;
  EXPECT_EQ(json::parse(resumed.out)["rendered"], 2);
  EXPECT_EQ(json::parse(resumed.out)["wholeBefore"], 4);
  EXPECT_EQ(WholeItems("out"), before);
  // A line that asks for something else now is another item.
  json changed = LineOf(0, 2);
  changed["width"] = 80;
  folder_.Write("requests.jsonl", changed.dump() + "\n");
  const Ran of_changed = Run({"batch", "requests.jsonl", "-o", "out", "--resume", "--json"});
  EXPECT_EQ(json::parse(of_changed.out)["rendered"], 1);
  const auto after = WholeItems("out");
  EXPECT_EQ(after.size(), 6u);
  EXPECT_NE(after.at("item-0"), before.at("item-0"));
  EXPECT_EQ(after.at("item-1"), before.at("item-1"));
}

TEST_F(BatchCommandTest, ShardsInOneFolderAtATimeMakeTheWhole) {
  WriteScenes(3);
  WriteLines(10, 3);
  ASSERT_EQ(Run({"batch", "requests.jsonl", "-o", "whole"}).exit_code, 0);
  const ServerProcess server({"--log-level", "off"});
  std::vector<std::unique_ptr<ClientProcess>> clients;
  for (const char* shard : {"0/3", "1/3", "2/3"}) {
    const std::vector<std::string> batch = {"batch",    "requests.jsonl", "-o", "out", "--shard", shard,
                                            "--server", server.address()};
    clients.push_back(std::make_unique<ClientProcess>(batch, folder_.path().string()));
  }
  for (const auto& client : clients) EXPECT_EQ(client->Wait(), 0);
  EXPECT_EQ(WholeItems("out"), WholeItems("whole"));
}

TEST_F(BatchCommandTest, OneItemsFailureIsItsOwn) {
  WriteScenes(1);
  json wide = LineOf(0, 1), missing = LineOf(1, 1), good = LineOf(2, 1);
  wide["width"] = 9000;
  missing["scene"] = "none.glb";
  const std::string lines = wide.dump() + "\nnope\n" + missing.dump() + "\n\n" + good.dump() + "\n";
  folder_.Write("requests.jsonl", lines);
  const Ran refused = Run({"batch", "requests.jsonl", "-o", "out"});
  EXPECT_EQ(refused.exit_code, 65);
  EXPECT_THAT(refused.err, HasSubstr("line 2: is not a JSON object"));
  EXPECT_FALSE(fs::exists(folder_ / "out")) << "nothing is begun with a file that has bad lines";
  const Ran ran = Run({"batch", "requests.jsonl", "-o", "out", "--keep-going", "--json"});
  EXPECT_EQ(ran.exit_code, 65) << "of the first failure";
  EXPECT_THAT(ran.err, HasSubstr("line 1 (item-0): width: 9000; must be 1 to 8192"));
  EXPECT_THAT(ran.err, HasSubstr("line 3 (item-1): "));
  const json summary = json::parse(ran.out);
  EXPECT_EQ(summary["rendered"], 1);
  EXPECT_EQ(summary["failures"].size(), 3u);
  EXPECT_EQ(WholeItems("out").count("item-2"), 1u);
  // Without --keep-going nothing is begun after a failure.
  folder_.Write("requests.jsonl", wide.dump() + "\n" + good.dump() + "\n" + LineOf(3, 1).dump() + "\n");
  const Ran stopped = Run({"batch", "requests.jsonl", "-o", "stopped", "--jobs", "1"});
  EXPECT_EQ(stopped.exit_code, 65);
  EXPECT_LE(Manifest("stopped").size(), 2u);
  EXPECT_THAT(stopped.err, HasSubstr("1 failed"));
}

TEST_F(BatchCommandTest, AServerThatIsGoneEndsARunThatKeepsGoing) {
  WriteScenes(1);
  WriteLines(5, 1);
  std::string address;
  {
    const ServerProcess server({"--log-level", "off"});
    address = server.address();
  }
  const Ran ran = Run({"batch", "requests.jsonl", "-o", "out", "--jobs", "1", "--keep-going", "--server", address});
  EXPECT_EQ(ran.exit_code, 69) << ran.err;
  EXPECT_THAT(ran.err, HasSubstr("1 failed, 4 not begun"));
}

TEST_F(BatchCommandTest, WhatSampleWritesBatchRenders) {
  WriteScenes(2);
  folder_.Write("template.json", R"({
    "id": "s", "scene": {"$choice": ["scene0.glb", "scene1.glb"]}, "width": 32, "height": 32,
    "camera": {"lookAt": {"eye": {"$hemisphere": {"target": [0, 0, 0], "radius": [5, 8], "elevation_deg": [20, 80]}},
                          "target": {"y": 0}}},
    "lights": [{"$light": {"target": [0, 0, 0], "radius": [3, 6], "elevation_deg": [50, 90],
                           "width_m": [0.2, 2], "height_m": [0.2, 2]}}],
    "method": {"$choice": [{"shaft": {}}, {"pcss": {}}, {"ray": {"rays": {"$integer": [1, 32]}}}]}})");
  const Ran sampled = Run({"sample", "template.json", "--count", "12", "--seed", "3"});
  ASSERT_EQ(sampled.exit_code, 0) << sampled.err;
  EXPECT_EQ(sampled.out, Run({"sample", "template.json", "--count", "12", "--seed", "3"}).out);
  const std::string beginning = Run({"sample", "template.json", "--count", "7", "--seed", "3"}).out;
  EXPECT_EQ(sampled.out.substr(0, beginning.size()), beginning);
  folder_.Write("elsewhere/requests.jsonl", sampled.out);
  const Ran ran = Run({"batch", "elsewhere/requests.jsonl", "-o", "out"});
  EXPECT_EQ(ran.exit_code, 0) << ran.err;
  EXPECT_EQ(WholeItems("out").size(), 12u);
}

TEST_F(BatchCommandTest, EveryKindComesFromOneRequestAndTheManifestsCameraProjectsIt) {
  WriteScenes(1);
  json line = LineOf(3, 1);
  line["method"] = {{"pcss", json::object()}};
  line["outputs"] = json::array();
  for (const char* kind : {"FRAME", "VISIBILITY", "SOFT_SHADOW_MAP", "DEPTH", "NORMAL", "ALBEDO", "OBJECT_ID",
                           "POSITION", "PENUMBRA_WIDTH"}) {
    line["outputs"].push_back({{"kind", std::string("OUTPUT_KIND_") + kind}, {"encoding", "ENCODING_RAW_F32"}});
  }
  for (const char* kind : {"DEPTH", "NORMAL", "VISIBILITY"}) {
    line["outputs"].push_back({{"kind", std::string("OUTPUT_KIND_") + kind},
                               {"encoding", "ENCODING_EXR_FLOAT"},
                               {"layer", std::string("of_") + kind}});
  }
  folder_.Write("requests.jsonl", line.dump() + "\n");
  const Ran ran = Run({"batch", "requests.jsonl", "-o", "out"});
  ASSERT_EQ(ran.exit_code, 0) << ran.err;
  ASSERT_EQ(WholeItems("out").size(), 1u);
  const json item = Manifest("out")[0];
  EXPECT_EQ(item["files"].size(), 10u);
  EXPECT_EQ(item["outputs"][11]["file"], "item-3.layers.exr");
  const std::string exr = ReadAll(folder_ / "out/item-3.layers.exr");
  for (const char* channel : {"of_DEPTH.Z", "of_NORMAL.x", "of_VISIBILITY.0"}) EXPECT_THAT(exr, HasSubstr(channel));
  int gbuffers = 0;
  for (const json& pass : item["report"]["passes"]) {
    gbuffers += std::string(pass["name"]).find("gbuffer") != std::string::npos && !pass["skipped"];
  }
  EXPECT_EQ(gbuffers, 1);

  const auto floats = [&](const std::string& kind) {
    const std::string bytes = ReadAll(folder_ / ("out/item-3." + kind + ".f32"));
    std::vector<float> values(bytes.size() / sizeof(float));
    std::memcpy(values.data(), bytes.data(), values.size() * sizeof(float));
    return values;
  };
  const std::vector<float> position = floats("position"), depth = floats("depth"), id = floats("object_id");
  const auto view = item["camera"]["cameraFromWorld"].get<std::vector<double>>();
  const auto pixel = item["camera"]["pixelFromCamera"].get<std::vector<double>>();
  int seen = 0;
  for (int i = 0; i < 160 * 96; ++i) {
    if (id[size_t(i)] == 0) continue;
    ++seen;
    double p[3];
    for (int row = 0; row < 3; ++row) {
      p[row] = view[size_t(12 + row)];
      for (int k = 0; k < 3; ++k) p[row] += view[size_t(4 * k + row)] * position[size_t(3 * i + k)];
    }
    ASSERT_NEAR(p[2], depth[size_t(i)], 1e-5 * p[2]);
    ASSERT_NEAR(pixel[0] * p[0] / p[2] + pixel[6], i % 160 + 0.5, 1e-3);
    ASSERT_NEAR(pixel[4] * p[1] / p[2] + pixel[7], i / 160 + 0.5, 1e-3);
  }
  EXPECT_GT(seen, 1000);
  const Ran packed = Run({"pack", "out", "-o", "tars", "--json"});
  EXPECT_EQ(packed.exit_code, 0) << packed.err;
  EXPECT_EQ(json::parse(packed.out), json({{"items", 1}, {"shards", 1}}));
  EXPECT_EQ(Run({"pack", "out", "-o", "tars"}).exit_code, 64) << "never among older ones";
  for (const char* mb : {"0", "4097"}) {
    EXPECT_EQ(Run({"pack", "out", "-o", "more", "--shard-mb", mb}).exit_code, 64) << mb;
  }
  EXPECT_EQ(Run({"pack", "out", "-o", "more", "--shard-mb", "4096"}).exit_code, 0);
}

TEST_F(BatchCommandTest, FlagsOutOfRangeAreUsage) {
  WriteScenes(1);
  WriteLines(1, 1);
  for (const char* jobs : {"0", "257"}) {
    EXPECT_EQ(Run({"batch", "requests.jsonl", "-o", "out", "--jobs", jobs}).exit_code, 64) << jobs;
  }
  EXPECT_EQ(Run({"batch", "requests.jsonl", "-o", "out", "--shard", "1/1"}).exit_code, 64);
  EXPECT_EQ(Run({"batch", "none.jsonl", "-o", "out"}).exit_code, 66);
  folder_.Write("file", "");
  EXPECT_EQ(Run({"batch", "requests.jsonl", "-o", "file"}).exit_code, 74);
  EXPECT_EQ(Run({"batch", "requests.jsonl", "-o", "out", "--jobs", "256"}).exit_code, 0);
}

}  // namespace
}  // namespace halfshade
