#include "client/client.h"

#include <absl/strings/str_cat.h>
#include <google/protobuf/empty.pb.h>
#include <google/protobuf/unknown_field_set.h>
#include <grpcpp/create_channel.h>
#include <grpcpp/generic/generic_stub.h>

#include <algorithm>
#include <future>
#include <set>
#include <thread>
#include <utility>

#include "client/rendezvous.h"
#include "client/retry.h"
#include "halfshade/v1/render.grpc.pb.h"
#include "halfshade/v1/scene.grpc.pb.h"
#include "halfshade/v1/server.grpc.pb.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

constexpr size_t kChunkBytes = 1 << 20;
// Pictures come in chunks of 256 KiB; what else a server sends, a scene's description say, is far below this.
constexpr int kMaxReplyBytes = 6 << 20;
constexpr auto kRetryWindow = std::chrono::seconds(60);
// With other servers to turn to, a dead one is left sooner.
constexpr int kAttempts = 6;
constexpr int kAttemptsWithOthers = 2;

absl::Status ToAbsl(const grpc::Status& status) {
  return absl::Status(static_cast<absl::StatusCode>(status.error_code()), status.error_message());
}

std::shared_ptr<grpc::Channel> CreateChannelTo(const std::string& server) {
  grpc::ChannelArguments arguments;
  // Retries are ours alone; neither a DNS record nor a proxy variable changes where and how we call.
  arguments.SetInt(GRPC_ARG_ENABLE_RETRIES, 0);
  arguments.SetInt(GRPC_ARG_SERVICE_CONFIG_DISABLE_RESOLUTION, 1);
  arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0);
  // A server that restarts is found again within our own pauses.
  arguments.SetInt(GRPC_ARG_INITIAL_RECONNECT_BACKOFF_MS, 100);
  arguments.SetInt(GRPC_ARG_MIN_RECONNECT_BACKOFF_MS, 1000);
  arguments.SetInt(GRPC_ARG_MAX_RECONNECT_BACKOFF_MS, 1000);
  arguments.SetMaxReceiveMessageSize(kMaxReplyBytes);
  return grpc::CreateCustomChannel(server, grpc::InsecureChannelCredentials(), arguments);
}

// Puts the parts of a stream together: the plan, then each image's header and chunks, then the report; the last result
// stays in `response`.
grpc::Status ReadStream(grpc::ClientReader<v1::RenderStreamResponse>* stream, const CoarseListener& on_coarse,
                        v1::RenderResponse* response) {
  response->Clear();
  v1::RenderStreamResponse part;
  bool is_in_order = true;
  while (stream->Read(&part)) {
    switch (part.part_case()) {
      case v1::RenderStreamResponse::kHeader:
        if (response->has_report()) {
          if (on_coarse) on_coarse(std::move(*response));
          response->Clear();
        }
        response->add_images()->Swap(part.mutable_header());
        break;
      case v1::RenderStreamResponse::kChunk:
        is_in_order &= response->images_size() > 0;
        if (is_in_order) response->mutable_images()->rbegin()->mutable_data()->append(part.chunk());
        break;
      case v1::RenderStreamResponse::kReport:
        response->mutable_report()->Swap(part.mutable_report());
        break;
      default:
        break;  // the plan, or what a later version adds
    }
  }
  grpc::Status status = stream->Finish();
  if (!status.ok() || (is_in_order && response->has_report())) return status;
  return {grpc::StatusCode::INTERNAL, "RenderStream: the server's stream has no report, or a chunk before its image"};
}

std::optional<std::string> PushbackOf(const grpc::ClientContext& context) {
  const auto& metadata = context.GetServerTrailingMetadata();
  const auto found = metadata.find("grpc-retry-pushback-ms");
  if (found == metadata.end()) return std::nullopt;
  return std::string(found->second.data(), found->second.size());
}

}  // namespace

Client::~Client() = default;

