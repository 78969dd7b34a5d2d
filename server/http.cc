#include "server/http.h"

#include <CivetServer.h>

#include <array>

namespace halfshade {
namespace {

void Answer(mg_connection* connection, bool is_ok) {
  const char* body = is_ok ? "ok\n" : "not ready\n";
  mg_printf(connection, "HTTP/1.1 %s\r\nContent-Type: text/plain\r\nContent-Length: %d\r\nConnection: close\r\n\r\n%s",
            is_ok ? "200 OK" : "503 Service Unavailable", int(std::char_traits<char>::length(body)), body);
}

class Probe : public CivetHandler {
 public:
  explicit Probe(const std::atomic<bool>* is_ok) : is_ok_(is_ok) {}
  bool handleGet(CivetServer*, mg_connection* connection) override {
    Answer(connection, is_ok_ == nullptr || is_ok_->load());
    return true;
  }

 private:
  const std::atomic<bool>* is_ok_;
};

class MetricsPage : public CivetHandler {
 public:
  explicit MetricsPage(std::function<std::string()> metrics) : metrics_(std::move(metrics)) {}
  bool handleGet(CivetServer*, mg_connection* connection) override {
    const std::string text = metrics_();
    mg_printf(connection,
              "HTTP/1.1 200 OK\r\nContent-Type: text/plain; version=0.0.4; charset=utf-8\r\n"
              "Content-Length: %zu\r\nConnection: close\r\n\r\n",
              text.size());
    mg_write(connection, text.data(), text.size());
    return true;
  }

 private:
  std::function<std::string()> metrics_;
};

class CivetHttp : public HttpServer {
 public:
  CivetHttp(const std::string& address, const std::atomic<bool>* is_ready, std::function<std::string()> metrics)
      : alive_(nullptr),
        ready_(is_ready),
        metrics_(std::move(metrics)),
        server_(
            std::vector<std::string>{"listening_ports", address, "num_threads", "2", "request_timeout_ms", "5000"}) {
    server_.addHandler("/livez", alive_);
    server_.addHandler("/readyz", ready_);
    server_.addHandler("/metrics", metrics_);
    const std::vector<int> ports = server_.getListeningPorts();
    address_ = address.substr(0, address.rfind(':') + 1) + std::to_string(ports.empty() ? 0 : ports[0]);
  }
  std::string address() const override { return address_; }

 private:
  Probe alive_, ready_;
  MetricsPage metrics_;
  CivetServer server_;
  std::string address_;
};

}  // namespace

absl::StatusOr<std::unique_ptr<HttpServer>> HttpServer::Start(const std::string& address,
                                                              const std::atomic<bool>* is_ready,
                                                              std::function<std::string()> metrics) {
  try {
    return std::make_unique<CivetHttp>(address, is_ready, std::move(metrics));
  } catch (const CivetException& error) {
    return absl::FailedPreconditionError("http " + address + ": " + error.what());
  }
}

}  // namespace halfshade
