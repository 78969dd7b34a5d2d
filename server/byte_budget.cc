#include "server/byte_budget.h"

#include <string>

#include "server/status.h"

namespace halfshade {
namespace {

// About what the readers that hold the budget need to take a few MB each: nobody knows when they will.
constexpr std::chrono::milliseconds kPushback(500);

}  // namespace

absl::StatusOr<ByteBudget::Hold> ByteBudget::Take(uint64_t bytes, const char* what) {
  if (bytes > capacity_) {
    return absl::InvalidArgumentError(std::string(what) + ": " + std::to_string(bytes) +
                                      " bytes before compression; this server holds at most " +
                                      std::to_string(capacity_));
  }
  uint64_t used = used_;
  do {
    if (bytes > capacity_ - used) {
      return ComeBackLater(std::string(what) + ": " + std::to_string(bytes) + " bytes, and " + std::to_string(used) +
                               " of the " + std::to_string(capacity_) + " that this server holds are in flight",
                           kPushback);
    }
  } while (!used_.compare_exchange_weak(used, used + bytes));
  return Hold(this, bytes);
}

}  // namespace halfshade
