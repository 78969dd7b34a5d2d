#include "server/render_service.h"

#include <grpcpp/alarm.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <memory>

#include "renderer/status.h"
#include "server/call_time.h"
#include "server/encode.h"
#include "server/gl_worker.h"
#include "server/query_service.h"
#include "server/report_to_proto.h"
#include "server/request_id.h"
#include "server/status.h"
#include "server/validate.h"

namespace halfshade {
namespace {

using SystemClock = std::chrono::system_clock;
using SteadyClock = std::chrono::steady_clock;

double MillisecondsSince(SteadyClock::time_point begin) {
  return std::chrono::duration<double, std::milli>(SteadyClock::now() - begin).count();
}

std::string OutputName(OutputKind kind) { return kind == OutputKind::kFrame ? "FRAME" : "VISIBILITY"; }
std::string EncodingName(Encoding encoding) { return encoding == Encoding::kPng ? "PNG" : "RAW_F32"; }

// One Render call. Shared by gRPC, its alarm, the pool and the queue; the last of them lets go.
class RenderCall final : public grpc::ServerUnaryReactor, public std::enable_shared_from_this<RenderCall> {
 public:
  RenderCall(RenderPlant* plant, grpc::CallbackServerContext* context, const v1::RenderRequest* request,
             v1::RenderResponse* response)
      : plant_(plant), context_(context), request_(*request), response_(response), id_(NextRequestId()) {}

  void Start() {
    self_ = shared_from_this();  // gRPC's share, until OnDone
    deadline_ = EffectiveDeadline(context_->deadline());
    if (const absl::Status status = CheckRenderFields(request_, plant_->limits); !status.ok()) {
      FinishOnce(status);
      return;
    }
    alarm_.Set(deadline_, [self = shared_from_this()](bool is_due) {
      if (is_due) self->GiveUp(absl::DeadlineExceededError("the deadline passed"));
    });
    plant_->pool->Run([self = shared_from_this()] { self->Prepare(); });
  }

  void OnCancel() override { GiveUp(absl::CancelledError("cancelled by the client")); }

  void OnDone() override {
    alarm_.Cancel();
    self_.reset();
  }

 private:
  // Asked between GL submissions.
  absl::Status StopReason() const {
    if (plant_->is_stopping) return absl::UnavailableError("the server is stopping");
    if (gave_up_) return absl::CancelledError("given up");
    if (SystemClock::now() >= deadline_) return absl::DeadlineExceededError("the deadline passed");
    return absl::OkStatus();
  }

  // A call that waits is answered now; one that is drawn stops at its next submission, and is answered now too.
  void GiveUp(const absl::Status& reason) {
    gave_up_ = true;
    plant_->queue->Withdraw(uint64_t(reinterpret_cast<uintptr_t>(this)));
    FinishOnce(reason);
  }

  // On the pool: the scene and the plain request, then into the queue.
  void Prepare() {
    if (gave_up_) return;
    auto scene = plant_->catalog->Load(request_.scene(), &load_ms_);
    if (!scene.ok()) {
      // The catalog's word for it is `name`; the request's is `scene`.
      FinishOnce(scene.status());
      return;
    }
    scene_ = *std::move(scene);
    auto validated = ValidateRender(request_, *scene_, plant_->limits);
    if (!validated.ok()) {
      FinishOnce(validated.status());
      return;
    }
    render_ = *std::move(validated);
    queued_at_ = SteadyClock::now();
    RenderJob job;
    job.id = uint64_t(reinterpret_cast<uintptr_t>(this));
    job.run = [self = shared_from_this()](WorkerRenderer& worker) { self->Draw(worker); };
    if (const absl::Status status = plant_->queue->Push(std::move(job), deadline_ - SystemClock::now()); !status.ok()) {
      FinishOnce(status);
    }
  }

  // On a GL thread.
  void Draw(WorkerRenderer& worker) {
    dequeued_at_ = SteadyClock::now();
    queue_ms_ = std::chrono::duration<double, std::milli>(dequeued_at_ - queued_at_).count();
    if (const absl::Status status = StopReason(); !status.ok()) {
      FinishOnce(status);
      return;
    }
    const double cpu_begin = ProcessCpuMs();
    auto result = worker.renderer->Render(request_.scene(), *scene_, render_.request, [this] { return StopReason(); });
    cpu_ms_ = ProcessCpuMs() - cpu_begin;
    if (!result.ok()) {
      FinishOnce(result.status());
      return;
    }
    result_ = *std::move(result);
    gl_renderer_ = worker.gl_renderer;
    gl_version_ = worker.gl_version;
    plant_->pool->Run([self = shared_from_this()] { self->EncodeAndFinish(); });
  }

