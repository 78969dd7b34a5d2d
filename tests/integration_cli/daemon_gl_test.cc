// `halfshaded` as a process: its end, and what a message that is small only on the wire costs it.
#include <grpcpp/create_channel.h>
#include <grpcpp/generic/generic_stub.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <cstdio>
#include <thread>

#include "client/glb_writer.h"
#include "halfshade/v1/render.grpc.pb.h"
#include "halfshade/v1/scene.grpc.pb.h"
#include "server/digest.h"
#include "tests/integration_cli/process.h"
#include "tests/support/flat_scene_builder.h"

namespace halfshade {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

std::string MakeScene(const std::shared_ptr<grpc::Channel>& channel) {
  const std::string glb = WriteGlb({MakePlate({0, 0, 0}, 4, 4), MakePlate({0, 1, 0}, 1, 1)});
  const auto scenes = v1::SceneService::NewStub(channel);
  v1::UploadBlobRequest chunk;
  chunk.set_digest(Sha256Hex(glb));
  chunk.set_size_bytes(glb.size());
  chunk.set_data(glb);
  grpc::ClientContext upload, create;
  v1::UploadBlobResponse uploaded;
  const auto writer = scenes->UploadBlob(&upload, &uploaded);
  writer->Write(chunk);
  writer->WritesDone();
  EXPECT_TRUE(writer->Finish().ok());
  v1::CreateSceneRequest request;
  request.set_root_digest(chunk.digest());
  v1::CreateSceneResponse created;
  EXPECT_TRUE(scenes->CreateScene(&create, request, &created).ok());
  return created.scene().name();
}

// Some seconds of work.
v1::RenderRequest LongRequest(const std::string& scene) {
  v1::RenderRequest request;
  request.set_scene(scene);
  request.set_width(1280);
  request.set_height(720);
  request.mutable_method()->mutable_ray()->set_rays(16384);
  return request;
}

TEST(DaemonTest, AGzipBombIsRefusedBeforeItIsInflated) {
  const ServerProcess server;
  const auto channel = grpc::CreateChannel(server.address(), grpc::InsecureChannelCredentials());
  MakeScene(channel);
  const double before_mb = server.PeakMemoryMb();
  v1::QueryVisibilityRequest bomb;
  bomb.mutable_points()->resize(256 << 20);  // zeros
  grpc::ClientContext context;
  context.set_compression_algorithm(GRPC_COMPRESS_GZIP);
  v1::QueryVisibilityResponse response;
  const grpc::Status status = v1::RenderService::NewStub(channel)->QueryVisibility(&context, bomb, &response);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::UNIMPLEMENTED) << status.error_message();
  std::printf("peak memory %.0f MB before, %.0f MB after 256 MiB of zeros by gzip\n", before_mb, server.PeakMemoryMb());
  EXPECT_LT(server.PeakMemoryMb() - before_mb, 64);
}

// A call without a message in or a known one out.
grpc::Status CallEmpty(const std::string& address, const std::string& method, size_t* bytes) {
  grpc::GenericStub stub(grpc::CreateChannel(address, grpc::InsecureChannelCredentials()));
  grpc::CompletionQueue queue;
  grpc::ClientContext context;
  const grpc::Slice nothing;
  const auto call = stub.PrepareUnaryCall(&context, method, grpc::ByteBuffer(&nothing, 1), &queue);
  call->StartCall();
  grpc::ByteBuffer answer;
  grpc::Status status;
  call->Finish(&answer, &status, nullptr);
  void* tag = nullptr;
  bool is_ok = false;
  queue.Next(&tag, &is_ok);
  *bytes = answer.Length();
  return status;
}

TEST(DaemonTest, ChannelzIsOnTheAdminPortAlone) {
  const std::string method = "/grpc.channelz.v1.Channelz/GetServers";
  const ServerProcess server({"--admin", "127.0.0.1:0"});
  ASSERT_NE(server.admin(), "");
  size_t bytes = 0;
  const grpc::Status status = CallEmpty(server.admin(), method, &bytes);
  EXPECT_TRUE(status.ok()) << status.error_message();
  EXPECT_GT(bytes, 20u) << "servers and their sockets";
  EXPECT_EQ(CallEmpty(server.address(), method, &bytes).error_code(), grpc::StatusCode::UNIMPLEMENTED);
  EXPECT_EQ(CallEmpty(server.admin(), "/halfshade.v1.ServerService/GetServerInfo", &bytes).error_code(),
            grpc::StatusCode::UNIMPLEMENTED);
  EXPECT_EQ(ServerProcess().admin(), "");
}

TEST(DaemonTest, DrainsAtSigtermAndEndsAtOnceAtTheSecond) {
  ServerProcess server({"--grace-s", "60"});
  const auto channel = grpc::CreateChannel(server.address(), grpc::InsecureChannelCredentials());
  const std::string scene = MakeScene(channel);
  std::thread call([&] {
    grpc::ClientContext context;
    v1::RenderResponse response;
    v1::RenderService::NewStub(channel)->Render(&context, LongRequest(scene), &response);
  });
  std::this_thread::sleep_for(300ms);
  const auto begin = Clock::now();
  server.Signal(SIGTERM);
  std::this_thread::sleep_for(300ms);
  EXPECT_TRUE(server.IsAlive()) << "a call is under way";
  server.Signal(SIGTERM);
  EXPECT_EQ(server.Wait(), 0);
  EXPECT_LT(Clock::now() - begin, 10s);
  call.join();
}

}  // namespace
}  // namespace halfshade
