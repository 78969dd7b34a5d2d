// /livez and /readyz for load balancers and orchestrators, by civetweb.
#pragma once

#include <absl/status/statusor.h>

#include <atomic>
#include <memory>
#include <string>

namespace halfshade {

class HttpServer {
 public:
  // Listens on "HOST:PORT" (port 0 picks one). /livez is 200 as long as the process lives; /readyz is 200 while
  // `is_ready`, else 503. FAILED_PRECONDITION if the address cannot be had. `is_ready` outlives the server.
  static absl::StatusOr<std::unique_ptr<HttpServer>> Start(const std::string& address,
                                                           const std::atomic<bool>* is_ready);
  virtual ~HttpServer() = default;
  virtual std::string address() const = 0;
};

}  // namespace halfshade
