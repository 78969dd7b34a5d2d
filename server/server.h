// The whole service: store, caches, GL workers, gRPC and probes, wired together. halfshaded runs one; the client runs
// one without a port inside its own process.
#pragma once

#include <absl/status/statusor.h>
#include <grpcpp/channel.h>

#include <memory>
#include <string>

#include "server/options.h"

namespace halfshade {

class Server {
 public:
  // Returns when it serves: every context is made and warmed up before the port opens, so that a call before that finds
  // nothing there (UNAVAILABLE). FAILED_PRECONDITION: no context, an address that cannot be had, a store that cannot be
  // opened.
  static absl::StatusOr<std::unique_ptr<Server>> Start(const ServerOptions& options);
  // Cuts what is under way.
  virtual ~Server() = default;

  // A channel to this server that crosses no port.
  virtual std::shared_ptr<grpc::Channel> InProcessChannel() = 0;

  // "127.0.0.1:40123", "unix:PATH", or "" without a port.
  virtual std::string grpc_address() const = 0;
  // "127.0.0.1:40124" or "off".
  virtual std::string http_address() const = 0;
  virtual std::string admin_address() const = 0;

  // NOT_SERVING at once, the lame duck's time, then no new calls; calls under way have the grace to end. Blocks.
  virtual void Drain() = 0;
};

}  // namespace halfshade
