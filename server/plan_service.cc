#include "server/plan_service.h"

#include <atomic>
#include <limits>
#include <memory>
#include <string>

#include "renderer/status.h"
#include "server/report_to_proto.h"
#include "server/validate.h"

namespace halfshade {
namespace {

// Lives until it is finished and gRPC is through with it.
class PlanCall final : public grpc::ServerUnaryReactor, public std::enable_shared_from_this<PlanCall> {
 public:
  PlanCall(RenderPlant* plant, grpc::CallbackServerContext* context, const v1::PlanRenderRequest& plan,
           v1::PlanRenderResponse* response)
      : plant_(plant),
        context_(context),
        request_(plan.request()),
        response_(response),
        call_(CallLog::Begin("PlanRender", *context)) {
    // A plan sends no picture: whichever of the two rpcs would.
    limits_ = plant->limits;
    limits_.render_reply_bytes = std::numeric_limits<uint64_t>::max();
  }

  void Start() {
    self_ = shared_from_this();  // gRPC's share, until OnDone
    if (const absl::Status status = CheckRenderFields(request_, limits_); !status.ok()) {
      FinishOnce(status);
      return;
    }
    plant_->pool->Run(
        [self = shared_from_this()] {
          if (!self->is_finished_) self->FinishOnce(self->Plan());
        },
        context_->peer());
  }
  void OnCancel() override { FinishOnce(absl::CancelledError("cancelled by the client")); }
  void OnDone() override { self_.reset(); }

 private:
  absl::Status Plan() {
    double load_ms = 0;
    ASSIGN_OR_RETURN(const SceneCatalog::Posed posed, plant_->catalog->LoadPosed(request_, &load_ms));
    ASSIGN_OR_RETURN(const ValidatedRender render, ValidateRender(request_, *posed.scene, limits_, plant_->machine));
    ASSIGN_OR_RETURN(const RenderReport plan, PlanRender(*posed.scene, render.request));
    plan_ = ToProto(plan);
    plan_.mutable_timing()->set_load_ms(load_ms);
    if (render.request.predicted_cpu_ms) plan_.mutable_timing()->set_cpu_ms(*render.request.predicted_cpu_ms);
    plan_.set_server_version(HALFSHADE_VERSION);
    return absl::OkStatus();
  }

  void FinishOnce(const absl::Status& status) {
    if (is_finished_.exchange(true)) return;
    if (status.ok()) response_->mutable_plan()->Swap(&plan_);
    Finish(plant_->log->End(call_, status, context_));
  }

  RenderPlant* const plant_;
  grpc::CallbackServerContext* const context_;
  const v1::RenderRequest request_;
  v1::PlanRenderResponse* const response_;
  const CallLog::Call call_;
  Limits limits_;
  std::shared_ptr<PlanCall> self_;
  std::atomic<bool> is_finished_{false};
  v1::RenderReport plan_;
};

}  // namespace

grpc::ServerUnaryReactor* StartPlan(RenderPlant* plant, grpc::CallbackServerContext* context,
                                    const v1::PlanRenderRequest& plan, v1::PlanRenderResponse* response) {
  const auto call = std::make_shared<PlanCall>(plant, context, plan, response);
  call->Start();
  return call.get();
}

}  // namespace halfshade
