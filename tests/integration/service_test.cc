// The service over a real port with a renderer that draws nothing: deadlines, cancellation, queue, drain, the wire's
// edges.
#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <grpcpp/create_channel.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstring>
#include <mutex>
#include <thread>

#include "halfshade/v1/render.grpc.pb.h"
#include "halfshade/v1/scene.grpc.pb.h"
#include "halfshade/v1/server.grpc.pb.h"
#include "server/digest.h"
#include "server/http.h"
#include "server/scene_name.h"
#include "server/status.h"
#include "tests/integration/service_fixture.h"

namespace halfshade {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;
using Clock = std::chrono::steady_clock;

// Of a GET to 127.0.0.1, or 0 without an answer.
int HttpStatus(const std::string& port, const std::string& path) {
  const int connection = socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(uint16_t(std::stoi(port)));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  int status = 0;
  char answer[16] = {};
  const std::string request = "GET " + path + " HTTP/1.0\r\n\r\n";
  if (connect(connection, reinterpret_cast<sockaddr*>(&address), sizeof(address)) == 0 &&
      write(connection, request.data(), request.size()) == ssize_t(request.size()) &&
      read(connection, answer, 12) == 12) {
    status = std::atoi(answer + 9);
  }
  close(connection);
  return status;
}

TEST_F(ServiceTest, ASceneGoesUpAndAFrameComesDown) {
  const std::string scene = MakeScene();
  grpc::ClientContext context;
  v1::RenderResponse response;
  ASSERT_TRUE(renders_->Render(&context, Request(scene), &response).ok());
  ASSERT_EQ(response.images_size(), 1);
  EXPECT_TRUE(response.images(0).data().starts_with("\x89PNG"));
  EXPECT_EQ(response.report().outputs(0).pixel_sha256().size(), 64u);
  EXPECT_EQ(response.report().gl_renderer(), "fake");
  EXPECT_GT(response.report().timing().total_ms(), 0);
}

TEST_F(ServiceTest, APictureThatIsLateInSpiteOfThePredictionSaysSo) {
  v1::RenderRequest request = Request(MakeScene());
  request.mutable_budget()->mutable_max_latency()->set_seconds(2);
  const auto reason = [&]() -> std::string {
    grpc::ClientContext context;
    v1::RenderResponse response;
    const grpc::Status status = renders_->Render(&context, request, &response);
    EXPECT_TRUE(status.ok()) << status.error_message();
    return response.report().reason();
  };
  EXPECT_THAT(reason(), testing::Not(HasSubstr("late")));
  render_ms = 2100;
  EXPECT_THAT(reason(), testing::ContainsRegex("late: 2[0-9][0-9][0-9] ms of 2000"));
  request.mutable_budget()->mutable_max_latency()->set_seconds(600);
  EXPECT_THAT(reason(), testing::Not(HasSubstr("late"))) << "the same time is in time for a later bound";
}

TEST_F(ServiceTest, AnUnknownSceneIsNotFound) {
  const grpc::Status status = Render(Request("scenes/" + std::string(64, '0')));
  EXPECT_EQ(status.error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_THAT(status.error_message(), HasSubstr("is not here"));
}

TEST_F(ServiceTest, ABadRequestIsRefusedBeforeItsSceneIsLookedFor) {
  v1::RenderRequest request = Request("scenes/" + std::string(64, '0'));
  request.set_width(99999);
  const grpc::Status status = Render(request);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(status.error_message(), "width: 99999; must be 1 to 8192");
  EXPECT_EQ(renders_begun, 0);
}

TEST_F(ServiceTest, ABlobWithAnotherDigestIsNeverVisible) {
  const grpc::Status status = Upload("hello", std::string(64, '1'));
  EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  grpc::ClientContext context;
  v1::FindMissingBlobsRequest request;
  request.add_digests(std::string(64, '1'));
  v1::FindMissingBlobsResponse response;
  ASSERT_TRUE(scenes_->FindMissingBlobs(&context, request, &response).ok());
  EXPECT_EQ(response.missing_digests_size(), 1);
}

TEST_F(ServiceTest, AnUploadWithAGapIsRefused) {
  grpc::ClientContext context;
  v1::UploadBlobResponse response;
  auto writer = scenes_->UploadBlob(&context, &response);
  v1::UploadBlobRequest chunk;
  chunk.set_digest(Sha256Hex("hello"));
  chunk.set_size_bytes(5);
  chunk.set_offset_bytes(1);
  chunk.set_data("ello");
  writer->Write(chunk);
  writer->WritesDone();
  const grpc::Status status = writer->Finish();
  EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(status.error_message(), "offset_bytes: 1; the next byte is 0");
}

TEST_F(ServiceTest, ScenesAreListedInPagesDescribedAndDeleted) {
  const std::string scene = MakeScene();
  const std::string again = MakeScene();
  EXPECT_EQ(scene, again) << "named by content";
  v1::ListScenesResponse list;
  {
    grpc::ClientContext context;
    ASSERT_TRUE(scenes_->ListScenes(&context, {}, &list).ok());
    ASSERT_EQ(list.scenes_size(), 1);
    EXPECT_EQ(list.scenes(0).name(), scene);
  }
  v1::DeleteSceneRequest remove;
  remove.set_name(scene);
  v1::DeleteSceneResponse removed;
  {
    grpc::ClientContext context;
    EXPECT_TRUE(scenes_->DeleteScene(&context, remove, &removed).ok());
  }
  grpc::ClientContext context;
  EXPECT_EQ(scenes_->DeleteScene(&context, remove, &removed).error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_EQ(Render(Request(scene)).error_code(), grpc::StatusCode::NOT_FOUND);
}

TEST_F(ServiceTest, AMissingBlobIsNotFoundByDigest) {
  grpc::ClientContext context;
  v1::CreateSceneRequest request;
  request.set_root_digest(std::string(64, 'e'));
  v1::CreateSceneResponse response;
  const grpc::Status status = scenes_->CreateScene(&context, request, &response);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_THAT(status.error_message(), HasSubstr(std::string(64, 'e')));
}

TEST_F(ServiceTest, TheDeadlineOfACallThatWaitsIsAnsweredAtOnceNotAtTheNextDequeue) {
  const std::string scene = MakeScene();
  render_ms = 1000;
  std::thread first([&] { Render(Request(scene)); });
  while (renders_begun == 0) std::this_thread::sleep_for(1ms);
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + 100ms);
  const auto begin = Clock::now();
  EXPECT_EQ(Render(Request(scene), &context).error_code(), grpc::StatusCode::DEADLINE_EXCEEDED);
  EXPECT_LT(Clock::now() - begin, 600ms) << "the one ahead takes 1000 ms";
  first.join();
  EXPECT_EQ(renders_begun, 1) << "it was withdrawn";
}

TEST_F(ServiceTest, ACancelledRenderStopsAndFreesTheContext) {
  const std::string scene = MakeScene();
  render_ms = 20000;
  grpc::ClientContext context;
  std::thread call([&] { EXPECT_EQ(Render(Request(scene), &context).error_code(), grpc::StatusCode::CANCELLED); });
  while (renders_begun == 0) std::this_thread::sleep_for(1ms);
  context.TryCancel();
  call.join();
  render_ms = 0;
  grpc::ClientContext next;
  next.set_deadline(std::chrono::system_clock::now() + 5s);
  EXPECT_TRUE(Render(Request(scene), &next).ok());
}

TEST_F(ServiceTest, AFullQueueAnswersResourceExhaustedWithPushback) {
  const std::string scene = MakeScene();
  const auto statistics = v1::ServerService::NewStub(channel_);
  const auto queued = [&] {
    grpc::ClientContext context;
    v1::GetStatisticsResponse response;
    EXPECT_TRUE(statistics->GetStatistics(&context, {}, &response).ok());
    return response.queued();
  };
  render_ms = 600'000;  // until it is cancelled
  std::vector<std::unique_ptr<grpc::ClientContext>> contexts;
  std::vector<std::thread> callers;
  for (uint32_t i = 0; i < 3; ++i) {
    grpc::ClientContext* context = contexts.emplace_back(std::make_unique<grpc::ClientContext>()).get();
    callers.emplace_back([&, context] { Render(Request(scene), context); });
    // One runs, two wait.
    while (renders_begun == 0 || queued() < i) std::this_thread::sleep_for(1ms);
  }
  for (int i = 0; i < 5; ++i) {
    grpc::ClientContext context;
    const grpc::Status status = Render(Request(scene), &context);
    EXPECT_EQ(status.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
    EXPECT_EQ(status.error_message(), "the queue is full: 2 renders wait");
    EXPECT_EQ(context.GetServerTrailingMetadata().count(kPushbackKey), 1u);
  }
  for (const auto& context : contexts) context->TryCancel();
  for (std::thread& caller : callers) caller.join();
}

TEST_F(ServiceTest, ARepeatedRequestIsNotRenderedAgainUnlessItAsksForThat) {
  v1::RenderRequest request = Request(MakeScene());
  v1::RenderResponse first, second;
  for (v1::RenderResponse* response : {&first, &second}) {
    grpc::ClientContext context;
    EXPECT_TRUE(renders_->Render(&context, request, response).ok());
  }
  EXPECT_EQ(renders_begun, 1);
  EXPECT_EQ(second.images(0).data(), first.images(0).data());
  EXPECT_EQ(second.report().content_key(), first.report().content_key());
  EXPECT_EQ(second.report().outputs(0).pixel_sha256(), first.report().outputs(0).pixel_sha256());
  ASSERT_EQ(second.report().caches_size(), 1);
  EXPECT_EQ(second.report().caches(0).name(), "result");
  EXPECT_EQ(second.report().caches(0).hits(), 1u);
  ASSERT_EQ(second.report().passes_size(), 1);
  EXPECT_TRUE(second.report().passes(0).skipped());
  EXPECT_EQ(second.report().timing().cpu_ms(), 0);
  request.set_cache(v1::CACHE_MODE_REFRESH);
  EXPECT_TRUE(Render(request).ok());
  EXPECT_EQ(renders_begun, 2);
  request.set_cache(v1::CACHE_MODE_USE);
  request.mutable_certify()->set_pixels(64);
  request.mutable_certify()->set_rays(16);
  EXPECT_TRUE(Render(request).ok());
  EXPECT_EQ(renders_begun, 3) << "the same pixels, and yet another reply";
  // What auto takes for an error this coarse, and the same when it is asked for.
  request = Request(request.scene());
  request.mutable_budget()->set_max_error(0.1);
  EXPECT_TRUE(Render(request).ok());
  v1::PlanRenderRequest plan;
  *plan.mutable_request() = request;
  v1::PlanRenderResponse planned;
  grpc::ClientContext context;
  EXPECT_TRUE(renders_->PlanRender(&context, plan, &planned).ok());
  EXPECT_FALSE(planned.plan().options().shaft().has_rows()) << "which the picture chooses";
  *request.mutable_method() = planned.plan().options();
  const grpc::Status explicitly = Render(request);
  EXPECT_TRUE(explicitly.ok()) << explicitly.error_message();
  EXPECT_EQ(renders_begun, 5) << "the report says which";
}

// Whoever comes first may go: the render goes on as long as somebody wants it, and stops with the last.
TEST_F(ServiceTest, IdenticalRequestsUnderWayAreOneRenderThatStopsWithTheLastOfThem) {
  const v1::RenderRequest request = Request(MakeScene());
  render_ms = 600'000;
  constexpr int kCalls = 4;
  std::vector<std::unique_ptr<grpc::ClientContext>> contexts;
  std::vector<grpc::Status> statuses(kCalls);
  std::vector<std::thread> callers;
  for (int i = 0; i < kCalls; ++i) {
    grpc::ClientContext* context = contexts.emplace_back(std::make_unique<grpc::ClientContext>()).get();
    callers.emplace_back([&, context, i] { statuses[i] = Render(request, context); });
    while (renders_begun == 0) std::this_thread::sleep_for(1ms);
  }
  std::this_thread::sleep_for(200ms);  // the others wait
  contexts[0]->TryCancel();
  callers[0].join();
  EXPECT_EQ(statuses[0].error_code(), grpc::StatusCode::CANCELLED);
  contexts[2]->TryCancel();
  callers[2].join();
  std::this_thread::sleep_for(50ms);
  render_ms = 0;
  for (const int i : {1, 3}) {
    callers[i].join();
    EXPECT_TRUE(statuses[i].ok()) << statuses[i].error_message();
  }
  EXPECT_EQ(renders_begun, 1);

  // Nobody is left: the context is free for others.
  const v1::RenderRequest other = Request(request.scene());
  render_ms = 600'000;
  grpc::ClientContext a, b;
  std::thread first([&] { EXPECT_EQ(Render(other, &a).error_code(), grpc::StatusCode::CANCELLED); });
  while (renders_begun == 1) std::this_thread::sleep_for(1ms);
  std::thread second([&] { EXPECT_EQ(Render(other, &b).error_code(), grpc::StatusCode::CANCELLED); });
  std::this_thread::sleep_for(100ms);
  b.TryCancel();
  second.join();
  a.TryCancel();
  first.join();
  render_ms = 0;
  grpc::ClientContext next;
  next.set_deadline(std::chrono::system_clock::now() + 5s);
  EXPECT_TRUE(Render(Request(request.scene()), &next).ok());
}

TEST_F(ServiceTest, WhereTheFirstOfIdenticalRequestsLeavesTheQueueTheNextTakesItsPlace) {
  const std::string scene = MakeScene();
  render_ms = 600'000;
  grpc::ClientContext busy;
  std::thread ahead([&] { Render(Request(scene), &busy); });
  while (renders_begun == 0) std::this_thread::sleep_for(1ms);
  const v1::RenderRequest request = Request(scene);
  grpc::ClientContext a, b;
  std::thread first([&] { EXPECT_EQ(Render(request, &a).error_code(), grpc::StatusCode::CANCELLED); });
  std::this_thread::sleep_for(100ms);
  std::thread second([&] { EXPECT_TRUE(Render(request, &b).ok()); });
  std::this_thread::sleep_for(100ms);
  a.TryCancel();
  first.join();
  render_ms = 0;
  busy.TryCancel();
  ahead.join();
  second.join();
  EXPECT_EQ(renders_begun, 2);
}

TEST_F(ServiceTest, DrainLetsTheCallUnderWayFinishAndTakesNoMore) {
  const std::string scene = MakeScene();
  render_ms = 500;
  grpc::Status status;
  std::thread call([&] { status = Render(Request(scene)); });
  while (renders_begun == 0) std::this_thread::sleep_for(1ms);
  server_->Drain();
  call.join();
  EXPECT_TRUE(status.ok()) << status.error_message();
  EXPECT_EQ(Render(Request(scene)).error_code(), grpc::StatusCode::UNAVAILABLE);
}

TEST_F(ServiceTest, AQueryOfPointsComesBackInOrderAndStopsWhenItIsTooLate) {
  v1::QueryVisibilityRequest query;
  *query.mutable_request() = Request(MakeScene());
  const std::vector<float> coordinates = {1, 2, 3, 4, 5, 6, 7, 8, 9};
  query.set_points(coordinates.data(), coordinates.size() * sizeof(float));
  const auto ask = [&](std::chrono::milliseconds time, v1::QueryVisibilityResponse* response) {
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + time);
    return renders_->QueryVisibility(&context, query, response);
  };
  v1::QueryVisibilityResponse response;
  const grpc::Status status = ask(10s, &response);
  ASSERT_TRUE(status.ok()) << status.error_message();
  ASSERT_EQ(response.visibility().size(), 3 * sizeof(float));
  std::vector<float> values(3);
  std::memcpy(values.data(), response.visibility().data(), response.visibility().size());
  EXPECT_EQ(values, std::vector<float>({0, 1, 2}));
  EXPECT_EQ(response.report().method(), "ray");
  EXPECT_EQ(response.report().gl_renderer(), "fake");

  render_ms = 1000;
  const auto begin = Clock::now();
  EXPECT_EQ(ask(100ms, &response).error_code(), grpc::StatusCode::DEADLINE_EXCEEDED);
  render_ms = 0;
  EXPECT_TRUE(ask(10s, &response).ok()) << "the context is free again";
  EXPECT_LT(Clock::now() - begin, 900ms);

  query.mutable_points()->pop_back();
  const grpc::Status refused = ask(10s, &response);
  EXPECT_EQ(refused.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(refused.error_message(), "points: 35 bytes; must be a multiple of 12");
}

TEST_F(ServiceTest, APlanSaysWhatWouldBeDoneAndDrawsNothing) {
  v1::PlanRenderRequest plan;
  *plan.mutable_request() = Request(MakeScene());
  plan.mutable_request()->mutable_method()->mutable_hard()->set_map_size(77);
  plan.mutable_request()->add_outputs()->set_kind(v1::OUTPUT_KIND_VISIBILITY);
  grpc::ClientContext context;
  v1::PlanRenderResponse response;
  EXPECT_TRUE(renders_->PlanRender(&context, plan, &response).ok());
  EXPECT_EQ(response.plan().method(), "hard");
  EXPECT_EQ(response.plan().options().hard().map_size(), 77u);
  std::vector<std::string> skipped;
  for (const v1::Pass& pass : response.plan().passes()) {
    if (pass.skipped()) skipped.push_back(pass.name() + ": " + pass.reason());
  }
  EXPECT_THAT(skipped, testing::Contains("shade: no FRAME is asked"));
  EXPECT_EQ(renders_begun, 0);

  plan.mutable_request()->set_width(99999);
  grpc::ClientContext bad;
  EXPECT_EQ(renders_->PlanRender(&bad, plan, &response).error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  *plan.mutable_request() = Request("scenes/" + std::string(64, '0'));
  grpc::ClientContext absent;
  EXPECT_EQ(renders_->PlanRender(&absent, plan, &response).error_code(), grpc::StatusCode::NOT_FOUND);
}

TEST_F(ServiceTest, InfoEchoesTheLimitsThatFlagsSet) {
  grpc::ClientContext context;
  v1::GetServerInfoResponse info;
  ASSERT_TRUE(v1::ServerService::NewStub(channel_)->GetServerInfo(&context, {}, &info).ok());
  EXPECT_EQ(info.limits().queue(), 2u);
  EXPECT_EQ(info.contexts(0).gl_renderer(), "fake");
  EXPECT_THAT(info.methods(), testing::ElementsAre("hard", "multi_map", "ray", "pcss", "ssm", "pdsm", "sssm", "shaft"));
}

TEST(HttpTest, ReadinessFollowsTheFlagAndLivenessDoesNot) {
  std::atomic<bool> is_ready{false};
  auto http = HttpServer::Start("127.0.0.1:0", &is_ready, [] { return std::string("halfshade_up 1\n"); });
  ASSERT_OK(http);
  const std::string port = (*http)->address().substr((*http)->address().rfind(':') + 1);
  EXPECT_EQ(HttpStatus(port, "/livez"), 200);
  EXPECT_EQ(HttpStatus(port, "/readyz"), 503);
  is_ready = true;
  EXPECT_EQ(HttpStatus(port, "/readyz"), 200);
  EXPECT_EQ(HttpStatus(port, "/etc/passwd"), 404);
}

TEST_F(ServiceTest, ASecondServerOnThePortIsRefused) {
  ServerOptions second = options_;
  second.http = "off";
  second.listen = server_->grpc_address();
  EXPECT_THAT(Server::Start(second).status(),
              StatusIs(absl::StatusCode::kFailedPrecondition, HasSubstr("cannot be had")));
}

TEST_F(ServiceTest, ScenesOfAKeptStoreAreThereAfterARestart) {
  server_.reset();
  const std::string folder = testing::TempDir() + "/service_test_store";
  options_.scene_store_dir = folder;
  Start();
  const std::string scene = MakeScene();
  server_.reset();
  Start();
  EXPECT_TRUE(Render(Request(scene)).ok());
}

}  // namespace
}  // namespace halfshade
