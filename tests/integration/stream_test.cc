// RenderStream over a real port with a renderer that draws a pattern: the order of its parts, its chunks, readers that
// stall, cancellation, the bound on what is in flight.
#include <grpcpp/create_channel.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cstring>
#include <thread>

#include "client/client.h"
#include "client/glb_writer.h"
#include "halfshade/v1/render.grpc.pb.h"
#include "server/digest.h"
#include "server/server.h"
#include "server/status.h"
#include "tests/support/flat_scene_builder.h"
#include "tests/support/status_matchers.h"

namespace halfshade {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;
using Clock = std::chrono::steady_clock;

std::atomic<int> render_ms{0};
std::atomic<int> renders_begun{0};

// The i-th float of an image: 12 bits that look random, so that no encoder makes little of it.
float Value(size_t i) { return float((uint32_t(i) * 2654435761u) >> 20) / 4096; }

class PatternRenderer : public Renderer {
 public:
  absl::StatusOr<RenderResult> Render(const std::string&, const FlatScene&, const RenderRequest& request,
                                      const StopCheck& stop) override {
    ++renders_begun;
    const auto end = Clock::now() + std::chrono::milliseconds(render_ms);
    while (Clock::now() < end) {
      if (const absl::Status status = stop(); !status.ok()) return status;
      std::this_thread::sleep_for(1ms);
    }
    RenderResult result;
    for (const OutputKind kind : request.outputs) {
      Image image(request.width, request.height, kind == OutputKind::kFrame ? 4 : int(request.lights.size()));
      for (size_t i = 0; i < image.size(); ++i) image.data()[i] = Value(i);
      result.images.push_back({kind, std::move(image)});
    }
    result.report.method = "multi_map";
    return result;
  }
  void ForgetScene(const std::string&) override {}
};

class StreamTest : public testing::Test {
 protected:
  void SetUp() override {
    render_ms = 0;
    renders_begun = 0;
    options_.listen = "127.0.0.1:0";
    options_.stream_stall_s = 1;
    options_.in_flight_mb = 300;
    options_.renderer_factory = [] {
      return WorkerRenderer{nullptr, std::make_unique<PatternRenderer>(), "fake", "0", "fake"};
    };
    auto server = Server::Start(options_);
    ASSERT_OK(server);
    server_ = *std::move(server);
    channel_ = grpc::CreateChannel(server_->grpc_address(), grpc::InsecureChannelCredentials());
    renders_ = v1::RenderService::NewStub(channel_);
    ClientOptions client;
    client.servers = {server_->grpc_address()};
    SceneFiles files;
    files.root.bytes = WriteGlb({MakePlate({0, 0, 0}, 1, 1)});
    files.root.digest = Sha256Hex(files.root.bytes);
    const auto scene = (*Client::Connect(client))->UploadScene(files);
    ASSERT_OK(scene);
    request_.mutable_request()->set_scene(scene->name());
    SetSize(16, 16);
  }

  void SetSize(uint32_t width, uint32_t height) {
    request_.mutable_request()->set_width(width);
    request_.mutable_request()->set_height(height);
  }
  v1::Output* AddOutput(v1::OutputKind kind, v1::Encoding encoding) {
    v1::Output* output = request_.mutable_request()->add_outputs();
    output->set_kind(kind);
    output->set_encoding(encoding);
    return output;
  }

  // What a stream says: 'p'lan, 'h'eader, 'c'hunk, 'r'eport, chunks in a row once.
  struct Heard {
    std::string order;
    v1::RenderReport plan;
    std::vector<v1::OutputImage> images;
    size_t largest_chunk = 0;
    v1::RenderReport report;
    grpc::Status status;
  };
  Heard Listen() {
    Heard heard;
    grpc::ClientContext context;
    const auto stream = renders_->RenderStream(&context, request_);
    v1::RenderStreamResponse part;
    while (stream->Read(&part)) {
      const char letter = "-phcr"[part.part_case()];
      if (letter != 'c' || heard.order.back() != 'c') heard.order += letter;
      if (part.has_plan()) heard.plan = part.plan();
      if (part.has_header()) heard.images.push_back(part.header());
      if (part.has_report()) heard.report = part.report();
      if (letter != 'c') continue;
      heard.images.back().mutable_data()->append(part.chunk());
      heard.largest_chunk = std::max(heard.largest_chunk, part.chunk().size());
    }
    heard.status = stream->Finish();
    return heard;
  }

