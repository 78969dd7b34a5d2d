// Runs the built executables as a user does.
#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

namespace halfshade {

struct Ran {
  int exit_code = -1;  // 128 + the signal where one ended it
  std::string out;
  std::string err;
};

// `halfshade` with these arguments, in `folder`, without HALFSHADE_SERVER. stdin is /dev/null, nothing is a terminal.
Ran RunHalfshade(const std::vector<std::string>& arguments, const std::string& folder);

// A `halfshaded` on a port of its own, with these arguments beside. Ends with SIGTERM.
class ServerProcess {
 public:
  explicit ServerProcess(const std::vector<std::string>& arguments = {});
  ~ServerProcess();
  ServerProcess(const ServerProcess&) = delete;
  ServerProcess& operator=(const ServerProcess&) = delete;

  const std::string& address() const { return address_; }  // "" where it did not come up
  bool IsAlive() const;
  // Sends SIGTERM and waits; the exit code.
  int Stop();
  void Signal(int signal) const;
  // Waits for its end; the exit code.
  int Wait();
  // VmHWM.
  double PeakMemoryMb() const;
  // SIGKILL: no handler, no destructor, no flush.
  void Kill();

 private:
  pid_t pid_ = -1;
  std::string address_;
};

}  // namespace halfshade
