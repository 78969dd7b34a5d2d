// halfshaded: the server. Exit codes: 0 after SIGTERM or SIGINT, 64 usage, 69 no context or no address.
#include <signal.h>
#include <spdlog/spdlog.h>

#include <cstdio>
#include <thread>

#include "server/flags.h"
#include "server/log.h"
#include "server/server.h"

namespace {

constexpr int kUnavailable = 69;

}  // namespace

int main(int argc, char** argv) {
  halfshade::DaemonFlags flags;
  if (const int code = halfshade::ParseDaemonFlags(argc, argv, &flags); code >= 0) return code;
  halfshade::gl::LimitDriverThreads(flags.options.contexts);
  halfshade::SetUpLog(flags.log_level, flags.is_json_log);

  // Signals are taken by one thread that waits for them; every other thread has them blocked.
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGTERM);
  sigaddset(&signals, SIGINT);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);

  auto server = halfshade::Server::Start(flags.options);
  if (!server.ok()) {
    std::fprintf(stderr, "halfshaded: %s\n", std::string(server.status().message()).c_str());
    return kUnavailable;
  }
  std::printf("serving grpc=%s http=%s", (*server)->grpc_address().c_str(), (*server)->http_address().c_str());
  if (flags.options.admin != "off") std::printf(" admin=%s", (*server)->admin_address().c_str());
  std::printf("\n");
  std::fflush(stdout);

  int signal = 0;
  sigwait(&signals, &signal);
  spdlog::info("draining; a second signal ends now");
  std::thread([signals] {
    int second = 0;
    sigwait(&signals, &second);
    _exit(0);
  }).detach();
  (*server)->Drain();
  return 0;
}
