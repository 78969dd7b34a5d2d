#include "server/server.h"

#include <grpcpp/ext/channelz_service_plugin.h>
#include <grpcpp/ext/proto_server_reflection_plugin.h>
#include <grpcpp/health_check_service_interface.h>
#include <grpcpp/server.h>
#include <grpcpp/server_builder.h>
#include <spdlog/spdlog.h>

#include <chrono>
#include <mutex>
#include <thread>

#include "renderer/status.h"
#include "server/call_log.h"
#include "server/cpu_pool.h"
#include "server/derived_store.h"
#include "server/gl_worker_pool.h"
#include "server/http.h"
#include "server/metrics.h"
#include "server/render_service.h"
#include "server/scene_catalog.h"
#include "server/scene_service.h"
#include "server/server_service.h"

namespace halfshade {
namespace {

// They wait for the disk more than they compute.
constexpr int kPoolThreads = 2;
// A call for a scene that another one is loading waits on its thread.
constexpr int kScenePoolThreads = 4;
constexpr int kDiskPoolThreads = 2;

void SetLimits(const Limits& limits, v1::Limits* out) {
  out->set_message_bytes(limits.message_bytes);
  out->set_metadata_bytes(limits.metadata_bytes);
  out->set_streams_per_connection(limits.streams_per_connection);
  out->set_image_width(limits.image_width);
  out->set_image_height(limits.image_height);
  out->set_scene_bytes(limits.scene_bytes);
  out->set_scene_triangles(limits.scene_triangles);
  out->set_lights(limits.lights);
  out->set_texture_pixels(limits.texture_pixels);
  out->set_gltf_json_bytes(limits.gltf_json_bytes);
  out->set_gltf_json_depth(limits.gltf_json_depth);
  out->set_queue(limits.queue);
  out->set_render_reply_bytes(limits.render_reply_bytes);
}

void SetChannelLimits(const Limits& limits, const ConnectionTimes& times, grpc::ServerBuilder& builder) {
  builder.SetMaxReceiveMessageSize(int(limits.message_bytes));
  builder.AddChannelArgument(GRPC_ARG_MAX_METADATA_SIZE, int(limits.metadata_bytes));
  builder.AddChannelArgument(GRPC_ARG_MAX_CONCURRENT_STREAMS, int(limits.streams_per_connection));
  builder.AddChannelArgument(GRPC_ARG_SERVER_HANDSHAKE_TIMEOUT_MS, times.handshake_ms);
  builder.AddChannelArgument(GRPC_ARG_MAX_CONNECTION_AGE_MS, times.age_ms);
  builder.AddChannelArgument(GRPC_ARG_MAX_CONNECTION_AGE_GRACE_MS, times.age_grace_ms);
  builder.AddChannelArgument(GRPC_ARG_MAX_CONNECTION_IDLE_MS, times.idle_ms);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIME_MS, times.keepalive_ms);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, times.keepalive_timeout_ms);
  builder.AddChannelArgument(GRPC_ARG_ALLOW_REUSEPORT, 0);  // a second server on the port is an error, not a rival
  // One gzip message of zeros costs hundreds of MB before its size is known.
  builder.SetCompressionAlgorithmSupportStatus(GRPC_COMPRESS_GZIP, false);
  builder.SetCompressionAlgorithmSupportStatus(GRPC_COMPRESS_DEFLATE, false);
}

absl::Status AddressError(const std::string& flag, const std::string& address) {
  return absl::FailedPreconditionError(flag + " " + address + ": the address cannot be had");
}

// What was picked in place of port 0.
std::string AddressWithPort(const std::string& address, int port) {
  if (address.starts_with("unix:")) return address;
  return address.substr(0, address.rfind(':') + 1) + std::to_string(port);
}

class WiredServer final : public Server {
 public:
  explicit WiredServer(const ServerOptions& options)
      : options_(options),
        cache_(options.scene_cache_mb << 20, [this](const std::string& name) { workers_.ForgetScene(name); }),
        queue_(options.limits.queue, options.contexts),
        in_flight_(options.in_flight_mb << 20),
        results_(options.result_cache_mb << 20),
        disk_pool_(kDiskPoolThreads),
        pool_(kPoolThreads),
        scene_pool_(kScenePoolThreads),
        encode_pool_(gl::AvailableCpus()) {}

