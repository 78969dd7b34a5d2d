// Client against a scripted server on a real port: what is sent, what is tried again, and where.
#include "client/client.h"

#include <grpcpp/server.h>
#include <grpcpp/server_builder.h>
#include <gtest/gtest.h>

#include <atomic>
#include <deque>
#include <map>
#include <mutex>
#include <thread>

#include "halfshade/v1/render.grpc.pb.h"
#include "halfshade/v1/scene.grpc.pb.h"
#include "server/digest.h"
#include "tests/support/status_matchers.h"

namespace halfshade {
namespace {

using absl::StatusCode;
using testing::HasSubstr;

// One scripted answer to RenderStream.
struct Answer {
  grpc::Status status;
  std::string pushback;           // empty: none
  std::string parts = "phchccr";  // plan, header, chunk, report
};

class FakeServer : public v1::SceneService::Service, public v1::RenderService::Service {
 public:
  FakeServer() {
    grpc::EnableDefaultHealthCheckService(true);
    grpc::ServerBuilder builder;
    int port = 0;
    builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port);
    builder.RegisterService(static_cast<v1::SceneService::Service*>(this));
    builder.RegisterService(static_cast<v1::RenderService::Service*>(this));
    server_ = builder.BuildAndStart();
    address = "127.0.0.1:" + std::to_string(port);
  }
  ~FakeServer() override { server_->Shutdown(std::chrono::system_clock::now()); }