absl::StatusOr<std::unique_ptr<Client>> Client::Connect(ClientOptions options) {
  std::unique_ptr<Client> client(new Client);
  client->timeout_ = options.timeout;
  if (!options.is_timeout_per_call) client->begin_ = Clock::now();
  client->progress_ = std::move(options.progress);
  client->notice_ = std::move(options.notice);
  client->servers_ = options.servers;
  for (const std::string& server : client->servers_) client->channels_.push_back(CreateChannelTo(server));
  if (client->servers_.empty()) {
    absl::StatusOr<std::unique_ptr<Server>> server = Server::Start(options.in_process);
    if (!server.ok()) return absl::UnavailableError(server.status().message());
    client->in_process_ = *std::move(server);
    client->servers_ = {""};
    client->channels_ = {client->in_process_->InProcessChannel()};
  }
  return client;
}

std::shared_ptr<grpc::Channel> Client::ChannelTo(const std::string& server) const {
  const auto found = std::find(servers_.begin(), servers_.end(), server);
  return channels_[static_cast<size_t>(found - servers_.begin())];
}

Client::Clock::time_point Client::Deadline() const {
  return begin_.value_or(Clock::now()) + std::chrono::duration_cast<Clock::duration>(timeout_);
}

void Client::Report(const char* what, double done) const {
  if (progress_) progress_(what, done);
}

void Client::Notice(const std::string& sentence) const {
  if (notice_) notice_(sentence);
}

absl::Status Client::Call(const std::string& scene, const Attempt& attempt, const std::function<bool()>& got_on) const {
  const int max_attempts = servers_.size() > 1 ? kAttemptsWithOthers : kAttempts;
  const Clock::time_point deadline = Deadline();
  const Clock::time_point retry_until = std::min(deadline, begin_.value_or(Clock::now()) + kRetryWindow);
  for (int i = 0;; ++i) {
    grpc::ClientContext context;
    context.set_deadline(deadline);
    if (!scene.empty()) context.AddMetadata("x-halfshade-scene", scene);
    const grpc::Status status = attempt(&context);
    if (status.ok()) return absl::OkStatus();
    const bool is_stuck = !got_on || !got_on();
    if (!is_stuck) i = 0;
    const auto pause = RetryPause(status.error_code(), PushbackOf(context), i, max_attempts);
    if (!pause || Clock::now() + *pause >= (is_stuck ? retry_until : deadline)) return ToAbsl(status);
    Notice(absl::StrCat(status.error_message(), "; again in ", pause->count(), " ms"));
    std::this_thread::sleep_for(*pause);
  }
}

absl::Status Client::OnServersOf(const std::string& scene,
                                 const std::function<absl::Status(const std::string& server)>& work) {
  absl::Status status;
  for (const std::string& server : RendezvousOrder(servers_, scene)) {
    status = work(server);
    if (!absl::IsUnavailable(status)) break;
  }
  return status;
}

absl::Status Client::UploadBlob(const std::string& server, const std::string& scene, const SceneFile& file,
                                const std::function<void(size_t bytes)>& sent) {
  const auto stub = v1::SceneService::NewStub(ChannelTo(server));
  // What an earlier upload left, ours or another's, is not sent again. For one chunk the question is not worth a call.
  bool may_be_begun = file.bytes.size() > kChunkBytes;
  uint64_t begin = 0, furthest = 0;  // of the last attempt; of all
  const auto upload = [&](grpc::ClientContext* context) -> grpc::Status {
    begin = 0;
    if (may_be_begun) {
      grpc::ClientContext query_context;
      query_context.set_deadline(Deadline());
      query_context.AddMetadata("x-halfshade-scene", scene);
      v1::QueryUploadRequest query;
      query.set_digest(file.digest);
      v1::QueryUploadResponse progress;
      // Without an answer the upload starts over.
      if (stub->QueryUpload(&query_context, query, &progress).ok()) begin = progress.committed_bytes();
      if (progress.complete()) return grpc::Status::OK;
      if (begin > file.bytes.size()) begin = 0;
    }
    may_be_begun = true;
    v1::UploadBlobResponse response;
    const auto writer = stub->UploadBlob(context, &response);
    uint64_t offset = begin;
    do {
      v1::UploadBlobRequest chunk;
      chunk.set_digest(file.digest);
      chunk.set_size_bytes(file.bytes.size());
      chunk.set_offset_bytes(offset);
      chunk.set_data(file.bytes.substr(offset, kChunkBytes));
      if (!writer->Write(chunk)) break;
      offset += chunk.data().size();
      sent(offset);
    } while (offset < file.bytes.size());
    writer->WritesDone();
    return writer->Finish();
  };
  const auto got_on = [&] { return begin > std::exchange(furthest, std::max(furthest, begin)); };
  absl::Status status = Call(scene, upload, got_on);
  if (absl::IsInvalidArgument(status) && begin > 0) {
    // What was there does not fit our bytes, or went meanwhile.
    may_be_begun = false;
    status = Call(scene, upload, got_on);
  }
  return status;
}

