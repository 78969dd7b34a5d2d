// One render on its way through the server, whichever rpc asked for it: the scene and the plain request on the CPU
// pool, the render queue, a GL thread, the encode pool, and then out as its rpc has it.
//
// A progressive call draws coarse results first (renderer/plan/coarse_request.h), in the same turn on its GL thread,
// each encoded and delivered while the next is drawn. They are not kept, and who waits for another's render gets none.
//
// It is finished exactly once, by whichever comes first: its result, its deadline (an alarm, not the next dequeue), or
// its cancellation. Identical calls share one render (result_cache.h), which goes on as long as one of them wants it.
// Shared by gRPC, the alarm, the pools and the queue; the last of them lets go. Thread-safe.
#pragma once

#include <grpcpp/alarm.h>
#include <grpcpp/server_context.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "halfshade/v1/render.pb.h"
#include "renderer/renderer.h"
#include "server/admission.h"
#include "server/byte_budget.h"
#include "server/call_log.h"
#include "server/cpu_pool.h"
#include "server/encode.h"
#include "server/limits.h"
#include "server/result_cache.h"
#include "server/scene_catalog.h"
#include "server/validate.h"

namespace halfshade {

// What the calls share; all outlives them.
struct RenderPlant {
  SceneCatalog* catalog = nullptr;
  CpuPool* pool = nullptr;
  CpuPool* encode_pool = nullptr;
  RenderQueue* queue = nullptr;
  ByteBudget* in_flight = nullptr;  // images that are drawn, encoded or sent, as the encoder gets them
  ResultCache* results = nullptr;
  CallLog* log = nullptr;
  Limits limits;
  std::chrono::milliseconds stream_stall{30000};  // a reader that takes nothing for so long is dropped
  Machine machine;                                // GlWorkerPool::machine
  std::atomic<bool> is_stopping{false};           // renders under way give up
  std::atomic<uint64_t> renders_ok{0};
  std::atomic<uint64_t> renders_failed{0};
};

class RenderCall : public std::enable_shared_from_this<RenderCall> {
 public:
  virtual ~RenderCall() = default;
  // Call once, on an object that a shared_ptr owns.
  void Start();

 protected:
  // `rpc` is for the log and the metrics. `limits` are the plant's, less what the rpc lifts.
  RenderCall(RenderPlant* plant, grpc::CallbackServerContext* context, const v1::RenderRequest& request,
             const char* rpc, const Limits& limits, bool is_progressive = false);

  // Asked between GL submissions and between an encoder's rows.
  absl::Status StopReason() const;
  // A call that waits is answered now; one that is drawn or encoded stops at its next check, and is answered now too.
  void GiveUp(const absl::Status& reason);
  // Finishes with an error, unless the call is finished.
  void Fail(const absl::Status& status);
  // True for the one caller that may finish the call well, with this report; its images are in flight no more.
  bool ClaimSuccess(const v1::RenderReport& report);
  // gRPC's share, given back in OnDone.
  void Release();

  RenderPlant* plant() const { return plant_; }
  grpc::CallbackServerContext* context() const { return context_; }

 private:
  // What is known before drawing; the call waits in the queue. Not called when it is refused there.
  virtual void OnQueued(v1::RenderReport plan) = 0;
  // A coarse result, before the whole one, in the order drawn.
  virtual void DeliverCoarse(v1::RenderResponse) {}
  // All of it, once, unless the call is given up before. Claims success when it is about to finish.
  virtual void Deliver(v1::RenderResponse response) = 0;
  // Ends the rpc, once.
  virtual void FinishRpc(const grpc::Status& status) = 0;

  void Prepare();  // on the CPU pool
  bool Enqueue();  // there, or where the call takes the lead of its like; false: the call has ended
  void Reuse(const v1::RenderResponse& reply);
  // A picture between the GL thread and the encoder.
  struct Drawn {
    const ValidatedRender* render = nullptr;  // coarse_'s or render_
    RenderResult result;
    double cpu_ms = 0;  // since the call was dequeued
  };
  void PlanCoarse();                          // where there is memory for them too
  absl::Status Draw(WorkerRenderer& worker);  // on a GL thread; what became of it there
  absl::Status DrawOne(WorkerRenderer& worker, const ValidatedRender& render);
  void EncodeAll();                    // on the encode pool, in the order drawn
  bool EncodeAndDeliver(Drawn drawn);  // false: the call has ended
  v1::RenderResponse MakeResponse(const Drawn& drawn, const std::vector<std::optional<LightGrid>>& grids,
                                  std::vector<EncodedOutput> encoded) const;
  void SetTiming(double cpu_ms, v1::Timing* timing) const;  // what is the call's own, drawn or not
  // Takes part in no render of others any more. Whoever waits for this one leads.
  void LeaveResults();
  // The call ended, and yet others wait for its render.
  bool IsAwaited() const;
  uint64_t id() const { return uint64_t(reinterpret_cast<uintptr_t>(this)); }

  RenderPlant* const plant_;
  grpc::CallbackServerContext* const context_;
  const v1::RenderRequest request_;
  const Limits limits_;
  const CallLog::Call call_;
  std::shared_ptr<RenderCall> self_;
  std::unique_ptr<grpc::Alarm> alarm_;  // keeps its callback, and so a share of this, until it is destroyed
  std::chrono::system_clock::time_point deadline_;
  std::atomic<bool> gave_up_{false};
  std::atomic<bool> is_finished_{false};
  // In ResultCache, under result_key_, which is not written after it was kAlone.
  enum class Part : uint8_t { kAlone, kWaits, kLeads };
  std::atomic<Part> part_{Part::kAlone};
  std::string result_key_;
  SceneCache::ScenePtr scene_;  // as the request bends it
  std::string posed_name_;
  ValidatedRender render_;
  bool is_redone_ = false;  // its context was lost once
  const bool is_progressive_;
  std::vector<ValidatedRender> coarse_;  // drawn before it
  ByteBudget::Hold in_flight_, coarse_in_flight_;
  std::mutex drawn_mutex_;
  std::deque<Drawn> drawn_;   // under drawn_mutex_: not encoded yet
  bool is_encoding_ = false;  // under drawn_mutex_
  std::chrono::steady_clock::time_point queued_at_, dequeued_at_;
  double load_ms_ = 0, queue_ms_ = 0, cpu_begin_ms_ = 0;
  std::string gl_renderer_, gl_version_;
};

}  // namespace halfshade
