// halfshaded's command line.
#pragma once

#include <string>

#include "server/options.h"

namespace halfshade {

struct DaemonFlags {
  ServerOptions options;
  std::string log_level = "info";
  bool is_json_log = false;
};

// Fills `flags` and returns -1, or returns an exit code (0 after --help) having said why on stderr.
// 64: usage, a flag that this version lacks, or an address beyond loopback without --insecure-bind.
int ParseDaemonFlags(int argc, const char* const* argv, DaemonFlags* flags);

// "127.0.0.1:50051", "[::1]:0", "localhost:1", "unix:/x".
bool IsLoopback(const std::string& address);

}  // namespace halfshade
