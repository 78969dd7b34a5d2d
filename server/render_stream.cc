#include "server/render_stream.h"

#include <absl/strings/str_cat.h>

#include <deque>
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
  RenderStreamCall(RenderPlant* plant, grpc::CallbackServerContext* context, const v1::RenderStreamRequest& request)
      : RenderCall(plant, context, request.request(), "RenderStream", StreamLimits(plant->limits),
                   request.progressive()) {}

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

  void DeliverCoarse(v1::RenderResponse response) override { Send({std::move(response), false}); }
  void Deliver(v1::RenderResponse response) override { Send({std::move(response), true}); }

  void FinishRpc(const grpc::Status& status) override {
    const std::lock_guard lock(mutex_);
    is_ended_ = true;
    sending_since_ = SystemClock::now();
    results_.clear();
    std::string().swap(data_);
    Finish(status);
  }

  struct Result {
    v1::RenderResponse response;
    bool is_last = false;
  };

  void Send(Result result) {
    {
      const std::lock_guard lock(mutex_);
      if (is_ended_) return;
      results_.push_back(std::move(result));
    }
    WriteNext();
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
    } else if (results_.empty()) {
      return;
    } else if (image_ < results_.front().response.images_size()) {
      TakeImagePart(results_.front().response.mutable_images(image_));
    } else {
      if (results_.front().is_last && !ClaimSuccess(results_.front().response.report())) return;
      is_ended_ = results_.front().is_last;
      part_.mutable_report()->Swap(results_.front().response.mutable_report());
      results_.pop_front();
      image_ = 0;
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
  std::deque<Result> results_;            // not sent yet, the first of them under way
  int image_ = 0;                         // of that one, under way
  bool has_header_ = false;               // of that image, sent
  std::string data_;                      // of that image
  size_t offset_ = 0;                     // into data_, of the next chunk
  v1::RenderStreamResponse part_;
  bool is_writing_ = false;
  bool is_ended_ = false;  // no write may follow
  bool is_done_ = false;
  SystemClock::time_point sending_since_;
  std::unique_ptr<grpc::Alarm> stall_alarm_;
};

}  // namespace

grpc::ServerWriteReactor<v1::RenderStreamResponse>* StartRenderStream(RenderPlant* plant,
                                                                      grpc::CallbackServerContext* context,
                                                                      const v1::RenderStreamRequest& request) {
  const auto call = std::make_shared<RenderStreamCall>(plant, context, request);
  call->Start();
  return call.get();
}

}  // namespace halfshade
