#include "client/progress.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>

namespace halfshade {
namespace {

constexpr int kBarWidth = 40;

std::string Bar(const std::string& what, double done) {
  if (done < 0) return what + " ...";
  const int per_cent = static_cast<int>(100 * std::min(done, 1.0));
  const auto filled = static_cast<size_t>(kBarWidth * per_cent / 100);
  return what + " [" + std::string(filled, '#') + std::string(kBarWidth - filled, ' ') + "] " +
         std::to_string(per_cent) + " %";
}

}  // namespace

Progress::Progress() : is_terminal_(isatty(STDERR_FILENO) != 0) {}

Progress::~Progress() { Wipe(); }

void Progress::Show(const std::string& what, double done) {
  if (!is_terminal_) return;
  const std::string bar = Bar(what, done);
  const std::lock_guard lock(mutex_);
  if (bar == shown_) return;
  Wipe();
  shown_ = bar;
  std::fputs(bar.c_str(), stderr);
  std::fflush(stderr);
}

void Progress::Say(const std::string& sentence) {
  const std::lock_guard lock(mutex_);
  Wipe();
  std::fprintf(stderr, "halfshade: %s\n", sentence.c_str());
}

void Progress::Wipe() {
  if (!shown_.empty()) std::fputs("\r\x1b[K", stderr);
  shown_.clear();
}

}  // namespace halfshade
