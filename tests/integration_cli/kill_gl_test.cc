// `halfshaded` is killed at random instants of uploads, creates and renders: whatever it acknowledged is there after
// its restart, nothing is torn, and nothing is left over but what can be gone on with.
#include <grpcpp/create_channel.h>
#include <gtest/gtest.h>

#include <atomic>
#include <filesystem>
#include <map>
#include <mutex>
#include <random>
#include <set>
#include <thread>

#include "client/glb_writer.h"
#include "halfshade/v1/render.grpc.pb.h"
#include "halfshade/v1/scene.grpc.pb.h"
#include "server/digest.h"
#include "tests/client/temporary_folder.h"
#include "tests/integration_cli/process.h"

namespace halfshade {
namespace {

namespace fs = std::filesystem;

// A strip of quads, no two seeds alike; some 60 kB to 2 MB.
std::string StripGlb(uint32_t seed) {
  const uint32_t quads = 1000 + seed * 7919 % 30'000;
  GlbMesh mesh;
  for (uint32_t i = 0; i <= quads; ++i) {
    const float x = float(i) / float(quads), y = float(seed);
    mesh.positions.push_back({x, y, 0});
    mesh.positions.push_back({x, y, 1});
  }
  for (uint32_t i = 0; i < quads; ++i) {
    for (const uint32_t corner : {0u, 1u, 2u, 2u, 1u, 3u}) mesh.indices.push_back(2 * i + corner);
  }
  return WriteGlb({mesh});
}

// A client that remembers what the server said it has.
class Client {
 public:
  void Connect(const std::string& address) {
    const auto channel = grpc::CreateChannel(address, grpc::InsecureChannelCredentials());
    scenes_ = v1::SceneService::NewStub(channel);
    renders_ = v1::RenderService::NewStub(channel);
  }

  v1::QueryUploadResponse Query(const std::string& digest) {
    grpc::ClientContext context;
    v1::QueryUploadRequest request;
    request.set_digest(digest);
    v1::QueryUploadResponse response;
    scenes_->QueryUpload(&context, request, &response);
    return response;
  }

  // From where the server says it is.
  bool Upload(const std::string& bytes, const std::string& digest, size_t chunk) {
    {
      const std::lock_guard lock(mutex_);
      begun_[digest] = bytes;
    }
    const v1::QueryUploadResponse begun = Query(digest);
    if (begun.complete()) return true;
    uint64_t offset = begun.committed_bytes();
    resumed_bytes += offset;
    grpc::ClientContext context;
    v1::UploadBlobResponse response;
    const auto writer = scenes_->UploadBlob(&context, &response);
    do {
      v1::UploadBlobRequest request;
      request.set_digest(digest);
      request.set_size_bytes(bytes.size());
      request.set_offset_bytes(offset);
      request.set_data(bytes.substr(offset, chunk));
      if (!writer->Write(request)) break;
      offset += request.data().size();
    } while (offset < bytes.size());
    writer->WritesDone();
    if (!writer->Finish().ok()) return false;
    const std::lock_guard lock(mutex_);
    blobs_.insert(digest);
    return true;
  }

  bool Create(const std::string& digest, std::string* name) {
    grpc::ClientContext context;
    v1::CreateSceneRequest request;
    request.set_root_digest(digest);
    v1::CreateSceneResponse response;
    if (!scenes_->CreateScene(&context, request, &response).ok()) return false;
    *name = response.scene().name();
    const std::lock_guard lock(mutex_);
    created_.insert(*name);
    return true;
  }

  grpc::Status Render(const std::string& name) {
    grpc::ClientContext context;
    v1::RenderRequest request;
    request.set_scene(name);
    request.set_width(64);
    request.set_height(64);
    v1::RenderResponse response;
    return renders_->Render(&context, request, &response);
  }

