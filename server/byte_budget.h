// A bound on bytes that several calls hold at the same time. Thread-safe.
#pragma once

#include <absl/status/statusor.h>

#include <atomic>
#include <cstdint>
#include <utility>

namespace halfshade {

class ByteBudget {
 public:
  // A share of the budget, given back when it dies.
  class Hold {
   public:
    Hold() = default;
    Hold(Hold&& other) noexcept
        : budget_(std::exchange(other.budget_, nullptr)), bytes_(std::exchange(other.bytes_, 0)) {}
    Hold& operator=(Hold&& other) noexcept {
      std::swap(budget_, other.budget_);
      std::swap(bytes_, other.bytes_);
      return *this;
    }
    ~Hold() {
      if (budget_ != nullptr) budget_->used_ -= bytes_;
    }

   private:
    friend class ByteBudget;
    Hold(ByteBudget* budget, uint64_t bytes) : budget_(budget), bytes_(bytes) {}
    ByteBudget* budget_ = nullptr;
    uint64_t bytes_ = 0;
  };

  explicit ByteBudget(uint64_t capacity) : capacity_(capacity) {}

  // INVALID_ARGUMENT, saying so of `what`, for more than the budget ever has; RESOURCE_EXHAUSTED with push-back for
  // more than it has now. The budget outlives the hold.
  absl::StatusOr<Hold> Take(uint64_t bytes, const char* what);

  uint64_t used() const { return used_; }

 private:
  const uint64_t capacity_;
  std::atomic<uint64_t> used_{0};
};

}  // namespace halfshade