  ~WiredServer() override {
    plant_.is_stopping = true;
    TellHealth();
    if (server_ != nullptr) server_->Shutdown(std::chrono::system_clock::now());
    queue_.Close();
    // First gRPC, then the contexts; then the pools that they hand results to, which may still tell them to forget a
    // scene.
    std::unique_ptr<grpc::Server> server;
    {
      const std::lock_guard lock(health_mutex_);
      server.swap(server_);
    }
    server.reset();
    workers_.Join();
  }

  absl::Status Start() {
    if (options_.http != "off") {
      ASSIGN_OR_RETURN(
          http_, HttpServer::Start(options_.http, &is_ready_, [this] {
            // Before the start is through there is nothing to sample.
            const std::lock_guard lock(health_mutex_);
            return metrics_.Text(server_ == nullptr ? std::vector<Metrics::Sample>() : server_service_->Samples());
          }));
    }
    StoreOptions store_options;
    store_options.max_bytes = options_.scene_store_mb << 20;
    store_options.max_unfinished = options_.limits.unfinished_uploads;
    ASSIGN_OR_RETURN(store_, Store::Open(options_.scene_store_dir, store_options));
    // A private folder is gone before anyone comes back to it.
    if (!options_.scene_store_dir.empty() && options_.keeps_store) {
      derived_store_ = std::make_unique<DerivedStore>(store_.get(), &disk_pool_);
    }
    if (options_.fence.loader.empty()) {
      reader_ = ReadInProcess();
    } else {
      ASSIGN_OR_RETURN(reader_, Fence::Raise(options_.fence));
    }
    const auto decode = [this](const EncodedImage& image) {
      return reader_->Decode(image, options_.limits.texture_pixels);
    };
    RETURN_IF_ERROR(workers_.Start(options_, &queue_, derived_store_.get(), decode, [this](int lost) {
      lost_contexts_ = lost;
      TellHealth();
    }));
    ASSIGN_OR_RETURN(catalog_,
                     SceneCatalog::Open(store_.get(), &cache_, reader_.get(), derived_store_.get(), options_.limits));
    plant_.catalog = catalog_.get();
    plant_.machine = workers_.machine();
    plant_.pool = &pool_;
    plant_.encode_pool = &encode_pool_;
    plant_.in_flight = &in_flight_;
    plant_.results = &results_;
    plant_.log = &log_;
    plant_.stream_stall = std::chrono::seconds(options_.stream_stall_s);
    plant_.queue = &queue_;
    plant_.limits = options_.limits;
    scene_service_ = std::make_unique<SceneServiceImpl>(store_.get(), catalog_.get(), &scene_pool_, &disk_pool_, &log_,
                                                        options_.limits);
    render_service_ = std::make_unique<RenderServiceImpl>(&plant_);
    server_service_ = std::make_unique<ServerServiceImpl>(Describe(), &plant_, store_.get(), &cache_, &workers_);
    return Listen();
  }

  std::shared_ptr<grpc::Channel> InProcessChannel() override {
    grpc::ChannelArguments arguments;
    arguments.SetMaxReceiveMessageSize(-1);
    return server_->InProcessChannel(arguments);
  }
  std::string grpc_address() const override { return grpc_address_; }
  std::string admin_address() const override { return admin_address_; }
  std::string http_address() const override { return http_ == nullptr ? "off" : http_->address(); }

  void Drain() override {
    is_draining_ = true;
    TellHealth();
    std::this_thread::sleep_for(std::chrono::seconds(options_.lame_duck_s));
    server_->Shutdown(std::chrono::system_clock::now() + std::chrono::seconds(options_.grace_s));
  }

 private:
  // SERVING while every context draws and nothing drains.
  void TellHealth() {
    const std::lock_guard lock(health_mutex_);
    is_ready_ = server_ != nullptr && !is_draining_ && !plant_.is_stopping && lost_contexts_ == 0;
    auto* health = server_ == nullptr ? nullptr : server_->GetHealthCheckService();
    if (health != nullptr) health->SetServingStatus(is_ready_);
  }