absl::Status Client::UploadBlobs(const std::string& server, const SceneFiles& files) {
  v1::FindMissingBlobsRequest request;
  request.add_digests(files.root.digest);
  for (const SceneFile& file : files.files) request.add_digests(file.digest);
  v1::FindMissingBlobsResponse response;
  const auto stub = v1::SceneService::NewStub(ChannelTo(server));
  RETURN_IF_ERROR(Call(
      files.name, [&](grpc::ClientContext* context) { return stub->FindMissingBlobs(context, request, &response); }));
  std::set<std::string> missing(response.missing_digests().begin(), response.missing_digests().end());
  std::vector<const SceneFile*> to_send;
  size_t total_bytes = 0, done_bytes = 0;
  auto add_if_missing = [&](const SceneFile& file) {
    if (missing.erase(file.digest) == 0) return;
    to_send.push_back(&file);
    total_bytes += file.bytes.size();
  };
  add_if_missing(files.root);
  for (const SceneFile& file : files.files) add_if_missing(file);
  for (const SceneFile* file : to_send) {
    RETURN_IF_ERROR(UploadBlob(server, files.name, *file, [&](size_t bytes) {
      Report("upload", static_cast<double>(done_bytes + bytes) / static_cast<double>(std::max<size_t>(1, total_bytes)));
    }));
    done_bytes += file->bytes.size();
  }
  return absl::OkStatus();
}

absl::Status Client::UploadAndCreate(const std::string& server, const SceneFiles& files, v1::Scene* scene) {
  v1::CreateSceneRequest request;
  request.set_root_digest(files.root.digest);
  for (const SceneFile& file : files.files) (*request.mutable_files())[file.uri] = file.digest;
  v1::CreateSceneResponse response;
  const auto stub = v1::SceneService::NewStub(ChannelTo(server));
  absl::Status status;
  // A blob that was there may be gone a moment later: NOT_FOUND is worth a second round.
  for (int round = 0; round < 2; ++round) {
    RETURN_IF_ERROR(UploadBlobs(server, files));
    status =
        Call(files.name, [&](grpc::ClientContext* context) { return stub->CreateScene(context, request, &response); });
    if (!absl::IsNotFound(status)) break;
  }
  for (const std::string& warning : response.scene().warnings()) Notice(absl::StrCat("warning: ", warning));
  *scene = response.scene();
  return status;
}

absl::StatusOr<v1::Scene> Client::UploadScene(const SceneFiles& files) {
  v1::Scene scene;
  RETURN_IF_ERROR(
      OnServersOf(files.name, [&](const std::string& server) { return UploadAndCreate(server, files, &scene); }));
  return scene;
}

absl::Status Client::CallWithScene(const std::string& scene, const SceneFiles* files, const char* what,
                                   const RenderAttempt& attempt) {
  return OnServersOf(scene, [&](const std::string& server) {
    const auto stub = v1::RenderService::NewStub(ChannelTo(server));
    absl::Status status;
    // The same for a scene that is evicted between the calls.
    for (int round = 0; round < 2; ++round) {
      v1::Scene uploaded;
      if (files != nullptr) RETURN_IF_ERROR(UploadAndCreate(server, *files, &uploaded));
      Report(what, -1);
      status = Call(scene, [&](grpc::ClientContext* context) { return attempt(*stub, context); });
      if (files == nullptr || !absl::IsNotFound(status)) break;
    }
    return status;
  });
}

