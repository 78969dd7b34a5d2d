#include "server/render_call.h"

#include <algorithm>
#include <utility>

#include "renderer/status.h"
#include "server/call_time.h"
#include "server/encode.h"
#include "server/gl_worker.h"
#include "server/report_to_proto.h"

namespace halfshade {
namespace {

using SystemClock = std::chrono::system_clock;
using SteadyClock = std::chrono::steady_clock;

double MillisecondsSince(SteadyClock::time_point begin) {
  return std::chrono::duration<double, std::milli>(SteadyClock::now() - begin).count();
}

}  // namespace

RenderCall::RenderCall(RenderPlant* plant, grpc::CallbackServerContext* context, const v1::RenderRequest& request,
                       const char* rpc, const Limits& limits)
    : plant_(plant), context_(context), request_(request), limits_(limits), call_(CallLog::Begin(rpc, *context)) {}

void RenderCall::Start() {
  self_ = shared_from_this();  // gRPC's share, until OnDone
  deadline_ = EffectiveDeadline(context_->deadline());
  if (const absl::Status status = CheckRenderFields(request_, limits_); !status.ok()) {
    Fail(status);
    return;
  }
  alarm_ = std::make_unique<grpc::Alarm>();
  alarm_->Set(deadline_, [self = shared_from_this()](bool is_due) {
    if (is_due) self->GiveUp(absl::DeadlineExceededError("the deadline passed"));
  });
  plant_->pool->Run([self = shared_from_this()] { self->Prepare(); }, call_.peer);
}

bool RenderCall::IsAwaited() const { return part_ == Part::kLeads && plant_->results->IsAwaited(result_key_); }

void RenderCall::LeaveResults() {
  const Part part = part_.exchange(Part::kAlone);
  if (part == Part::kLeads) plant_->results->Abandon(result_key_);
  if (part == Part::kWaits) plant_->results->Withdraw(result_key_, id());
}

absl::Status RenderCall::StopReason() const {
  if (plant_->is_stopping) return absl::UnavailableError("the server is stopping");
  if ((gave_up_ || SystemClock::now() >= deadline_) && IsAwaited()) return absl::OkStatus();
  if (gave_up_) return absl::CancelledError("given up");
  if (SystemClock::now() >= deadline_) return absl::DeadlineExceededError("the deadline passed");
  return absl::OkStatus();
}

void RenderCall::GiveUp(const absl::Status& reason) {
  gave_up_ = true;
  const bool never_runs = plant_->queue->Withdraw(id());
  // What is drawn ends by itself, when it is done or at the next StopReason.
  if (never_runs || part_ == Part::kWaits) LeaveResults();
  Fail(reason);
}

void RenderCall::Fail(const absl::Status& status) {
  if (is_finished_.exchange(true)) return;
  ++plant_->renders_failed;
  FinishRpc(plant_->log->End(call_, status, context_));
}

bool RenderCall::ClaimSuccess(const v1::RenderReport& report) {
  if (is_finished_.exchange(true)) return false;
  ++plant_->renders_ok;
  plant_->log->metrics()->CountRender(report);
  plant_->log->End(call_, absl::OkStatus(), context_);
  in_flight_ = {};  // before the caller can see the end and ask for more
  return true;
}

void RenderCall::Release() {
  alarm_.reset();
  self_.reset();
}

void RenderCall::Prepare() {
  if (gave_up_) return;
  auto scene = plant_->catalog->Load(request_.scene(), &load_ms_);
  if (!scene.ok()) {
    // The catalog's word for it is `name`; the request's is `scene`.
    Fail(scene.status());
    return;
  }
  scene_ = *std::move(scene);
  auto validated = ValidateRender(request_, *scene_, limits_);
  if (!validated.ok()) {
    Fail(validated.status());
    return;
  }
  render_ = *std::move(validated);
  auto plan = PlanRender(*scene_, render_.request);
  auto hold = plant_->in_flight->Take(render_.reply_bytes, "outputs");
  if (!plan.ok() || !hold.ok()) {
    Fail(plan.ok() ? hold.status() : plan.status());
    return;
  }
  in_flight_ = *std::move(hold);
  queued_at_ = SteadyClock::now();
  // What is measured is drawn, and what clocks decide need not come out alike.
  if (render_.request.cache == CacheMode::kUse && !request_.budget().has_max_latency()) {
    result_key_ = ContentKey(request_.scene(), render_, HALFSHADE_VERSION, "") +
                  request_.certify().SerializeAsString() + request_.budget().SerializeAsString() +
                  render_.request.method_reason;  // chosen or asked for: a report says which
    part_ = Part::kWaits;
    const bool leads =
        plant_->results->Lead(result_key_, id(), [self = shared_from_this()](const ResultCache::Reply& reply) {
          if (reply != nullptr) {
            self->Reuse(*reply);
          } else {
            self->part_ = Part::kLeads;
            self->plant_->pool->Run([self] { self->Enqueue(); }, self->call_.peer);
          }
        });
    if (leads) part_ = Part::kLeads;
    if (!leads && gave_up_) LeaveResults();
    if (!leads) {
      OnQueued(ToProto(*plan));
      return;
    }
  }
  if (Enqueue()) OnQueued(ToProto(*plan));
}

bool RenderCall::Enqueue() {
  if (gave_up_ && !IsAwaited()) {
    LeaveResults();
    return false;
  }
  RenderJob job;
  job.id = id();
  job.principal = call_.peer;
  // What light data hang on, nearly.
  job.affinity = request_.scene() + request_.method().SerializeAsString();
  for (const v1::AreaLight& light : request_.lights()) job.affinity += light.SerializeAsString();
  job.refuse = [self = shared_from_this()](const absl::Status& status) {
    self->LeaveResults();
    self->Fail(status);
  };
  job.run = [self = shared_from_this()](WorkerRenderer& worker) { return self->Draw(worker); };
  if (const absl::Status status = plant_->queue->Push(std::move(job), deadline_ - SystemClock::now()); !status.ok()) {
    LeaveResults();
    Fail(status);
    return false;
  }
  return true;
}

absl::Status RenderCall::Draw(WorkerRenderer& worker) {
  dequeued_at_ = SteadyClock::now();
  queue_ms_ = std::chrono::duration<double, std::milli>(dequeued_at_ - queued_at_).count();
  if (const absl::Status status = StopReason(); !status.ok()) {
    LeaveResults();
    Fail(status);
    return status;
  }
  const double cpu_begin = ProcessCpuMs();
  auto result = worker.renderer->Render(request_.scene(), *scene_, render_.request, [this] { return StopReason(); });
  cpu_ms_ = ProcessCpuMs() - cpu_begin;
  if (!result.ok()) {
    // Another context, or this one made anew, may still draw it.
    if (absl::IsUnavailable(result.status()) && StopReason().ok() && !std::exchange(is_redone_, true)) {
      Enqueue();
      return result.status();
    }
    LeaveResults();
    Fail(result.status());
    return result.status();
  }
  result_ = *std::move(result);
  gl_renderer_ = worker.gl_renderer;
  gl_version_ = worker.gl_version;
  plant_->encode_pool->Run([self = shared_from_this()] { self->EncodeAndDeliver(); }, call_.peer);
  return absl::OkStatus();
}

void RenderCall::EncodeAndDeliver() {
  if (gave_up_ && !IsAwaited()) {
    LeaveResults();
    return;
  }
  grids_.clear();
  for (const RenderedImage& image : result_.images) grids_.push_back(image.grid);
  auto encoded = Encode(std::move(result_.images), render_.formats, [this] { return StopReason(); });
  if (!encoded.ok()) {
    LeaveResults();
    Fail(encoded.status());
    return;
  }
  v1::RenderResponse response;
  *response.mutable_report() = ToProto(result_.report);
  for (size_t i = 0; i < encoded->size(); ++i) AddImage(i, std::move((*encoded)[i]), &response);
  CompleteReport(response.mutable_report());
  if (part_ == Part::kLeads && plant_->results->Wants(result_key_, response.ByteSizeLong())) {
    part_ = Part::kAlone;
    plant_->results->Publish(result_key_, std::make_shared<const v1::RenderResponse>(response));
  }
  LeaveResults();
  if (!gave_up_) Deliver(std::move(response));
}

void RenderCall::Reuse(const v1::RenderResponse& reply) {
  part_ = Part::kAlone;
  if (gave_up_) return;
  dequeued_at_ = SteadyClock::now();
  queue_ms_ = std::chrono::duration<double, std::milli>(dequeued_at_ - queued_at_).count();
  v1::RenderResponse response = reply;
  v1::RenderReport* report = response.mutable_report();
  report->clear_timing();
  report->clear_passes();
  v1::Pass* pass = report->add_passes();
  pass->set_name("render");
  pass->set_skipped(true);
  pass->set_reason("an identical request was rendered before, or at the same time");
  report->clear_caches();
  v1::Cache* cache = report->add_caches();
  cache->set_name("result");
  cache->set_hits(1);
  cache->set_bytes(response.ByteSizeLong());
  SetTiming(report->mutable_timing());
  Deliver(std::move(response));
}

void RenderCall::AddImage(size_t index, EncodedOutput encoded, v1::RenderResponse* response) const {
  const OutputFormat& format = render_.formats[index];
  v1::OutputImage* image = response->add_images();
  image->set_kind(ToProto(render_.request.outputs[index]));
  image->set_encoding(ToProto(format.encoding));
  image->set_layer(format.layer);
  image->set_data(std::move(encoded.bytes));
  const glm::ivec2 size = SizeOf(render_.request, render_.request.outputs[index]);
  image->set_width(uint32_t(size.x));
  image->set_height(uint32_t(size.y));
  image->set_channels(uint32_t(format.channels.size()));
  if (const auto& grid = grids_[index]) {
    for (int i = 0; i < 16; ++i) image->add_light_from_world(grid->light_from_world[i / 4][i % 4]);
    for (int i = 0; i < 4; ++i) image->add_window(grid->window[i]);
  }
  v1::OutputReport* report = response->mutable_report()->add_outputs();
  report->set_kind(ShortName(image->kind()));
  report->set_encoding(ShortName(image->encoding()));
  report->set_width(image->width());
  report->set_height(image->height());
  report->set_channels(image->channels());
  report->set_pixel_sha256(encoded.pixel_sha256);
  v1::Timing* timing = response->mutable_report()->mutable_timing();
  timing->set_encode_ms(timing->encode_ms() + encoded.encode_ms);
  timing->set_digest_ms(timing->digest_ms() + encoded.digest_ms);
}

void RenderCall::SetTiming(v1::Timing* timing) const {
  timing->set_queue_ms(queue_ms_);
  timing->set_load_ms(load_ms_);
  timing->set_cpu_ms(cpu_ms_);
  timing->set_total_ms(MillisecondsSince(dequeued_at_));
}

void RenderCall::CompleteReport(v1::RenderReport* report) const {
  SetTiming(report->mutable_timing());
  v1::Cache* cache = report->add_caches();
  cache->set_name("scene");
  cache->set_hits(load_ms_ == 0);
  cache->set_misses(load_ms_ > 0);
  cache->set_bytes(scene_->SizeBytes());
  report->set_gl_renderer(gl_renderer_);
  report->set_gl_version(gl_version_);
  report->set_server_version(HALFSHADE_VERSION);
  report->set_content_key(ContentKey(request_.scene(), render_, HALFSHADE_VERSION, gl_renderer_));
}

}  // namespace halfshade
