// What the user sees on stderr while a command runs: a bar on a terminal, sentences everywhere.
#pragma once

#include <mutex>
#include <string>

namespace halfshade {

// Thread-safe. The bar is drawn only where stderr is a terminal and is wiped by the next sentence and at the end.
class Progress {
 public:
  Progress();
  ~Progress();

  // `done` from 0 to 1; below 0: not known.
  void Show(const std::string& what, double done);
  void Say(const std::string& sentence);

 private:
  void Wipe();

  const bool is_terminal_;
  std::mutex mutex_;
  std::string shown_;  // the bar on the screen; "": none
};

}  // namespace halfshade
