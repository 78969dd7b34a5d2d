// The client library: scenes up, pictures down, from the service inside this process or from servers elsewhere.
//
// With several servers a scene's calls go to the one that rendezvous hashing names, and to the next where that one is
// UNAVAILABLE. Calls that fail for now are made again (client/retry.h) for at most a minute and within the timeout.
// Every call blocks; one Client may be used by several threads.
#pragma once

#include <absl/status/statusor.h>
#include <grpcpp/channel.h>
#include <grpcpp/client_context.h>

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "client/scene_files.h"
#include "halfshade/v1/render.grpc.pb.h"
#include "halfshade/v1/scene.pb.h"
#include "halfshade/v1/server.pb.h"
#include "server/server.h"

namespace halfshade {

// What is under way ("upload", "render") and how much of it is done, 0 to 1; below 0: not known.
using ProgressListener = std::function<void(const char* what, double done)>;
// A sentence for the user: a scene's warning, a pause before another attempt.
using NoticeListener = std::function<void(const std::string& sentence)>;

// A coarse result, before the whole one.
using CoarseListener = std::function<void(v1::RenderResponse coarse)>;

struct ClientOptions {
  std::vector<std::string> servers;  // "host:port" or "unix:path"; none: the service inside this process
  ServerOptions in_process;          // of that service
  // Of all calls together, from Connect on; or of each call of a Client's function with its retries.
  std::chrono::duration<double> timeout = std::chrono::minutes(10);
  bool is_timeout_per_call = false;
  ProgressListener progress;  // may be empty
  NoticeListener notice;      // may be empty
};

class Client {
 public:
  // Starts the service where it is to run in this process (UNAVAILABLE if it cannot); connects nowhere yet.
  static absl::StatusOr<std::unique_ptr<Client>> Connect(ClientOptions options);
  ~Client();

  // The servers; "" alone stands for the service in this process.
  const std::vector<std::string>& servers() const { return servers_; }

  // Uploads the files that the server lacks and makes the scene. The server's errors.
  absl::StatusOr<v1::Scene> UploadScene(const SceneFiles& files);

  // Renders request.scene, of any size that the server grants (RenderStream). `files`, where not null, is that scene:
  // it is uploaded first. With `on_coarse` progressively: it is told what comes before. The server's errors.
  absl::StatusOr<v1::RenderResponse> Render(const v1::RenderRequest& request, const SceneFiles* files,
                                            const CoarseListener& on_coarse = {});

  // What Render would do, of plan.request.scene; `files` as for Render.
  absl::StatusOr<v1::PlanRenderResponse> PlanRender(const v1::PlanRenderRequest& plan, const SceneFiles* files);

  // Visibility from points, of query.request.scene; `files` as for Render.
  absl::StatusOr<v1::QueryVisibilityResponse> QueryVisibility(const v1::QueryVisibilityRequest& query,
                                                              const SceneFiles* files);

  absl::StatusOr<v1::Scene> GetScene(const std::string& name);
  absl::StatusOr<std::vector<v1::Scene>> ListScenes(const std::string& server);
  absl::StatusOr<v1::GetServerInfoResponse> GetServerInfo(const std::string& server);
  // "SERVING", "NOT_SERVING", "UNKNOWN": grpc.health.v1 of the whole server.
  absl::StatusOr<std::string> CheckHealth(const std::string& server);

 private:
  using Clock = std::chrono::system_clock;
  using Attempt = std::function<grpc::Status(grpc::ClientContext*)>;

  Client() = default;

  std::shared_ptr<grpc::Channel> ChannelTo(const std::string& server) const;
  // Until when a call that begins now, and its retries, may go on.
  Clock::time_point Deadline() const;
  // Makes a call until it succeeds, fails for good, or time is up. `scene` goes along as metadata unless it is "".
  // `got_on`, where given, is asked after a failure whether the attempt came further than those before: such a one
  // counts as the first, and may come however late.
  absl::Status Call(const std::string& scene, const Attempt& attempt, const std::function<bool()>& got_on = {}) const;
  // Runs `work` on the scene's servers in rendezvous order until one is not UNAVAILABLE.
  absl::Status OnServersOf(const std::string& scene,
                           const std::function<absl::Status(const std::string& server)>& work);
  // Makes a call of RenderService on the scene's servers; `files`, where not null, go up first.
  using RenderAttempt = std::function<grpc::Status(v1::RenderService::Stub& stub, grpc::ClientContext*)>;
  absl::Status CallWithScene(const std::string& scene, const SceneFiles* files, const char* what,
                             const RenderAttempt& attempt);
  absl::Status UploadBlobs(const std::string& server, const SceneFiles& files);
  absl::Status UploadBlob(const std::string& server, const std::string& scene, const SceneFile& file,
                          const std::function<void(size_t bytes)>& sent);
  absl::Status UploadAndCreate(const std::string& server, const SceneFiles& files, v1::Scene* scene);
  void Report(const char* what, double done) const;
  void Notice(const std::string& sentence) const;

  std::vector<std::string> servers_;
  std::vector<std::shared_ptr<grpc::Channel>> channels_;  // of servers_
  std::unique_ptr<Server> in_process_;
  ProgressListener progress_;
  NoticeListener notice_;
  std::chrono::duration<double> timeout_{};
  std::optional<Clock::time_point> begin_;  // of the timeout; none: each call has its own
};

}  // namespace halfshade
