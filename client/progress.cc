#include "client/progress.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>

namespace halfshade {
namespace {

constexpr int kBarWidth = 40;
constexpr int kUnknown = 101;

}  // namespace

Progress::Progress() : is_terminal_(isatty(STDERR_FILENO) != 0) {}

Progress::~Progress() { Wipe(); }

void Progress::Show(const char* what, double done) {
  if (!is_terminal_) return;
  const std::lock_guard lock(mutex_);
  const int per_cent = done < 0 ? kUnknown : static_cast<int>(100 * std::min(done, 1.0));
  if (per_cent == shown_per_cent_) return;
  Wipe();
  shown_per_cent_ = per_cent;
  if (done < 0) {
    std::fprintf(stderr, "%s ...", what);
  } else {
    const auto filled = static_cast<size_t>(kBarWidth * per_cent / 100);
    std::fprintf(stderr, "%s [%s%s] %d %%", what, std::string(filled, '#').c_str(),
                 std::string(kBarWidth - filled, ' ').c_str(), per_cent);
  }
  std::fflush(stderr);
}

void Progress::Say(const std::string& sentence) {
  const std::lock_guard lock(mutex_);
  Wipe();
  std::fprintf(stderr, "halfshade: %s\n", sentence.c_str());
}

void Progress::Wipe() {
  if (shown_per_cent_ >= 0) std::fputs("\r\x1b[K", stderr);
  shown_per_cent_ = -1;
}

}  // namespace halfshade
