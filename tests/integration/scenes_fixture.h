// A server over a real port with a renderer that draws nothing, and a client that can hang up anywhere.
#pragma once

#include <grpcpp/create_channel.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <filesystem>
#include <memory>
#include <string>
#include <thread>

#include "halfshade/v1/render.grpc.pb.h"
#include "halfshade/v1/scene.grpc.pb.h"
#include "halfshade/v1/server.grpc.pb.h"
#include "server/digest.h"
#include "server/server.h"
#include "server/status.h"
#include "tests/client/temporary_folder.h"
#include "tests/support/status_matchers.h"

namespace halfshade {

class BlankRenderer : public Renderer {
 public:
  absl::StatusOr<RenderResult> Render(const std::string&, const FlatScene&, const RenderRequest& request,
                                      const StopCheck&) override {
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
    RenderResult result;
    for (const OutputKind kind : request.outputs) {
      result.images.push_back({kind, Image(request.width, request.height, kind == OutputKind::kFrame ? 4 : 1)});
    }
    return result;
  }
  absl::StatusOr<QueryResult> QueryVisibility(const std::string&, const FlatScene&, const RenderRequest&,
                                              const QueryPoints& points, const StopCheck&) override {
    QueryResult result;
    result.visibility.assign(points.points_ws.size(), 1);
    return result;
  }
  void ForgetScene(const std::string&) override {}
};

inline std::string Noise(size_t size, uint32_t seed) {
  std::string bytes(size, 0);
  for (char& byte : bytes) {
    seed = seed * 1664525 + 1013904223;
    byte = char(seed >> 24);
  }
  return bytes;
}

class ScenesTest : public testing::Test {
 protected:
  void SetUp() override {
    options_.listen = "127.0.0.1:0";
    options_.scene_store_dir = folder_.path();
    options_.limits.queue = 64;
    options_.renderer_factory = [] {
      return WorkerRenderer{nullptr, std::make_unique<BlankRenderer>(), "blank", "0", "blank"};
    };
    Start();
  }
  void Start() {
    server_.reset();
    auto server = Server::Start(options_);
    ASSERT_OK(server);
    server_ = *std::move(server);
    const auto channel = grpc::CreateChannel(server_->grpc_address(), grpc::InsecureChannelCredentials());
    scenes_ = v1::SceneService::NewStub(channel);
    renders_ = v1::RenderService::NewStub(channel);
    statistics_ = v1::ServerService::NewStub(channel);
  }

  // Sends bytes [begin, end) of a blob in chunks and then hangs up, or, at the blob's end, asks for the answer.
  grpc::Status Send(const std::string& bytes, size_t begin, size_t end, size_t chunk, const std::string& digest) {
    grpc::ClientContext context;
    v1::UploadBlobResponse response;
    const auto writer = scenes_->UploadBlob(&context, &response);
    do {
      v1::UploadBlobRequest request;
      request.set_digest(digest);
      request.set_size_bytes(bytes.size());
      request.set_offset_bytes(begin);
      request.set_data(bytes.substr(begin, std::min(chunk, end - begin)));
      if (!writer->Write(request)) return writer->Finish();
      begin += request.data().size();
    } while (begin < end);
    if (end < bytes.size()) {
      // What is on its way is let through, so that the cut is where the test wants it.
      for (int i = 0; i < 2000 && !IsTaken(digest, end); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(1));
      context.TryCancel();
    } else {
      writer->WritesDone();
    }
    return writer->Finish();
  }
  bool IsTaken(const std::string& digest, size_t bytes) const {
    std::error_code error;
    return std::filesystem::file_size(folder_.path() / "incoming" / digest, error) == bytes && !error;
  }
  v1::QueryUploadResponse Query(const std::string& digest) {
    grpc::ClientContext context;
    v1::QueryUploadRequest request;
    request.set_digest(digest);
    v1::QueryUploadResponse response;
    EXPECT_TRUE(scenes_->QueryUpload(&context, request, &response).ok());
    return response;
  }
  // After a cut the server may still be at its last sync.
  uint64_t CommittedAfterCut(const std::string& digest, uint64_t expected) {
    for (int i = 0; i < 2000 && Query(digest).committed_bytes() != expected; ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    return Query(digest).committed_bytes();
  }
  // Cuts a blob at every one of its chunks, every other time restarting the server.
  void CutEverywhere(size_t size, size_t chunk, bool is_restarting) {
    const std::string bytes = Noise(size, 7), digest = Sha256Hex(bytes);
    size_t sent = 0;
    while (sent + chunk < size) {
      // The server may still be at the end of the call before: then this one is told to come back.
      for (int i = 0; i < 3 && Query(digest).committed_bytes() == sent; ++i) {
        const grpc::Status status = Send(bytes, sent, sent + chunk, chunk, digest);
        ASSERT_EQ(status.error_code(), grpc::StatusCode::CANCELLED) << status.error_message();
        CommittedAfterCut(digest, sent + chunk);
      }
      sent += chunk;
      ASSERT_EQ(Query(digest).committed_bytes(), sent);
      if (is_restarting && sent / chunk % 2 == 0) Start();
      EXPECT_FALSE(Query(digest).complete());
    }
    const grpc::Status status = Send(bytes, sent, size, chunk, digest);
    ASSERT_TRUE(status.ok()) << status.error_message();
    EXPECT_TRUE(Query(digest).complete());
    EXPECT_EQ(ReadAll(folder_ / ("blobs/" + digest)), bytes);
    EXPECT_TRUE(std::filesystem::is_empty(folder_.path() / "incoming"));
  }
  grpc::Status CreateScene(const std::string& root, std::string* name = nullptr) {
    grpc::ClientContext context;
    v1::CreateSceneRequest request;
    request.set_root_digest(root);
    v1::CreateSceneResponse response;
    const grpc::Status status = scenes_->CreateScene(&context, request, &response);
    pushback_ = context.GetServerTrailingMetadata().count(kPushbackKey) > 0;
    if (name != nullptr) *name = response.scene().name();
    return status;
  }
  grpc::Status Render(const std::string& scene, v1::RenderResponse* response) {
    grpc::ClientContext context;
    v1::RenderRequest request;
    request.set_scene(scene);
    request.set_width(8);
    request.set_height(8);
    request.set_seed(++seed_);  // identical requests would be one
    return renders_->Render(&context, request, response);
  }
  // Of one point.
  grpc::Status QueryPoint(const std::string& scene) {
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + std::chrono::seconds(60));
    v1::QueryVisibilityRequest query;
    query.mutable_request()->set_scene(scene);
    query.set_points(std::string(3 * sizeof(float), 0));
    v1::QueryVisibilityResponse response;
    return renders_->QueryVisibility(&context, query, &response);
  }
  v1::GetStatisticsResponse Statistics() {
    grpc::ClientContext context;
    v1::GetStatisticsResponse response;
    EXPECT_TRUE(statistics_->GetStatistics(&context, {}, &response).ok());
    return response;
  }

  const TemporaryFolder folder_;
  ServerOptions options_;
  bool pushback_ = false;
  std::unique_ptr<Server> server_;
  std::unique_ptr<v1::SceneService::Stub> scenes_;
  std::unique_ptr<v1::RenderService::Stub> renders_;
  std::atomic<uint32_t> seed_{0};
  std::unique_ptr<v1::ServerService::Stub> statistics_;
};

}  // namespace halfshade
