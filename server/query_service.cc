#include "server/query_service.h"

#include <grpcpp/alarm.h>

#include <algorithm>
#include <chrono>
#include <memory>

#include "renderer/status.h"
#include "server/call_time.h"
#include "server/gl_worker.h"
#include "server/report_to_proto.h"
#include "server/validate.h"

namespace halfshade {
namespace {

using SystemClock = std::chrono::system_clock;
using SteadyClock = std::chrono::steady_clock;

// Shared by gRPC, the alarm, the pool and the queue; the last of them lets go.
class QueryCall final : public grpc::ServerUnaryReactor, public std::enable_shared_from_this<QueryCall> {
 public:
  QueryCall(RenderPlant* plant, grpc::CallbackServerContext* context, const v1::QueryVisibilityRequest& query,
            v1::QueryVisibilityResponse* response)
      : plant_(plant),
        context_(context),
        query_(query),
        response_(response),
        call_(CallLog::Begin("QueryVisibility", *context)) {}

  void Start() {
    self_ = shared_from_this();  // gRPC's share, until OnDone
    deadline_ = EffectiveDeadline(context_->deadline());
    if (const absl::Status status = CheckQueryFields(query_, plant_->limits); !status.ok()) {
      FinishOnce(status);
      return;
    }
    alarm_ = std::make_unique<grpc::Alarm>();
    alarm_->Set(deadline_, [self = shared_from_this()](bool is_due) {
      if (is_due) self->GiveUp(absl::DeadlineExceededError("the deadline passed"));
    });
    plant_->pool->Run([self = shared_from_this()] { self->Prepare(); }, call_.peer);
  }

  void OnCancel() override { GiveUp(absl::CancelledError("cancelled by the client")); }

  void OnDone() override {
    alarm_.reset();
    self_.reset();
  }

 private:
  absl::Status StopReason() const {
    if (plant_->is_stopping) return absl::UnavailableError("the server is stopping");
    if (gave_up_) return absl::CancelledError("given up");
    if (SystemClock::now() >= deadline_) return absl::DeadlineExceededError("the deadline passed");
    return absl::OkStatus();
  }

  void GiveUp(const absl::Status& reason) {
    gave_up_ = true;
    plant_->queue->Withdraw(JobId());
    FinishOnce(reason);
  }

  // On the pool.
  void Prepare() {
    if (gave_up_) return;
    const absl::Status status = [&]() -> absl::Status {
      ASSIGN_OR_RETURN(posed_, plant_->catalog->LoadPosed(query_.request(), &load_ms_));
      ASSIGN_OR_RETURN(valid_, ValidateQuery(query_, *posed_.scene, plant_->limits, plant_->machine));
      queued_at_ = SteadyClock::now();
      RenderJob job;
      job.id = JobId();
      job.principal = call_.peer;
      job.affinity = query_.request().scene();
      job.refuse = [self = shared_from_this()](const absl::Status& refusal) { self->FinishOnce(refusal); };
      job.run = [self = shared_from_this()](WorkerRenderer& worker) { return self->Resolve(worker); };
      return plant_->queue->Push(std::move(job), deadline_ - SystemClock::now());
    }();
    if (!status.ok()) FinishOnce(status);
  }

  // On a GL thread.
  absl::Status Resolve(WorkerRenderer& worker) {
    const SteadyClock::time_point dequeued_at = SteadyClock::now();
    if (const absl::Status status = StopReason(); !status.ok()) {
      FinishOnce(status);
      return status;
    }
    const double cpu_begin_ms = ProcessCpuMs();
    auto result = worker.renderer->QueryVisibility(posed_.name, *posed_.scene, valid_.request, valid_.points,
                                                   [this] { return StopReason(); });
    if (!result.ok()) {
      FinishOnce(result.status());
      return result.status();
    }
    v1::QueryVisibilityResponse response;
    // Little-endian, as validation asserts of this machine.
    response.set_visibility(result->visibility.data(), result->visibility.size() * sizeof(float));
    v1::RenderReport* report = response.mutable_report();
    *report = ToProto(result->report);
    const auto milliseconds = [](SteadyClock::duration elapsed) {
      return std::chrono::duration<double, std::milli>(elapsed).count();
    };
    v1::Timing* timing = report->mutable_timing();
    timing->set_queue_ms(milliseconds(dequeued_at - queued_at_));
    timing->set_load_ms(load_ms_);
    timing->set_cpu_ms(ProcessCpuMs() - cpu_begin_ms);
    timing->set_total_ms(milliseconds(SteadyClock::now() - dequeued_at));
    report->set_gl_renderer(worker.gl_renderer);
    report->set_gl_version(worker.gl_version);
    report->set_server_version(HALFSHADE_VERSION);
    if (is_finished_.exchange(true)) return absl::OkStatus();
    ++plant_->renders_ok;
    response_->Swap(&response);
    plant_->log->metrics()->CountRender(response_->report());
    Finish(plant_->log->End(call_, absl::OkStatus(), context_));
    return absl::OkStatus();
  }

  void FinishOnce(const absl::Status& status) {
    if (is_finished_.exchange(true)) return;
    ++plant_->renders_failed;
    Finish(plant_->log->End(call_, status, context_));
  }

  uint64_t JobId() const { return uint64_t(reinterpret_cast<uintptr_t>(this)); }

  RenderPlant* const plant_;
  grpc::CallbackServerContext* const context_;
  const v1::QueryVisibilityRequest query_;
  v1::QueryVisibilityResponse* const response_;
  const CallLog::Call call_;
  std::shared_ptr<QueryCall> self_;
  std::unique_ptr<grpc::Alarm> alarm_;  // keeps its callback, and so a share of this, until it is destroyed
  SystemClock::time_point deadline_;
  std::atomic<bool> gave_up_{false};
  std::atomic<bool> is_finished_{false};
  SceneCatalog::Posed posed_;
  ValidatedQuery valid_;
  SteadyClock::time_point queued_at_;
  double load_ms_ = 0;
};

}  // namespace

grpc::ServerUnaryReactor* StartQuery(RenderPlant* plant, grpc::CallbackServerContext* context,
                                     const v1::QueryVisibilityRequest& query, v1::QueryVisibilityResponse* response) {
  const auto call = std::make_shared<QueryCall>(plant, context, query, response);
  call->Start();
  return call.get();
}

}  // namespace halfshade