  // Uploads, makes and renders scenes until the server is gone.
  void Work(uint32_t first_seed) {
    for (uint32_t seed = first_seed;; ++seed) {
      const std::string glb = StripGlb(seed), digest = Sha256Hex(glb);
      std::string name;
      if (!Upload(glb, digest, 64 << 10) || !Create(digest, &name) || !Render(name).ok()) return;
    }
  }

  // The restarted server against what the one before said, and its folder against both.
  void Check(const std::string& folder) {
    grpc::ClientContext context;
    v1::FindMissingBlobsRequest request;
    for (const std::string& digest : blobs_) request.add_digests(digest);
    v1::FindMissingBlobsResponse missing;
    ASSERT_TRUE(scenes_->FindMissingBlobs(&context, request, &missing).ok());
    EXPECT_EQ(missing.missing_digests_size(), 0) << missing.ShortDebugString();
    for (const std::string& name : created_) {
      grpc::ClientContext get_context;
      v1::GetSceneRequest get;
      get.set_name(name);
      v1::GetSceneResponse response;
      const grpc::Status status = scenes_->GetScene(&get_context, get, &response);
      EXPECT_TRUE(status.ok()) << name << " " << status.error_message();
    }
    for (const char* kind : {"blobs", "scenes"}) {
      for (const auto& entry : fs::directory_iterator(fs::path(folder) / kind)) {
        EXPECT_EQ(Sha256Hex(ReadAll(entry.path())), entry.path().filename()) << "torn";
      }
    }
    for (const auto& entry : fs::directory_iterator(fs::path(folder) / "incoming")) {
      const std::string digest = entry.path().filename(), held = ReadAll(entry.path());
      ASSERT_TRUE(begun_.contains(digest)) << digest << " cannot be gone on with";
      EXPECT_EQ(held, begun_[digest].substr(0, held.size())) << "torn";
      EXPECT_EQ(Query(digest).committed_bytes(), held.size());
    }
  }

  size_t blobs() const { return blobs_.size(); }
  const std::set<std::string>& created() const { return created_; }
  std::atomic<uint64_t> resumed_bytes{0};

 private:
  std::unique_ptr<v1::SceneService::Stub> scenes_;
  std::unique_ptr<v1::RenderService::Stub> renders_;
  std::mutex mutex_;
  std::set<std::string> blobs_, created_;
  std::map<std::string, std::string> begun_;  // digest -> bytes
};

TEST(KillTest, WhatWasAcknowledgedIsThereAfterTwentyKillsAtRandomInstants) {
  constexpr uint32_t kSeed = 20250101;
  constexpr int kKills = 20;
  std::mt19937 random(kSeed);
  const TemporaryFolder folder;
  Client client;
  // Larger than can be sent between two kills: goes on over several of them.
  std::string large(200 << 20, 0);
  for (char& byte : large) byte = char(random() >> 24);
  const std::string large_digest = Sha256Hex(large);
  for (int kill = 0; kill <= kKills; ++kill) {
    ServerProcess server({"--scene-store", folder.path(), "--contexts", "1", "--log-level", "off"});
    ASSERT_NE(server.address(), "");
    client.Connect(server.address());
    client.Check(folder.path());
    if (HasFatalFailure() || kill == kKills) {
      break;
    }
    std::thread work([&] { client.Work(uint32_t(1 + 100 * kill)); });
    std::thread upload([&] { client.Upload(large, large_digest, 1 << 20); });
    std::this_thread::sleep_for(std::chrono::milliseconds(std::uniform_int_distribution(5, 500)(random)));
    server.Kill();
    work.join();
    upload.join();
  }
  std::printf("%zu blobs and %zu scenes acknowledged, %.1f MB gone on from\n", client.blobs(), client.created().size(),
              double(client.resumed_bytes) / 1e6);
  ASSERT_GT(client.created().size(), 5u) << "the kills must leave time for something";
  EXPECT_GT(client.resumed_bytes, 1u << 20);
}

}  // namespace
}  // namespace halfshade