  // On the pool.
  void EncodeAndFinish() {
    if (gave_up_) return;
    v1::RenderResponse response;
    v1::RenderReport* report = response.mutable_report();
    *report = ToProto(result_.report);
    for (size_t i = 0; i < result_.images.size(); ++i) {
      const RenderedImage& rendered = result_.images[i];
      auto encoded = Encode(rendered, render_.encodings[i]);
      if (!encoded.ok()) {
        FinishOnce(encoded.status());
        return;
      }
      report->mutable_timing()->set_encode_ms(report->timing().encode_ms() + encoded->encode_ms);
      report->mutable_timing()->set_digest_ms(report->timing().digest_ms() + encoded->digest_ms);
      AddImage(int(i), rendered, *std::move(encoded), &response);
    }
    v1::Timing* timing = report->mutable_timing();
    timing->set_queue_ms(queue_ms_);
    timing->set_load_ms(load_ms_);
    timing->set_cpu_ms(cpu_ms_);
    timing->set_total_ms(MillisecondsSince(dequeued_at_));
    v1::Cache* cache = report->add_caches();
    cache->set_name("scene");
    cache->set_hits(load_ms_ == 0);
    cache->set_misses(load_ms_ > 0);
    cache->set_bytes(scene_->SizeBytes());
    report->set_gl_renderer(gl_renderer_);
    report->set_gl_version(gl_version_);
    report->set_server_version(HALFSHADE_VERSION);
    report->set_content_key(ContentKey(request_.scene(), render_, HALFSHADE_VERSION, gl_renderer_));
    if (is_finished_.exchange(true)) return;
    ++plant_->renders_ok;
    response_->Swap(&response);
    Finish(grpc::Status::OK);
  }

  void AddImage(int index, const RenderedImage& rendered, EncodedImage2D encoded, v1::RenderResponse* response) const {
    const v1::Output& asked =
        index < request_.outputs_size() ? request_.outputs(index) : v1::Output::default_instance();
    v1::OutputImage* image = response->add_images();
    image->set_kind(rendered.kind == OutputKind::kFrame ? v1::OUTPUT_KIND_FRAME : v1::OUTPUT_KIND_VISIBILITY);
    image->set_encoding(render_.encodings[size_t(index)] == Encoding::kPng ? v1::ENCODING_PNG : v1::ENCODING_RAW_F32);
    image->set_layer(asked.layer());
    image->set_data(std::move(encoded.bytes));
    image->set_width(uint32_t(rendered.image.width()));
    image->set_height(uint32_t(rendered.image.height()));
    image->set_channels(uint32_t(encoded.channels));
    v1::OutputReport* report = response->mutable_report()->add_outputs();
    report->set_kind(OutputName(rendered.kind));
    report->set_encoding(EncodingName(render_.encodings[size_t(index)]));
    report->set_width(image->width());
    report->set_height(image->height());
    report->set_channels(image->channels());
    report->set_pixel_sha256(encoded.pixel_sha256);
  }

  void FinishOnce(const absl::Status& status) {
    if (is_finished_.exchange(true)) return;
    ++plant_->renders_failed;
    if (absl::IsInternal(status)) {
      spdlog::error("{} Render {}", id_, status.ToString());
    } else {
      spdlog::info("{} Render {}", id_, status.ToString());
    }
    if (const std::string pushback = PushbackMs(status); !pushback.empty()) {
      context_->AddTrailingMetadata(kPushbackKey, pushback);
    }
    Finish(ToGrpcStatus(status, id_));
  }

  RenderPlant* plant_;
  grpc::CallbackServerContext* context_;
  const v1::RenderRequest request_;
  v1::RenderResponse* response_;
  const std::string id_;
  std::shared_ptr<RenderCall> self_;
  grpc::Alarm alarm_;
  SystemClock::time_point deadline_;
  std::atomic<bool> gave_up_{false};
  std::atomic<bool> is_finished_{false};
  SceneCache::ScenePtr scene_;
  ValidatedRender render_;
  RenderResult result_;
  SteadyClock::time_point queued_at_, dequeued_at_;
  double load_ms_ = 0, queue_ms_ = 0, cpu_ms_ = 0;
  std::string gl_renderer_, gl_version_;
};

grpc::Status NotInThisVersion(const char* rpc) {
  return grpc::Status(grpc::StatusCode::UNIMPLEMENTED,
                      std::string("RenderService.") + rpc + " is not available in this version");
}

grpc::ServerUnaryReactor* FinishAtOnce(grpc::CallbackServerContext* context, const grpc::Status& status) {
  grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
  reactor->Finish(status);
  return reactor;
}

class FinishedStream final : public grpc::ServerWriteReactor<v1::RenderStreamResponse> {
 public:
  explicit FinishedStream(const grpc::Status& status) { Finish(status); }
  void OnDone() override { delete this; }
};

}  // namespace

grpc::ServerUnaryReactor* RenderServiceImpl::Render(grpc::CallbackServerContext* context,
                                                    const v1::RenderRequest* request, v1::RenderResponse* response) {
  const auto call = std::make_shared<RenderCall>(plant_, context, request, response);
  call->Start();
  return call.get();
}

grpc::ServerWriteReactor<v1::RenderStreamResponse>* RenderServiceImpl::RenderStream(grpc::CallbackServerContext*,
                                                                                    const v1::RenderStreamRequest*) {
  return new FinishedStream(NotInThisVersion("RenderStream"));
}

grpc::ServerUnaryReactor* RenderServiceImpl::PlanRender(grpc::CallbackServerContext* context,
                                                        const v1::PlanRenderRequest*, v1::PlanRenderResponse*) {
  return FinishAtOnce(context, NotInThisVersion("PlanRender"));
}

grpc::ServerUnaryReactor* RenderServiceImpl::QueryVisibility(grpc::CallbackServerContext* context,
                                                             const v1::QueryVisibilityRequest* request,
                                                             v1::QueryVisibilityResponse* response) {
  return StartQuery(plant_, context, *request, response);
}

}  // namespace halfshade