absl::StatusOr<v1::RenderResponse> Client::Render(const v1::RenderRequest& request, const SceneFiles* files,
                                                  const CoarseListener& on_coarse) {
  // Always the stream: whether a result fits Render depends on samples that the server alone chooses, and a small one
  // costs a message more.
  v1::RenderStreamRequest stream_request;
  *stream_request.mutable_request() = request;
  stream_request.set_progressive(bool(on_coarse));
  v1::RenderResponse response;
  RETURN_IF_ERROR(
      CallWithScene(request.scene(), files, "render", [&](v1::RenderService::Stub& stub, grpc::ClientContext* context) {
        return ReadStream(stub.RenderStream(context, stream_request).get(), on_coarse, &response);
      }));
  return response;
}

absl::StatusOr<v1::PlanRenderResponse> Client::PlanRender(const v1::PlanRenderRequest& plan, const SceneFiles* files) {
  v1::PlanRenderResponse response;
  RETURN_IF_ERROR(CallWithScene(plan.request().scene(), files, "plan",
                                [&](v1::RenderService::Stub& stub, grpc::ClientContext* context) {
                                  return stub.PlanRender(context, plan, &response);
                                }));
  return response;
}

absl::StatusOr<v1::QueryVisibilityResponse> Client::QueryVisibility(const v1::QueryVisibilityRequest& query,
                                                                    const SceneFiles* files) {
  v1::QueryVisibilityResponse response;
  RETURN_IF_ERROR(CallWithScene(query.request().scene(), files, "query",
                                [&](v1::RenderService::Stub& stub, grpc::ClientContext* context) {
                                  return stub.QueryVisibility(context, query, &response);
                                }));
  return response;
}

absl::StatusOr<v1::Scene> Client::GetScene(const std::string& name) {
  v1::GetSceneRequest request;
  request.set_name(name);
  v1::GetSceneResponse response;
  RETURN_IF_ERROR(OnServersOf(name, [&](const std::string& server) {
    const auto stub = v1::SceneService::NewStub(ChannelTo(server));
    return Call(name, [&](grpc::ClientContext* context) { return stub->GetScene(context, request, &response); });
  }));
  return response.scene();
}

absl::StatusOr<std::vector<v1::Scene>> Client::ListScenes(const std::string& server) {
  const auto stub = v1::SceneService::NewStub(ChannelTo(server));
  std::vector<v1::Scene> scenes;
  v1::ListScenesRequest request;
  do {
    v1::ListScenesResponse response;
    RETURN_IF_ERROR(
        Call("", [&](grpc::ClientContext* context) { return stub->ListScenes(context, request, &response); }));
    scenes.insert(scenes.end(), response.scenes().begin(), response.scenes().end());
    request.set_page_token(response.next_page_token());
  } while (!request.page_token().empty());
  return scenes;
}

absl::StatusOr<v1::GetServerInfoResponse> Client::GetServerInfo(const std::string& server) {
  const auto stub = v1::ServerService::NewStub(ChannelTo(server));
  v1::GetServerInfoResponse response;
  RETURN_IF_ERROR(Call("", [&](grpc::ClientContext* context) { return stub->GetServerInfo(context, {}, &response); }));
  return response;
}

absl::StatusOr<std::string> Client::CheckHealth(const std::string& server) {
  using google::protobuf::Empty;
  // grpc.health.v1 needs no generated code: an empty request asks for the whole server, and the reply's one field is
  // the enum {UNKNOWN, SERVING, NOT_SERVING} as number 1.
  grpc::TemplatedGenericStub<Empty, Empty> stub(ChannelTo(server));
  const Empty request;
  Empty response;
  RETURN_IF_ERROR(Call("", [&](grpc::ClientContext* context) {
    // Shared: set_value may still be at its end when get has returned.
    const auto done = std::make_shared<std::promise<grpc::Status>>();
    stub.UnaryCall(context, "/grpc.health.v1.Health/Check", {}, &request, &response,
                   [done](const grpc::Status& status) { done->set_value(status); });
    return done->get_future().get();
  }));
  const google::protobuf::UnknownFieldSet& fields = Empty::GetReflection()->GetUnknownFields(response);
  const uint64_t serving = fields.field_count() == 1 ? fields.field(0).varint() : 0;
  return serving == 1 ? "SERVING" : serving == 2 ? "NOT_SERVING" : "UNKNOWN";
}

}  // namespace halfshade
