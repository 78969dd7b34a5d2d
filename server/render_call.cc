#include "server/render_call.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "renderer/plan/coarse_request.h"
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
                       const char* rpc, const Limits& limits, bool is_progressive)
    : plant_(plant),
      context_(context),
      request_(request),
      limits_(limits),
      call_(CallLog::Begin(rpc, *context)),
      is_progressive_(is_progressive) {}

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
  coarse_in_flight_ = {};
  in_flight_ = {};  // before the caller can see the end and ask for more
  return true;
}

void RenderCall::Release() {
  alarm_.reset();
  self_.reset();
}

void RenderCall::Prepare() {
  if (gave_up_) return;
  auto posed = plant_->catalog->LoadPosed(request_, &load_ms_);
  if (!posed.ok()) {
    // The catalog's word for it is `name`; the request's is `scene`.
    Fail(posed.status());
    return;
  }
  scene_ = std::move(posed->scene);
  posed_name_ = std::move(posed->name);
  auto validated = ValidateRender(request_, *scene_, limits_, plant_->machine);
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
  if (is_progressive_) PlanCoarse();
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

void RenderCall::PlanCoarse() {
  const auto pose = BuildPose(*scene_, render_.request.scene_index, render_.request.node_overrides);
  if (!pose.ok()) return;  // PlanRender has said so
  uint64_t bytes = 0;
  for (RenderRequest& request : PlanCoarseRequests(*scene_, *pose, render_.request)) {
    ValidatedRender& coarse =
        coarse_.emplace_back(ValidatedRender{std::move(request), render_.morph_weights, render_.formats});
    for (size_t i = 0; i < coarse.formats.size(); ++i) {
      const glm::ivec2 size = SizeOf(coarse.request, coarse.request.outputs[i]);
      coarse.reply_bytes += UncompressedBytes(coarse.formats[i], size.x, size.y);
    }
    bytes += coarse.reply_bytes;
  }
  auto hold = plant_->in_flight->Take(bytes, "outputs");
  if (hold.ok()) {
    coarse_in_flight_ = *std::move(hold);
  } else {
    coarse_.clear();
  }
}

absl::Status RenderCall::Draw(WorkerRenderer& worker) {
  dequeued_at_ = SteadyClock::now();
  queue_ms_ = std::chrono::duration<double, std::milli>(dequeued_at_ - queued_at_).count();
  if (const absl::Status status = StopReason(); !status.ok()) {
    LeaveResults();
    Fail(status);
    return status;
  }
  gl_renderer_ = worker.gl_renderer;
  gl_version_ = worker.gl_version;
  cpu_begin_ms_ = ProcessCpuMs();
  for (const ValidatedRender& coarse : coarse_) {
    if (gave_up_ || is_redone_) break;  // those that wait for the whole get none; none is sent twice
    RETURN_IF_ERROR(DrawOne(worker, coarse));
  }
  return DrawOne(worker, render_);
}

absl::Status RenderCall::DrawOne(WorkerRenderer& worker, const ValidatedRender& render) {
  auto result = worker.renderer->Render(posed_name_, *scene_, render.request, [this] { return StopReason(); });
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
  const std::lock_guard lock(drawn_mutex_);
  drawn_.push_back({&render, *std::move(result), ProcessCpuMs() - cpu_begin_ms_});
  if (is_encoding_) return absl::OkStatus();
  is_encoding_ = true;
  plant_->encode_pool->Run([self = shared_from_this()] { self->EncodeAll(); }, call_.peer);
  return absl::OkStatus();
}

void RenderCall::EncodeAll() {
  while (true) {
    Drawn drawn;
    {
      const std::lock_guard lock(drawn_mutex_);
      is_encoding_ = !drawn_.empty();
      if (!is_encoding_) return;
      drawn = std::move(drawn_.front());
      drawn_.pop_front();
    }
    if (!EncodeAndDeliver(std::move(drawn))) return;
  }
}

bool RenderCall::EncodeAndDeliver(Drawn drawn) {
  if (gave_up_ && !IsAwaited()) {
    LeaveResults();
    return false;
  }
  const bool is_whole = drawn.render == &render_;
  if (gave_up_ && !is_whole) return true;
  std::vector<std::optional<LightGrid>> grids;
  for (const RenderedImage& image : drawn.result.images) grids.push_back(image.grid);
  auto encoded = Encode(std::move(drawn.result.images), drawn.render->formats, [this] { return StopReason(); });
  if (!encoded.ok()) {
    LeaveResults();
    Fail(encoded.status());
    return false;
  }
  v1::RenderResponse response = MakeResponse(drawn, grids, *std::move(encoded));
  if (!is_whole) {
    DeliverCoarse(std::move(response));
    return true;
  }
  if (part_ == Part::kLeads && plant_->results->Wants(result_key_, response.ByteSizeLong())) {
    part_ = Part::kAlone;
    plant_->results->Publish(result_key_, std::make_shared<const v1::RenderResponse>(response));
  }
  LeaveResults();
  if (!gave_up_) Deliver(std::move(response));
  return true;
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
  SetTiming(0, report->mutable_timing());
  Deliver(std::move(response));
}

v1::RenderResponse RenderCall::MakeResponse(const Drawn& drawn, const std::vector<std::optional<LightGrid>>& grids,
                                            std::vector<EncodedOutput> encoded) const {
  const RenderRequest& request = drawn.render->request;
  v1::RenderResponse response;
  v1::RenderReport* report = response.mutable_report();
  *report = ToProto(drawn.result.report);
  v1::Timing* timing = report->mutable_timing();
  for (size_t i = 0; i < encoded.size(); ++i) {
    const OutputFormat& format = drawn.render->formats[i];
    v1::OutputImage* image = response.add_images();
    image->set_kind(ToProto(request.outputs[i]));
    image->set_encoding(ToProto(format.encoding));
    image->set_layer(format.layer);
    image->set_data(std::move(encoded[i].bytes));
    const glm::ivec2 size = SizeOf(request, request.outputs[i]);
    image->set_width(uint32_t(size.x));
    image->set_height(uint32_t(size.y));
    image->set_channels(uint32_t(format.channels.size()));
    if (const auto& grid = grids[i]) {
      for (int k = 0; k < 16; ++k) image->add_light_from_world(grid->light_from_world[k / 4][k % 4]);
      for (int k = 0; k < 4; ++k) image->add_window(grid->window[k]);
    }
    v1::OutputReport* output = report->add_outputs();
    output->set_kind(ShortName(image->kind()));
    output->set_encoding(ShortName(image->encoding()));
    output->set_width(image->width());
    output->set_height(image->height());
    output->set_channels(image->channels());
    output->set_pixel_sha256(encoded[i].pixel_sha256);
    timing->set_encode_ms(timing->encode_ms() + encoded[i].encode_ms);
    timing->set_digest_ms(timing->digest_ms() + encoded[i].digest_ms);
  }
  SetTiming(drawn.cpu_ms, timing);
  if (const auto& bound_ms = request.budget.max_latency_ms; bound_ms && timing->total_ms() > *bound_ms) {
    report->set_reason(absl::StrCat(report->reason(), "; late: ", std::ceil(timing->total_ms()), " ms of ", *bound_ms));
  }
  v1::Cache* cache = report->add_caches();
  cache->set_name("scene");
  cache->set_hits(load_ms_ == 0);
  cache->set_misses(load_ms_ > 0);
  cache->set_bytes(scene_->SizeBytes());
  report->set_gl_renderer(gl_renderer_);
  report->set_gl_version(gl_version_);
  report->set_server_version(HALFSHADE_VERSION);
  report->set_content_key(ContentKey(request_.scene(), *drawn.render, HALFSHADE_VERSION, gl_renderer_));
  return response;
}

void RenderCall::SetTiming(double cpu_ms, v1::Timing* timing) const {
  timing->set_queue_ms(queue_ms_);
  timing->set_load_ms(load_ms_);
  timing->set_cpu_ms(cpu_ms);
  timing->set_total_ms(MillisecondsSince(dequeued_at_));
}

}  // namespace halfshade
