// /livez, /readyz and /metrics for load balancers and orchestrators, by civetweb.
#pragma once

#include <absl/status/statusor.h>

#include <atomic>
#include <functional>
#include <memory>
#include <string>

namespace halfshade {

class HttpServer {
 public:
  // Listens on "HOST:PORT" (port 0 picks one). /livez is 200 as long as the process lives; /readyz is 200 while
  // `is_ready`, else 503; /metrics is what `metrics` returns, on any thread, in Prometheus' text format.
  // FAILED_PRECONDITION if the address cannot be had. `is_ready` outlives the server.
  static absl::StatusOr<std::unique_ptr<HttpServer>> Start(const std::string& address,
                                                           const std::atomic<bool>* is_ready,
                                                           std::function<std::string()> metrics);
  virtual ~HttpServer() = default;
  virtual std::string address() const = 0;
};

}  // namespace halfshade
