// Mixed load for a long time: all methods, bad input, cancelled calls, deadlines, scenes that come and go. Nothing
// dies, every picture has the bytes that it had at first, and nothing grows. HALFSHADE_SOAK_SECONDS says how long; 8
// unless set.
#include <gmock/gmock.h>
#include <grpcpp/create_channel.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <mutex>
#include <random>
#include <thread>

#include "client/bench/cases.h"
#include "client/client.h"
#include "halfshade/v1/scene.grpc.pb.h"
#include "server/digest.h"
#include "server/log.h"
#include "server/scene_name.h"
#include "server/server.h"
#include "tests/stress/leak_gate.h"
#include "tests/support/flat_scene_builder.h"
#include "tests/support/process_memory.h"
#include "tests/support/status_matchers.h"

namespace halfshade {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

constexpr int kClients = 4;

double OpenFiles() {
  const std::filesystem::directory_iterator files("/proc/self/fd");
  return double(std::distance(begin(files), end(files)));
}

// Every method, with small maps: llvmpipe holds those that it drew into last for as long as it pleases (a part of its
// ring of scenes), which would be more than what leaks.
std::vector<v1::Method> Methods() {
  constexpr int kMapSize = 256;
  std::vector<v1::Method> methods(9);
  methods[0].mutable_hard()->set_map_size(kMapSize);
  methods[1].mutable_multi_map()->set_map_size(kMapSize);
  methods[1].mutable_multi_map()->set_k(16);
  methods[2].mutable_ray()->set_rays(64);
  methods[3].mutable_pcss()->set_map_size(kMapSize);
  methods[4].mutable_ssm()->set_occluder_map_size(kMapSize);
  methods[5].mutable_pdsm()->set_map_size(kMapSize);
  methods[6].mutable_sssm()->set_map_size(kMapSize);
  methods[7].mutable_shaft();
  methods[8].mutable_auto_();
  return methods;
}

struct Good {
  SceneFiles files;
  v1::RenderRequest request;
  std::string digest;  // of its pixels, as first drawn
};

struct Bad {
  v1::RenderRequest request;
  grpc::StatusCode code;
  std::string says;
};

class SoakTest : public testing::Test {
 protected:
  static void SetUpTestSuite() { SetUpLog("off", false); }
  void SetUp() override {
    ServerOptions options;
    options.listen = "127.0.0.1:0";
    options.contexts = 2;
    options.scene_cache_mb = options.gl_scene_mb = options.light_cache_mb = options.view_cache_mb = 16;
    options.result_cache_mb = 1;
    auto server = Server::Start(options);
    ASSERT_OK(server);
    server_ = *std::move(server);
    const auto first = Connect();
    Client& client = *first;
    for (const char* scene : {"S1", "S2", "S3", "S4", "S5", "S6"}) {
      const bench::Case made = bench::MakeCase({.scene = scene, .triangles = 2000, .width = 96, .height = 54});
      ASSERT_OK(client.UploadScene(made.files));
      for (const v1::Method& method : Methods()) {
        Good good{made.files, made.request, ""};
        *good.request.mutable_method() = method;
        good.request.add_outputs()->set_kind(v1::OUTPUT_KIND_FRAME);
        auto response = client.Render(good.request, nullptr);
        ASSERT_OK(response) << scene << " " << method.ShortDebugString();
        good.digest = response->report().outputs(0).pixel_sha256();
        good_.push_back(std::move(good));
      }
    }
    MakeBad();
  }

