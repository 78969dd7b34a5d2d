#include "renderer/gl/turn.h"

#include <condition_variable>
#include <cstdint>
#include <mutex>

#include "renderer/gl/context.h"

namespace halfshade::gl {
namespace {

// First come, first served: with a mutex alone, who passes it would take it again before anyone woke up.
class Line {
 public:
  void Enter() {
    std::unique_lock lock(mutex_);
    const uint64_t number = next_++;
    moved_.wait(lock, [&] { return serving_ == number; });
  }
  void Leave() {
    {
      const std::lock_guard lock(mutex_);
      ++serving_;
    }
    moved_.notify_all();
  }
  // By whom is served.
  bool HasOthers() {
    const std::lock_guard lock(mutex_);
    return next_ - serving_ > 1;
  }

 private:
  std::mutex mutex_;
  std::condition_variable moved_;
  uint64_t next_ = 0, serving_ = 0;
};

// Never destroyed: contexts of static storage may outlive it.
Line& TheLine() {
  static Line& line = *new Line;
  return line;
}

thread_local bool has_turn = false;

void Take() {
  TheLine().Enter();
  has_turn = true;
}

void GiveUp() {
  has_turn = false;
  TheLine().Leave();
}

}  // namespace

Turn::Turn(bool is_needed) : is_taken_(is_needed && !has_turn) {
  if (is_taken_) Take();
}

Turn::Turn(const Context& context) : Turn(context.IsSoftware()) {}

Turn::~Turn() {
  if (is_taken_) GiveUp();
}

void PassTurn() {
  if (!has_turn || !TheLine().HasOthers()) return;
  GiveUp();
  Take();
}

TurnPause::TurnPause() : had_turn_(has_turn) {
  if (had_turn_) GiveUp();
}

TurnPause::~TurnPause() {
  if (had_turn_) Take();
}

}  // namespace halfshade::gl