  grpc::Status FindMissingBlobs(grpc::ServerContext* context, const v1::FindMissingBlobsRequest* request,
                                v1::FindMissingBlobsResponse* response) override {
    Note(context);
    for (const std::string& digest : request->digests()) {
      if (!blobs.contains(digest)) response->add_missing_digests(digest);
    }
    return grpc::Status::OK;
  }
  grpc::Status UploadBlob(grpc::ServerContext* context, grpc::ServerReader<v1::UploadBlobRequest>* reader,
                          v1::UploadBlobResponse* response) override {
    Note(context);
    v1::UploadBlobRequest chunk;
    std::string digest;
    while (reader->Read(&chunk)) {
      if (!chunk.digest().empty()) digest = chunk.digest();
      const std::lock_guard lock(mutex);
      std::string& bytes = partial[digest];
      offsets.push_back(chunk.offset_bytes());
      bytes.resize(chunk.offset_bytes());
      bytes += chunk.data();
      if (cut_uploads > 0) {
        --cut_uploads;
        return {grpc::StatusCode::UNAVAILABLE, "cut"};
      }
    }
    const std::lock_guard lock(mutex);
    if (Sha256Hex(partial[digest]) != digest) return {grpc::StatusCode::INVALID_ARGUMENT, "digest"};
    blobs[digest] = partial[digest];
    response->set_committed_bytes(blobs[digest].size());
    return grpc::Status::OK;
  }
  grpc::Status QueryUpload(grpc::ServerContext* context, const v1::QueryUploadRequest* request,
                           v1::QueryUploadResponse* response) override {
    Note(context);
    const std::lock_guard lock(mutex);
    if (!knows_query_upload) return {grpc::StatusCode::UNIMPLEMENTED, "QueryUpload"};
    response->set_committed_bytes(partial[request->digest()].size());
    return grpc::Status::OK;
  }
  grpc::Status CreateScene(grpc::ServerContext* context, const v1::CreateSceneRequest* request,
                           v1::CreateSceneResponse* response) override {
    Note(context);
    const std::lock_guard lock(mutex);
    created = *request;
    response->mutable_scene()->add_warnings("/materials/0: odd");
    return grpc::Status::OK;
  }
  grpc::Status RenderStream(grpc::ServerContext* context, const v1::RenderStreamRequest* request,
                            grpc::ServerWriter<v1::RenderStreamResponse>* writer) override {
    Note(context);
    const std::lock_guard lock(mutex);
    ++renders;
    if (hangs) {
      while (!context->IsCancelled()) std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    Answer answer;
    if (!answers.empty()) {
      answer = answers.front();
      answers.pop_front();
    }
    if (!answer.pushback.empty()) context->AddTrailingMetadata("grpc-retry-pushback-ms", answer.pushback);
    v1::RenderStreamResponse part;
    for (const char step : answer.parts) {
      if (step == 'p') part.mutable_plan()->set_method("plan");
      if (step == 'h') part.mutable_header()->set_width(64);
      if (step == 'c') part.set_chunk("chunk");
      if (step == 'r') part.mutable_report()->set_method(request->request().scene());
      writer->Write(part);
    }
    return answer.status;
  }

  std::string address;
  std::mutex mutex;
  std::map<std::string, std::string> blobs, partial;
  std::vector<uint64_t> offsets;
  v1::CreateSceneRequest created;
  std::deque<Answer> answers;  // of RenderStream; OK when it is used up
  int cut_uploads = 0;
  bool knows_query_upload = true;
  bool hangs = false;
  std::atomic<int> renders = 0;
  std::atomic<int> calls = 0;
  std::atomic<int> calls_without_scene = 0;
  std::string expected_scene = "scenes/x";

 private:
  void Note(grpc::ServerContext* context) {
    ++calls;
    const auto found = context->client_metadata().find("x-halfshade-scene");
    const bool has_scene = found != context->client_metadata().end() &&
                           std::string(found->second.data(), found->second.size()) == expected_scene;
    if (!has_scene) ++calls_without_scene;
  }

  std::unique_ptr<grpc::Server> server_;
};

SceneFiles TwoFiles() {
  SceneFiles scene;
  scene.name = "scenes/x";
  scene.root.bytes = "root";
  scene.files.push_back({"a.bin", std::string((2 << 20) + 5, 'a'), ""});
  scene.files.push_back({"same.bin", std::string((2 << 20) + 5, 'a'), ""});
  scene.root.digest = Sha256Hex(scene.root.bytes);
  for (SceneFile& file : scene.files) file.digest = Sha256Hex(file.bytes);
  return scene;
}

v1::RenderRequest Request() {
  v1::RenderRequest request;
  request.set_scene("scenes/x");
  return request;
}

std::unique_ptr<Client> ClientOf(std::vector<std::string> servers, double timeout_s = 20) {
  ClientOptions options;
  options.servers = std::move(servers);
  options.timeout = std::chrono::duration<double>(timeout_s);
  return *Client::Connect(std::move(options));
}

TEST(ClientTest, UploadsInChunksOfOneMebibyteAndEachBlobOnce) {
  FakeServer server;
  const SceneFiles files = TwoFiles();
  ASSERT_OK(ClientOf({server.address})->Render(Request(), &files));
  EXPECT_EQ(server.offsets, (std::vector<uint64_t>{0, 0, 1 << 20, 2 << 20}));
  EXPECT_EQ(server.blobs.size(), 2u);
  EXPECT_EQ(server.created.root_digest(), TwoFiles().root.digest);
  EXPECT_EQ(server.created.files().at("same.bin"), TwoFiles().files[1].digest);
  EXPECT_EQ(server.renders, 1);
}

TEST(ClientTest, SendsTheScenesNameWithEveryCall) {
  FakeServer server;
  server.cut_uploads = 1;
  const SceneFiles files = TwoFiles();
  ASSERT_OK(ClientOf({server.address})->Render(Request(), &files));
  EXPECT_GE(server.calls, 7);
  EXPECT_EQ(server.calls_without_scene, 0);
}

TEST(ClientTest, UploadsNothingThatTheServerHas) {
  FakeServer server;
  const SceneFiles files = TwoFiles();
  ASSERT_OK(ClientOf({server.address})->UploadScene(files));
  server.offsets.clear();
  ASSERT_OK(ClientOf({server.address})->UploadScene(files));
  EXPECT_TRUE(server.offsets.empty());
}

TEST(ClientTest, AnEmptyFileIsUploaded) {
  FakeServer server;
  SceneFiles files = TwoFiles();
  files.files = {{"empty.bin", "", Sha256Hex("")}};
  ASSERT_OK(ClientOf({server.address})->UploadScene(files));
  EXPECT_TRUE(server.blobs.contains(Sha256Hex("")));
}

TEST(ClientTest, ACutUploadGoesOnWhereItStopped) {
  FakeServer server;
  SceneFiles files = TwoFiles();
  server.blobs[files.root.digest] = files.root.bytes;
  server.cut_uploads = 1;
  ASSERT_OK(ClientOf({server.address})->UploadScene(files));
  EXPECT_EQ(server.offsets, (std::vector<uint64_t>{0, 1 << 20, 2 << 20}));
}

TEST(ClientTest, AnUploadThatGetsOnIsCutAsOftenAsItTakes) {
  FakeServer server;
  SceneFiles files = TwoFiles();
  server.blobs[files.root.digest] = files.root.bytes;
  files.files = {{"a.bin", std::string((11 << 20) + 5, 'a'), ""}};
  files.files[0].digest = Sha256Hex(files.files[0].bytes);
  server.cut_uploads = 11;
  ASSERT_OK(ClientOf({server.address})->UploadScene(files));
  EXPECT_EQ(server.offsets.size(), 12u) << "no chunk twice";
  EXPECT_TRUE(server.blobs.contains(files.files[0].digest));
}

TEST(ClientTest, AnUploadGoesOnFromWhatAnotherClientLeft) {
  FakeServer server;
  const SceneFiles files = TwoFiles();
  server.partial[files.files[0].digest] = std::string(2 << 20, 'a');
  ASSERT_OK(ClientOf({server.address})->UploadScene(files));
  EXPECT_EQ(server.offsets, (std::vector<uint64_t>{0, 2 << 20}));
}

TEST(ClientTest, ABeginningThatIsNotOursIsSentAgain) {
  FakeServer server;
  const SceneFiles files = TwoFiles();
  server.partial[files.files[0].digest] = std::string(2 << 20, 'b');
  ASSERT_OK(ClientOf({server.address})->UploadScene(files));
  EXPECT_EQ(server.offsets, (std::vector<uint64_t>{0, 2 << 20, 0, 1 << 20, 2 << 20}));
}

TEST(ClientTest, ACutUploadStartsOverWhereTheServerCannotSay) {
  FakeServer server;
  SceneFiles files = TwoFiles();
  server.blobs[files.root.digest] = files.root.bytes;
  server.cut_uploads = 1;
  server.knows_query_upload = false;
  ASSERT_OK(ClientOf({server.address})->UploadScene(files));
  EXPECT_EQ(server.offsets, (std::vector<uint64_t>{0, 0, 1 << 20, 2 << 20}));
}

TEST(ClientTest, PutsThePartsOfAStreamTogether) {
  FakeServer server;
  const auto response = ClientOf({server.address})->Render(Request(), nullptr);
  ASSERT_OK(response);
  ASSERT_EQ(response->images_size(), 2);
  EXPECT_EQ(response->images(0).data(), "chunk");
  EXPECT_EQ(response->images(1).data(), "chunkchunk");
  EXPECT_EQ(response->images(1).width(), 64u);
  EXPECT_EQ(response->report().method(), "scenes/x");
}

TEST(ClientTest, AStreamWithAPartMissingIsInternalAndAHalfOneLeavesNothingBehind) {
  FakeServer server;
  for (const char* parts : {"", "phc", "pcr"}) {
    server.answers = {{grpc::Status::OK, "", parts}};
    EXPECT_THAT(ClientOf({server.address})->Render(Request(), nullptr),
                StatusIs(StatusCode::kInternal, HasSubstr("RenderStream")));
  }
  server.answers = {{{grpc::StatusCode::UNAVAILABLE, "draining"}, "", "phc"}};
  const auto response = ClientOf({server.address})->Render(Request(), nullptr);
  ASSERT_OK(response);
  EXPECT_EQ(response->images_size(), 2);
}

TEST(ClientTest, WaitsForThePushBackAndTriesAgain) {
  FakeServer server;
  server.answers = {{{grpc::StatusCode::RESOURCE_EXHAUSTED, "full"}, "300"}};
  const auto client = ClientOf({server.address});
  const auto start = std::chrono::steady_clock::now();
  ASSERT_OK(client->Render(Request(), nullptr));
  EXPECT_GE(std::chrono::steady_clock::now() - start, std::chrono::milliseconds(300));
  EXPECT_EQ(server.renders, 2);
}

TEST(ClientTest, APushBackBeyondTheTimeoutIsNotWaitedFor) {
  FakeServer server;
  server.answers = {{{grpc::StatusCode::RESOURCE_EXHAUSTED, "full"}, "60000"}};
  const auto client = ClientOf({server.address}, 5);
  const auto start = std::chrono::steady_clock::now();
  EXPECT_THAT(client->Render(Request(), nullptr), StatusIs(StatusCode::kResourceExhausted, HasSubstr("full")));
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(5));
}

TEST(ClientTest, TriesAgainWhenUnavailableAndNeverOnAFault) {
  FakeServer server;
  server.answers = {{{grpc::StatusCode::UNAVAILABLE, "draining"}, ""}};
  ASSERT_OK(ClientOf({server.address})->Render(Request(), nullptr));
  EXPECT_EQ(server.renders, 2);
  server.answers = {{{grpc::StatusCode::INVALID_ARGUMENT, "width: 0"}, ""}};
  EXPECT_THAT(ClientOf({server.address})->Render(Request(), nullptr),
              StatusIs(StatusCode::kInvalidArgument, HasSubstr("width: 0")));
  EXPECT_EQ(server.renders, 3);
}

TEST(ClientTest, ASceneThatWasEvictedIsUploadedAgainIfItsFilesAreHere) {
  FakeServer server;
  const SceneFiles files = TwoFiles();
  server.answers = {{{grpc::StatusCode::NOT_FOUND, "gone"}, ""}};
  ASSERT_OK(ClientOf({server.address})->Render(Request(), &files));
  EXPECT_EQ(server.renders, 2);
  server.answers = {{{grpc::StatusCode::NOT_FOUND, "gone"}, ""}};
  EXPECT_THAT(ClientOf({server.address})->Render(Request(), nullptr),
              StatusIs(StatusCode::kNotFound, HasSubstr("gone")));
}

TEST(ClientTest, TheTimeoutEndsACallThatHangs) {
  FakeServer server;
  server.hangs = true;
  EXPECT_THAT(ClientOf({server.address}, 0.3)->Render(Request(), nullptr),
              StatusIs(StatusCode::kDeadlineExceeded, HasSubstr("")));
}

TEST(ClientTest, AServerThatIsNotThereIsUnavailable) {
  EXPECT_THAT(ClientOf({"127.0.0.1:1"}, 1)->Render(Request(), nullptr),
              StatusIs(StatusCode::kUnavailable, HasSubstr("")));
}

TEST(ClientTest, EveryClientTakesTheSameServerAndTheNextWhenItIsDead) {
  FakeServer one, two;
  ASSERT_OK(ClientOf({one.address, two.address})->Render(Request(), nullptr));
  ASSERT_OK(ClientOf({two.address, one.address})->Render(Request(), nullptr));
  EXPECT_EQ(one.renders * two.renders, 0);
  EXPECT_EQ(one.renders + two.renders, 2);
  FakeServer& first = one.renders > 0 ? one : two;
  FakeServer& second = one.renders > 0 ? two : one;
  first.answers = {{{grpc::StatusCode::UNAVAILABLE, "draining"}, ""},
                   {{grpc::StatusCode::UNAVAILABLE, "draining"}, ""}};
  ASSERT_OK(ClientOf({one.address, two.address})->Render(Request(), nullptr));
  EXPECT_EQ(second.renders, 1);
}

TEST(ClientTest, HealthIsReadFromTheStandardService) {
  FakeServer server;
  const auto health = ClientOf({server.address})->CheckHealth(server.address);
  ASSERT_OK(health);
  EXPECT_EQ(*health, "SERVING");
}

TEST(ClientTest, WarningsOfTheSceneReachTheUser) {
  FakeServer server;
  std::vector<std::string> notices;
  ClientOptions options;
  options.servers = {server.address};
  options.notice = [&](const std::string& sentence) { notices.push_back(sentence); };
  ASSERT_OK((*Client::Connect(std::move(options)))->UploadScene(TwoFiles()));
  EXPECT_EQ(notices, std::vector<std::string>{"warning: /materials/0: odd"});
}

}  // namespace
}  // namespace halfshade
