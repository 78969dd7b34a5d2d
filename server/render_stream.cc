#include "server/render_stream.h"

#include <absl/strings/str_cat.h>

#include <limits>
#include <mutex>
#include <optional>

namespace halfshade {
namespace {

using SystemClock = std::chrono::system_clock;

constexpr size_t kChunkBytes = 256 << 10;

// A stream has no bound on its result but the plant's in_flight.
Limits StreamLimits(Limits limits) {
  limits.render_reply_bytes = std::numeric_limits<uint64_t>::max();
  return limits;
}

class RenderStreamCall final : public grpc::ServerWriteReactor<v1::RenderStreamResponse>, public RenderCall {
 public:
  RenderStreamCall(RenderPlant* plant, grpc::CallbackServerContext* context, const v1::RenderRequest& request)
      : RenderCall(plant, context, request, "RenderStream", StreamLimits(plant->limits)) {}

  void OnWriteDone(bool is_ok) override {
    {
      const std::lock_guard lock(mutex_);
      is_writing_ = false;
    }
    if (is_ok) {
      WriteNext();
    } else {
      GiveUp(absl::CancelledError("the stream is broken"));
    }
  }
  void OnCancel() override { GiveUp(absl::CancelledError("cancelled by the client")); }
  void OnDone() override {
    {
      const std::lock_guard lock(mutex_);
      is_done_ = true;
      stall_alarm_.reset();  // with its callback, and that one's share of this
    }
    Release();
  }

 private:
  void OnQueued(v1::RenderReport plan) override {
    {
      const std::lock_guard lock(mutex_);
      plan_ = std::move(plan);
      is_planned_ = true;
      WatchReader(SystemClock::now() + plant()->stream_stall);
    }
    WriteNext();
  }

  void Deliver(v1::RenderResponse response) override {
    {
      const std::lock_guard lock(mutex_);
      result_ = std::move(response);
    }
    WriteNext();
  }

  void FinishRpc(const grpc::Status& status) override {
    const std::lock_guard lock(mutex_);
    is_ended_ = true;
    sending_since_ = SystemClock::now();
    result_.reset();
    std::string().swap(data_);
    Finish(status);
  }

  // Sends what is there, if nothing is on its way.
  void WriteNext() {
    const std::lock_guard lock(mutex_);
    // A quick render may be through before its plan is here.
    if (is_writing_ || is_ended_ || !is_planned_) return;
    part_.Clear();
    if (plan_) {
      *part_.mutable_plan() = *std::move(plan_);
      plan_.reset();
    } else if (!result_) {
      return;
    } else if (image_ < result_->images_size()) {
      TakeImagePart(result_->mutable_images(image_));
    } else {
      if (!ClaimSuccess(result_->report())) return;
      is_ended_ = true;
      part_.mutable_report()->Swap(result_->mutable_report());
    }
    is_writing_ = true;
    sending_since_ = SystemClock::now();
    if (is_ended_) {
      StartWriteAndFinish(&part_, {}, grpc::Status::OK);
    } else {
      StartWrite(&part_);
    }
  }

  // The image's header, or its next chunk; an image that is through is freed.
  void TakeImagePart(v1::OutputImage* image) {
    if (!has_header_) {
      data_.swap(*image->mutable_data());
      part_.mutable_header()->Swap(image);
      has_header_ = true;
      offset_ = 0;
    } else {
      part_.set_chunk(data_.substr(offset_, kChunkBytes));
      offset_ += part_.chunk().size();
    }
    if (offset_ < data_.size()) return;
    std::string().swap(data_);
    has_header_ = false;
    ++image_;
  }

  // Under mutex_.
  void WatchReader(SystemClock::time_point due) {
    stall_alarm_ = std::make_unique<grpc::Alarm>();
    stall_alarm_->Set(due, [self = std::static_pointer_cast<RenderStreamCall>(shared_from_this())](bool is_due) {
      if (is_due) self->CheckReader();
    });
  }

  // Looks again when what is being sent now, a part or the status, would be too old.
  void CheckReader() {
    bool is_stalled = false;
    {
      const std::lock_guard lock(mutex_);
      if (is_done_) return;
      const auto now = SystemClock::now();
      const bool is_sending = is_writing_ || is_ended_;
      is_stalled = is_sending && now >= sending_since_ + plant()->stream_stall;
      if (is_stalled && is_ended_) {
        context()->TryCancel();
        return;
      }
      WatchReader((is_sending && !is_stalled ? sending_since_ : now) + plant()->stream_stall);
    }
    if (is_stalled) {
      GiveUp(absl::DeadlineExceededError(
          absl::StrCat("the reader took nothing for ", double(plant()->stream_stall.count()) / 1000, " s")));
    }
  }

  std::mutex mutex_;
  bool is_planned_ = false;
  std::optional<v1::RenderReport> plan_;  // until it is sent
  std::optional<v1::RenderResponse> result_;
  int image_ = 0;            // of result_, under way
  bool has_header_ = false;  // of that image, sent
  std::string data_;         // of that image
  size_t offset_ = 0;        // into data_, of the next chunk
  v1::RenderStreamResponse part_;
  bool is_writing_ = false;
  bool is_ended_ = false;  // no write may follow
  bool is_done_ = false;
  SystemClock::time_point sending_since_;
  std::unique_ptr<grpc::Alarm> stall_alarm_;
};

class FinishedStream final : public grpc::ServerWriteReactor<v1::RenderStreamResponse> {
 public:
  explicit FinishedStream(const grpc::Status& status) { Finish(status); }
  void OnDone() override { delete this; }
};

}  // namespace

grpc::ServerWriteReactor<v1::RenderStreamResponse>* StartRenderStream(RenderPlant* plant,
                                                                      grpc::CallbackServerContext* context,
                                                                      const v1::RenderStreamRequest& request) {
  if (request.progressive()) {
    return new FinishedStream(grpc::Status(grpc::StatusCode::UNIMPLEMENTED,
                                           "progressive: coarse results first are not available in this version"));
  }
  const auto call = std::make_shared<RenderStreamCall>(plant, context, request.request());
  call->Start();
  return call.get();
}

}  // namespace halfshade
