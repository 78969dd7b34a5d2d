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

// `halfshade`, running beside the test. stdin, stdout and stderr are /dev/null. Ends with SIGKILL.
class ClientProcess {
 public:
  ClientProcess(const std::vector<std::string>& arguments, const std::string& folder);
  ~ClientProcess();
  ClientProcess(const ClientProcess&) = delete;
  ClientProcess& operator=(const ClientProcess&) = delete;

  bool IsAlive() const;
  // Until it ends; the exit code.
  int Wait();
  void Kill();

 private:
  pid_t pid_ = -1;
};

// A `halfshaded` with these arguments, on a port of its own where they do not say --listen. Ends with SIGTERM.
class ServerProcess {
 public:
  explicit ServerProcess(const std::vector<std::string>& arguments = {});
  ~ServerProcess();
  ServerProcess(const ServerProcess&) = delete;
  ServerProcess& operator=(const ServerProcess&) = delete;

  const std::string& address() const { return address_; }  // "" where it did not come up
  const std::string& admin() const { return admin_; }      // "" without --admin
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
  std::string address_, admin_;
};

}  // namespace halfshade