  ServerOptions options_;
  std::unique_ptr<Server> server_;
  std::shared_ptr<grpc::Channel> channel_;
  std::unique_ptr<v1::RenderService::Stub> renders_;
  v1::RenderStreamRequest request_;
};

TEST_F(StreamTest, SaysThePlanThenEachImageThenTheReport) {
  request_.mutable_request()->mutable_method()->mutable_multi_map();
  AddOutput(v1::OUTPUT_KIND_FRAME, v1::ENCODING_PNG);
  AddOutput(v1::OUTPUT_KIND_VISIBILITY, v1::ENCODING_RAW_F32);
  v1::AreaLight* light = request_.mutable_request()->add_lights();
  light->mutable_center()->set_y(-3);  // under the plate, shining down: nothing to see, so the plan skips it
  light->mutable_edge_u()->set_x(1);
  light->mutable_edge_v()->set_z(1);
  const Heard heard = Listen();
  ASSERT_TRUE(heard.status.ok()) << heard.status.error_message();
  EXPECT_EQ(heard.order, "phchcr");
  EXPECT_EQ(heard.plan.method(), "multi_map");
  EXPECT_EQ(heard.plan.options().multi_map().k(), 64u);
  ASSERT_GE(heard.plan.passes_size(), 1);
  bool skips_light = false;
  for (const v1::Pass& pass : heard.plan.passes()) {
    EXPECT_TRUE(pass.skipped());
    EXPECT_NE(pass.reason(), "");
    skips_light |= pass.name() == "light[0]/multi_map";
  }
  EXPECT_TRUE(skips_light);
  EXPECT_FALSE(heard.plan.has_timing() && heard.plan.timing().total_ms() > 0) << "nothing is drawn yet";
  EXPECT_EQ(heard.images[0].encoding(), v1::ENCODING_PNG);
  EXPECT_TRUE(heard.images[0].data().starts_with("\x89PNG"));
  EXPECT_EQ(heard.images[1].kind(), v1::OUTPUT_KIND_VISIBILITY);
  ASSERT_EQ(heard.images[1].data().size(), 16u * 16 * 4);
  ASSERT_EQ(heard.report.outputs_size(), 2);
  EXPECT_EQ(heard.report.outputs(1).pixel_sha256(), Sha256Hex(heard.images[1].data()));
  EXPECT_GT(heard.report.timing().total_ms(), 0);
}

TEST_F(StreamTest, ChunksHaveAtMost256KiBAndMakeTheWholeImage) {
  SetSize(512, 257);
  AddOutput(v1::OUTPUT_KIND_FRAME, v1::ENCODING_RAW_F32);  // 2.0078 MiB: eight whole chunks and a part
  const Heard heard = Listen();
  ASSERT_TRUE(heard.status.ok()) << heard.status.error_message();
  EXPECT_EQ(heard.largest_chunk, 256u << 10);
  const std::string& data = heard.images.at(0).data();
  ASSERT_EQ(data.size(), 512u * 257 * 16);
  for (size_t i = 0; i < data.size() / 4; ++i) {
    float value = 0;
    std::memcpy(&value, data.data() + 4 * i, 4);
    ASSERT_EQ(value, Value(i)) << i;
  }
}

TEST_F(StreamTest, LayersComeInTheFirstImageAndTheOthersAreHeadersAlone) {
  AddOutput(v1::OUTPUT_KIND_FRAME, v1::ENCODING_EXR_HALF)->set_layer("frame");
  AddOutput(v1::OUTPUT_KIND_VISIBILITY, v1::ENCODING_EXR_FLOAT)->set_layer("light");
  const Heard heard = Listen();
  ASSERT_TRUE(heard.status.ok()) << heard.status.error_message();
  EXPECT_EQ(heard.order, "phchr");
  EXPECT_EQ(heard.images[1].layer(), "light");
  EXPECT_EQ(heard.images[1].data(), "");
}

TEST_F(StreamTest, GivesWhatRenderRefusesForItsSize) {
  SetSize(1024, 1024);
  AddOutput(v1::OUTPUT_KIND_FRAME, v1::ENCODING_RAW_F16);
  grpc::ClientContext context;
  v1::RenderResponse response;
  const grpc::Status unary = renders_->Render(&context, request_.request(), &response);
  EXPECT_EQ(unary.error_code(), grpc::StatusCode::FAILED_PRECONDITION);
  EXPECT_THAT(unary.error_message(), HasSubstr("use RenderStream"));
  const Heard heard = Listen();
  EXPECT_TRUE(heard.status.ok()) << heard.status.error_message();
  EXPECT_EQ(heard.images.at(0).data().size(), 8u << 20);
}

TEST_F(StreamTest, A4096SquaredFloatExrComesThrough) {
  SetSize(4096, 4096);
  AddOutput(v1::OUTPUT_KIND_FRAME, v1::ENCODING_EXR_FLOAT);
  const Heard heard = Listen();
  ASSERT_TRUE(heard.status.ok()) << heard.status.error_message();
  EXPECT_EQ(heard.images.at(0).width(), 4096u);
  EXPECT_EQ(heard.images[0].channels(), 4u);
  EXPECT_TRUE(heard.images[0].data().starts_with("\x76\x2f\x31\x01")) << "EXR's magic number";
  EXPECT_GT(heard.images[0].data().size(), 4u << 20);
  EXPECT_TRUE(Listen().status.ok()) << "256 of 300 MiB were in flight, and are not any more";
}

TEST_F(StreamTest, FaultsAreRenders) {
  SetSize(99999, 16);
  Heard heard = Listen();
  EXPECT_EQ(heard.status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(heard.status.error_message(), "width: 99999; must be 1 to 8192");
  SetSize(16, 16);
  request_.mutable_request()->set_scene("scenes/" + std::string(64, '0'));
  heard = Listen();
  EXPECT_EQ(heard.status.error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_EQ(heard.order, "");
}

TEST_F(StreamTest, ProgressiveSendsCoarseResultsFirstEachWithItsReport) {
  SetSize(512, 512);
  AddOutput(v1::OUTPUT_KIND_FRAME, v1::ENCODING_RAW_F32);
  AddOutput(v1::OUTPUT_KIND_VISIBILITY, v1::ENCODING_RAW_F32);
  request_.set_progressive(true);
  const Heard heard = Listen();
  ASSERT_TRUE(heard.status.ok()) << heard.status.error_message();
  EXPECT_EQ(heard.order, "phchcrhchcrhchcr");
  EXPECT_EQ(renders_begun, 3);
  ASSERT_EQ(heard.images.size(), 6u);
  const uint32_t sizes[] = {128, 256, 512};
  for (size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(heard.images[i].width(), sizes[i / 2]);
    EXPECT_EQ(heard.images[i].data().size(), size_t(sizes[i / 2]) * sizes[i / 2] * 4 * (i % 2 == 0 ? 4 : 1));
  }
  EXPECT_EQ(heard.report.outputs(0).pixel_sha256(), Sha256Hex(heard.images[4].data()));
}

TEST_F(StreamTest, ASmallPictureComesAloneThoughProgressiveIsAsked) {
  request_.set_progressive(true);
  AddOutput(v1::OUTPUT_KIND_FRAME, v1::ENCODING_RAW_F32);
  EXPECT_EQ(Listen().order, "phcr");
  EXPECT_EQ(renders_begun, 1);
}

TEST_F(StreamTest, CoarseResultsThatDoNotFitWhatIsHeldAreLeftOut) {
  SetSize(4096, 4096);
  AddOutput(v1::OUTPUT_KIND_FRAME, v1::ENCODING_RAW_F32);  // 256 of the 300 MiB; a quarter and a half would be 80 more
  request_.set_progressive(true);
  const Heard heard = Listen();
  ASSERT_TRUE(heard.status.ok()) << heard.status.error_message();
  EXPECT_EQ(heard.order, "phcr");
}

TEST_F(StreamTest, AStreamCancelledAfterItsFirstImageDrawsNoFurther) {
  SetSize(512, 512);
  AddOutput(v1::OUTPUT_KIND_FRAME, v1::ENCODING_RAW_F32);
  request_.set_progressive(true);
  render_ms = 200;
  grpc::ClientContext context;
  const auto stream = renders_->RenderStream(&context, request_);
  v1::RenderStreamResponse part;
  while (stream->Read(&part) && !part.has_report()) {
  }
  EXPECT_TRUE(part.has_report());
  context.TryCancel();
  EXPECT_EQ(stream->Finish().error_code(), grpc::StatusCode::CANCELLED);
  render_ms = 0;
  request_.mutable_request()->set_seed(1);
  request_.set_progressive(false);
  EXPECT_EQ(Listen().order, "phcr") << "the context is free again";
  EXPECT_EQ(renders_begun, 3) << "the second coarse one, which was under way, and this";
}

TEST_F(StreamTest, ACancelledStreamFreesTheContextWhetherItDrawsOrSends) {
  render_ms = 20000;
  {
    grpc::ClientContext context;
    const auto stream = renders_->RenderStream(&context, request_);
    v1::RenderStreamResponse part;
    ASSERT_TRUE(stream->Read(&part));
    EXPECT_TRUE(part.has_plan()) << "the plan comes before it is drawn";
    while (renders_begun == 0) std::this_thread::sleep_for(1ms);
    context.TryCancel();
    EXPECT_EQ(stream->Finish().error_code(), grpc::StatusCode::CANCELLED);
  }
  render_ms = 0;
  SetSize(2048, 1024);
  AddOutput(v1::OUTPUT_KIND_FRAME, v1::ENCODING_RAW_F32);  // 32 MiB
  {
    grpc::ClientContext context;
    const auto stream = renders_->RenderStream(&context, request_);
    v1::RenderStreamResponse part;
    for (int i = 0; i < 4; ++i) ASSERT_TRUE(stream->Read(&part));
    context.TryCancel();
    EXPECT_EQ(stream->Finish().error_code(), grpc::StatusCode::CANCELLED);
  }
  EXPECT_TRUE(Listen().status.ok());
}

TEST_F(StreamTest, TheDeadlineEndsAStreamThatIsDrawn) {
  render_ms = 20000;
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + 200ms);
  const auto stream = renders_->RenderStream(&context, request_);
  v1::RenderStreamResponse part;
  while (stream->Read(&part)) {
  }
  EXPECT_EQ(stream->Finish().error_code(), grpc::StatusCode::DEADLINE_EXCEEDED);
}

TEST_F(StreamTest, AReaderThatStallsIsToldSoWhenItReadsOn) {
  SetSize(4096, 2048);
  AddOutput(v1::OUTPUT_KIND_FRAME, v1::ENCODING_RAW_F16);  // 64 MiB, more than any window
  grpc::ClientContext context;
  const auto stream = renders_->RenderStream(&context, request_);
  v1::RenderStreamResponse part;
  ASSERT_TRUE(stream->Read(&part));  // the plan
  ASSERT_TRUE(stream->Read(&part));  // the header: from here on only the reader is waited for
  std::this_thread::sleep_for(1800ms);
  size_t bytes = 0;
  while (stream->Read(&part)) bytes += part.chunk().size();
  const grpc::Status status = stream->Finish();
  EXPECT_EQ(status.error_code(), grpc::StatusCode::DEADLINE_EXCEEDED) << status.error_message();
  EXPECT_EQ(status.error_message(), "the reader took nothing for 1 s");
  EXPECT_LT(bytes, 32u << 20) << "what was under way, and no more";
}

TEST_F(StreamTest, AReaderThatStaysStalledIsCutOffAndItsShareGivenBack) {
  SetSize(4096, 4096);
  AddOutput(v1::OUTPUT_KIND_FRAME, v1::ENCODING_RAW_F32);  // 256 of the 300 MiB
  grpc::ClientContext context;
  const auto stalled = renders_->RenderStream(&context, request_);
  while (renders_begun == 0) std::this_thread::sleep_for(1ms);
  Heard heard = Listen();
  EXPECT_EQ(heard.status.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED) << heard.order;
  EXPECT_EQ(heard.status.error_message(),
            "outputs: 268435456 bytes, and 268435456 of the 314572800 that this server holds are in flight");
  const auto give_up = Clock::now() + 20s;
  do {
    std::this_thread::sleep_for(200ms);
    heard = Listen();
  } while (!heard.status.ok() && Clock::now() < give_up);
  EXPECT_TRUE(heard.status.ok()) << heard.status.error_message();
  v1::RenderStreamResponse part;
  while (stalled->Read(&part)) {
  }
  EXPECT_FALSE(stalled->Finish().ok());
}

TEST_F(StreamTest, WhatCanNeverBeHeldIsAFaultOfTheRequest) {
  SetSize(5000, 4000);
  AddOutput(v1::OUTPUT_KIND_FRAME, v1::ENCODING_RAW_F32);  // 305 MiB
  const Heard heard = Listen();
  EXPECT_EQ(heard.status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(heard.status.error_message(),
            "outputs: 320000000 bytes before compression; this server holds at most 314572800");
}

}  // namespace
}  // namespace halfshade