  void MakeBad() {
    const auto add = [this](grpc::StatusCode code, const char* says, auto change) {
      Bad bad{good_[0].request, code, says};
      change(bad.request);
      bad_.push_back(std::move(bad));
    };
    add(grpc::StatusCode::INVALID_ARGUMENT, "width", [](auto& request) { request.set_width(100'000); });
    add(grpc::StatusCode::INVALID_ARGUMENT, "rays",
        [](auto& request) { request.mutable_method()->mutable_ray()->set_rays(1u << 30); });
    add(grpc::StatusCode::INVALID_ARGUMENT, "lights[0].edge_u",
        [](auto& request) { request.mutable_lights(0)->mutable_edge_u()->set_x(NAN); });
    add(grpc::StatusCode::INVALID_ARGUMENT, "node_overrides[0]",
        [](auto& request) { request.add_node_overrides()->set_index(1u << 20); });
    add(grpc::StatusCode::NOT_FOUND, "scenes/",
        [](auto& request) { request.set_scene("scenes/" + std::string(64, '0')); });
  }

  std::shared_ptr<Client> Connect() {
    ClientOptions options;
    options.servers = {server_->grpc_address()};
    options.is_timeout_per_call = true;
    auto client = Client::Connect(options);
    EXPECT_OK(client);
    return *std::move(client);
  }

  // A connection's calls until `end`.
  void Drive(int number, Clock::time_point end) {
    const std::shared_ptr<Client> client = Connect();
    grpc::ChannelArguments own;
    own.SetInt("client", number);
    const auto channel = grpc::CreateCustomChannel(server_->grpc_address(), grpc::InsecureChannelCredentials(), own);
    const auto renders = v1::RenderService::NewStub(channel);
    const auto scenes = v1::SceneService::NewStub(channel);
    std::mt19937 random{unsigned(number)};
    std::map<std::string, int> counts;
    while (Clock::now() < end) {
      const Good& good = good_[random() % good_.size()];
      v1::RenderRequest request = good.request;
      if (random() % 2 == 0) request.set_cache(v1::CACHE_MODE_REFRESH);
      const auto kind = random() % 100;
      grpc::ClientContext context;
      v1::RenderResponse response;
      if (kind < 10) {
        const Bad& bad = bad_[random() % bad_.size()];
        const grpc::Status status = renders->Render(&context, bad.request, &response);
        EXPECT_EQ(status.error_code(), bad.code) << status.error_message();
        EXPECT_THAT(status.error_message(), testing::HasSubstr(bad.says));
        ++counts["bad"];
      } else if (kind < 20) {
        std::thread later([&] {
          std::this_thread::sleep_for(std::chrono::microseconds(random() % 20'000));
          context.TryCancel();
        });
        const grpc::Status status = renders->Render(&context, request, &response);
        later.join();
        EXPECT_TRUE(status.ok() || status.error_code() == grpc::StatusCode::CANCELLED) << status.error_message();
        ++counts["cancelled"];
      } else if (kind < 25) {
        context.set_deadline(std::chrono::system_clock::now() + std::chrono::milliseconds(1 + random() % 20));
        const grpc::Status status = renders->Render(&context, request, &response);
        EXPECT_TRUE(status.ok() || status.error_code() == grpc::StatusCode::DEADLINE_EXCEEDED ||
                    status.error_code() == grpc::StatusCode::RESOURCE_EXHAUSTED)
            << status.error_message();
        ++counts["late"];
      } else if (kind < 30) {
        // A scene that nobody saw before, and its end.
        const float height = 0.5f + float(random() >> 8) / float(1 << 24);
        SceneFiles files = good.files;
        files.root.bytes = WriteGlb({MakePlate({0, 0, 0}, 4, 4), MakePlate({0, height, 0}, 1, 1)});
        files.root.digest = Sha256Hex(files.root.bytes);
        files.name = SceneName(files.root.digest, {});
        request.set_scene(files.name);
        EXPECT_OK(client->Render(request, &files));
        v1::DeleteSceneRequest remove;
        remove.set_name(files.name);
        v1::DeleteSceneResponse removed;
        const grpc::Status status = scenes->DeleteScene(&context, remove, &removed);
        EXPECT_TRUE(status.ok()) << status.error_message();
        ++counts["scenes"];
      } else {
        const auto rendered = client->Render(request, nullptr);
        EXPECT_OK(rendered);
        if (rendered.ok()) {
          EXPECT_EQ(rendered->report().outputs(0).pixel_sha256(), good.digest) << request.ShortDebugString();
        }
        ++counts["good"];
      }
    }
    const std::lock_guard lock(mutex_);
    for (const auto& [kind, count] : counts) counts_[kind] += count;
  }

  struct Samples {
    std::vector<SoakSample> resident_mb, files;
  };
  // In rounds: what is held is sampled between them, when nothing is under way.
  Samples Soak(double seconds) {
    const int rounds = std::clamp(int(seconds / 4), 12, 200);
    Samples samples;
    const auto begin = Clock::now();
    for (int round = 1; round <= rounds; ++round) {
      const auto end =
          begin + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds * round / rounds));
      std::vector<std::thread> clients;
      for (int i = 0; i < kClients; ++i) clients.emplace_back([=, this] { Drive(round * kClients + i, end); });
      for (std::thread& client : clients) client.join();
      std::this_thread::sleep_for(50ms);  // connections and what was cancelled end
      const double time_s = std::chrono::duration<double>(Clock::now() - begin).count();
      if (leak_bytes_ > 0) leaked_.emplace_back(leak_bytes_, 'x');
      PurgeFreedMemory();  // what the allocator keeps for later is no leak
      samples.resident_mb.push_back({time_s, ResidentMb()});
      samples.files.push_back({time_s, OpenFiles()});
    }
    return samples;
  }

  std::unique_ptr<Server> server_;
  std::vector<Good> good_;
  std::vector<Bad> bad_;
  size_t leak_bytes_ = 0;  // in each round: the gate must see it
  std::mutex mutex_;
  std::vector<std::string> leaked_;
  std::map<std::string, int> counts_;
};

// What a soak cannot tell from a leak: some 10 MB that come and go, over the time between the halves that are compared.
double MemoryBound(double seconds) { return 1 + 10 * 3600 / (seconds / 3); }

TEST_F(SoakTest, MixedLoadKillsNothingChangesNoBitAndGrowsNothing) {
  const char* const asked = std::getenv("HALFSHADE_SOAK_SECONDS");
  const double seconds = asked != nullptr ? std::atof(asked) : 12;
  const Samples samples = Soak(seconds);
  const double memory = GrowthPerHour(samples.resident_mb), files = GrowthPerHour(samples.files);
  std::printf("%.0f s:", seconds);
  for (const auto& [kind, count] : counts_) std::printf(" %d %s,", count, kind.c_str());
  std::printf(" memory %.0f MB, %+.1f MB/h; %.0f files, %+.0f/h\n", samples.resident_mb.back().value, memory,
              samples.files.back().value, files);
  EXPECT_EQ(counts_.size(), 5u) << "every kind of call came";
  EXPECT_LT(memory, MemoryBound(seconds));
  EXPECT_LE(files, 0);
}

TEST_F(SoakTest, TheGateSeesAPlantedLeak) {
  leak_bytes_ = 10 << 20;  // four rounds a second: four times the bound, however few calls a round has
  const Samples samples = Soak(3);
  EXPECT_GT(GrowthPerHour(samples.resident_mb), MemoryBound(3));
}

}  // namespace
}  // namespace halfshade
