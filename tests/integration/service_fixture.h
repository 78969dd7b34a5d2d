// A server on a real port whose renderer draws nothing, so that tests decide how long a render takes and what befalls
// it.
#pragma once

#include <grpcpp/create_channel.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <string>
#include <thread>

#include "client/glb_writer.h"
#include "halfshade/v1/render.grpc.pb.h"
#include "halfshade/v1/scene.grpc.pb.h"
#include "server/digest.h"
#include "server/server.h"
#include "tests/support/flat_scene_builder.h"
#include "tests/support/status_matchers.h"

namespace halfshade {

// How long each render takes, and how many have begun.
inline std::atomic<int> render_ms{0};
inline std::atomic<int> renders_begun{0};
// How many of the next renders lose their context, contexts made so far, and how long one more takes.
inline std::atomic<int> losses_to_come{0};
inline std::atomic<int> contexts_made{0};
inline std::atomic<int> make_ms{0};

// Draws nothing.
class FakeRenderer : public Renderer {
  using Clock = std::chrono::steady_clock;

 public:
  absl::StatusOr<RenderResult> Render(const std::string&, const FlatScene&, const RenderRequest& request,
                                      const StopCheck& stop) override {
    ++renders_begun;
    const auto begin = Clock::now();
    do {
      if (const absl::Status status = stop(); !status.ok()) return status;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    } while (Clock::now() < begin + std::chrono::milliseconds(render_ms));
    if (losses_to_come > 0) {
      --losses_to_come;
      is_lost_ = true;
    }
    if (is_lost_) return absl::UnavailableError("the GL context is lost");
    RenderResult result;
    for (const OutputKind kind : request.outputs) {
      result.images.push_back(
          {kind, Image(request.width, request.height, kind == OutputKind::kFrame ? 4 : int(request.lights.size()))});
    }
    result.report.method = "multi_map";
    return result;
  }
  // Of each point and light: its place in the answer.
  absl::StatusOr<QueryResult> QueryVisibility(const std::string&, const FlatScene&, const RenderRequest& request,
                                              const QueryPoints& points, const StopCheck& stop) override {
    const auto begin = Clock::now();
    do {
      if (const absl::Status status = stop(); !status.ok()) return status;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    } while (Clock::now() < begin + std::chrono::milliseconds(render_ms));
    QueryResult result;
    for (size_t i = 0; i < points.points_ws.size() * request.lights.size(); ++i) {
      result.visibility.push_back(float(i));
    }
    result.report.method = "ray";
    return result;
  }
  void ForgetScene(const std::string&) override {}
  absl::Status CheckCanary() override {
    return is_lost_ ? absl::UnavailableError("the GL context is lost") : absl::OkStatus();
  }

 private:
  bool is_lost_ = false;
};

class ServiceTest : public testing::Test {
 protected:
  void SetUp() override {
    render_ms = 0;
    renders_begun = 0;
    losses_to_come = contexts_made = make_ms = 0;
    options_.listen = "127.0.0.1:0";
    options_.limits.queue = 2;
    options_.grace_s = 5;
    options_.renderer_factory = [] {
      const bool is_first = contexts_made++ == 0;
      for (int ms = 0; !is_first && ms < make_ms; ++ms) std::this_thread::sleep_for(std::chrono::milliseconds(1));
      return WorkerRenderer{nullptr, std::make_unique<FakeRenderer>(), "fake", "0", "fake"};
    };
    Start();
  }
  void Start() {
    auto server = Server::Start(options_);
    ASSERT_OK(server);
    server_ = *std::move(server);
    channel_ = grpc::CreateChannel(server_->grpc_address(), grpc::InsecureChannelCredentials());
    scenes_ = v1::SceneService::NewStub(channel_);
    renders_ = v1::RenderService::NewStub(channel_);
  }

  grpc::Status Upload(const std::string& bytes, const std::string& digest, size_t chunk = 1000) {
    grpc::ClientContext context;
    v1::UploadBlobResponse response;
    auto writer = scenes_->UploadBlob(&context, &response);
    for (size_t at = 0; at < bytes.size(); at += chunk) {
      v1::UploadBlobRequest request;
      request.set_digest(digest);
      request.set_size_bytes(bytes.size());
      request.set_offset_bytes(at);
      request.set_data(bytes.substr(at, chunk));
      if (!writer->Write(request)) break;
    }
    writer->WritesDone();
    return writer->Finish();
  }

  // Uploads a plate and makes a scene of it; its name.
  std::string MakeScene() {
    const std::string glb = WriteGlb({MakePlate({0, 0, 0}, 1, 1)});
    EXPECT_TRUE(Upload(glb, Sha256Hex(glb)).ok());
    grpc::ClientContext context;
    v1::CreateSceneRequest request;
    request.set_root_digest(Sha256Hex(glb));
    v1::CreateSceneResponse response;
    const grpc::Status status = scenes_->CreateScene(&context, request, &response);
    EXPECT_TRUE(status.ok()) << status.error_message();
    EXPECT_EQ(response.scene().triangles(), 2u);
    return response.scene().name();
  }

  // No two are alike: identical requests would be one.
  v1::RenderRequest Request(const std::string& scene) {
    v1::RenderRequest request;
    request.set_seed(++seed_);
    request.set_scene(scene);
    request.set_width(16);
    request.set_height(16);
    return request;
  }

  grpc::Status Render(const v1::RenderRequest& request, grpc::ClientContext* context) {
    v1::RenderResponse response;
    return renders_->Render(context, request, &response);
  }
  grpc::Status Render(const v1::RenderRequest& request) {
    grpc::ClientContext context;
    return Render(request, &context);
  }

  uint32_t seed_ = 0;
  ServerOptions options_;
  std::unique_ptr<Server> server_;
  std::shared_ptr<grpc::Channel> channel_;
  std::unique_ptr<v1::SceneService::Stub> scenes_;
  std::unique_ptr<v1::RenderService::Stub> renders_;
};

}  // namespace halfshade