  v1::GetServerInfoResponse Describe() const {
    v1::GetServerInfoResponse info;
    info.set_version(HALFSHADE_VERSION);
    for (const auto& worker : workers_.workers()) {
      v1::ContextInfo* context = info.add_contexts();
      context->set_gl_renderer(worker->gl_renderer());
      context->set_gl_version(worker->gl_version());
      context->set_description(worker->description());
    }
    SetLimits(options_.limits, info.mutable_limits());
    for (const std::string& method : RegisteredMethods()) info.add_methods(method);
    for (const char* feature : {"find_missing_blobs", "upload_blob", "query_upload", "create_scene", "get_scene",
                                "list_scenes", "delete_scene", "render", "render_stream", "plan_render",
                                "query_visibility", "get_server_info", "get_statistics"}) {
      info.add_features(feature);
    }
    return info;
  }

  absl::Status Listen() {
    grpc::EnableDefaultHealthCheckService(true);
    grpc::reflection::InitProtoReflectionServerBuilderPlugin();
    grpc::ServerBuilder builder;
    SetChannelLimits(options_.limits, options_.connections, builder);
    int port = 0;
    const bool has_port = !options_.listen.empty();
    if (has_port) builder.AddListeningPort(options_.listen, grpc::InsecureServerCredentials(), &port);
    builder.RegisterService(scene_service_.get());
    builder.RegisterService(render_service_.get());
    builder.RegisterService(server_service_.get());
    {
      const std::lock_guard lock(health_mutex_);
      server_ = builder.BuildAndStart();
    }
    if (server_ == nullptr || (has_port && port == 0)) return AddressError("listen", options_.listen);
    if (has_port) grpc_address_ = AddressWithPort(options_.listen, port);
    RETURN_IF_ERROR(ListenForAdmins());
    TellHealth();
    return absl::OkStatus();
  }

  // After the service's own server: a plugin of gRPC's is one of every server that is built later.
  absl::Status ListenForAdmins() {
    if (options_.admin == "off") return absl::OkStatus();
    grpc::EnableDefaultHealthCheckService(false);
    grpc::channelz::experimental::InitChannelzService();
    grpc::ServerBuilder builder;
    SetChannelLimits(options_.limits, options_.connections, builder);
    int port = 0;
    builder.AddListeningPort(options_.admin, grpc::InsecureServerCredentials(), &port);
    admin_server_ = builder.BuildAndStart();
    if (admin_server_ == nullptr || port == 0) return AddressError("admin", options_.admin);
    admin_address_ = AddressWithPort(options_.admin, port);
    return absl::OkStatus();
  }

  const ServerOptions options_;
  std::mutex health_mutex_;  // over server_ where workers see it too
  std::atomic<bool> is_ready_{false};
  std::atomic<bool> is_draining_{false};
  std::atomic<int> lost_contexts_{0};
  Metrics metrics_;
  CallLog log_{&metrics_};
  std::unique_ptr<Store> store_;
  std::unique_ptr<DerivedStore> derived_store_;  // as workers and pools, which use it, need it
  std::unique_ptr<SceneReader> reader_;
  SceneCache cache_;
  std::unique_ptr<SceneCatalog> catalog_;
  RenderPlant plant_;
  RenderQueue queue_;
  ByteBudget in_flight_;
  ResultCache results_;
  GlWorkerPool workers_;  // outlives the pools
  CpuPool disk_pool_;     // outlives those that load scenes, and leave it their flat forms
  CpuPool pool_;
  CpuPool scene_pool_;
  CpuPool encode_pool_;
  std::unique_ptr<SceneServiceImpl> scene_service_;
  std::unique_ptr<RenderServiceImpl> render_service_;
  std::unique_ptr<ServerServiceImpl> server_service_;
  std::unique_ptr<grpc::Server> server_;
  std::string grpc_address_;
  std::unique_ptr<grpc::Server> admin_server_;
  std::string admin_address_ = "off";
  std::unique_ptr<HttpServer> http_;  // asks all of the above
};

}  // namespace

absl::StatusOr<std::unique_ptr<Server>> Server::Start(const ServerOptions& options) {
  auto server = std::make_unique<WiredServer>(options);
  RETURN_IF_ERROR(server->Start());
  return server;
}

}  // namespace halfshade
