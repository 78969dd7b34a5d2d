// Connections that cost a server without asking anything of it: silent, cut off in the preface or in a message, a byte
// a second.
#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <vector>

#include "tests/integration/service_fixture.h"

namespace halfshade {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

constexpr char kPreface[] = "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n";
constexpr unsigned char kSettings[] = {0, 0, 0, 4, 0, 0, 0, 0, 0};

class Connection {
 public:
  explicit Connection(const std::string& address) : socket_(socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(uint16_t(std::stoi(address.substr(address.rfind(':') + 1))));
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    is_open_ = connect(socket_, reinterpret_cast<sockaddr*>(&to), sizeof(to)) == 0;
  }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;
  ~Connection() { close(socket_); }

  void Send(const void* bytes, size_t size) {
    if (is_open_ && send(socket_, bytes, size, MSG_NOSIGNAL) < 0) is_open_ = false;
  }
  // False once the server has closed it. What the server sends is thrown away.
  bool IsOpen() {
    char bytes[4096];
    ssize_t got = 0;
    while (is_open_ && (got = recv(socket_, bytes, sizeof(bytes), MSG_DONTWAIT)) > 0) {
    }
    if (is_open_ && (got == 0 || (errno != EAGAIN && errno != EWOULDBLOCK))) is_open_ = false;
    return is_open_;
  }

 private:
  int socket_;
  bool is_open_ = false;
};

class SlowClientsTest : public ServiceTest {
 protected:
  void SetUp() override {
    ServiceTest::SetUp();
    server_.reset();
    options_.connections.handshake_ms = 1000;
    options_.connections.age_ms = 3000;
    options_.connections.age_grace_ms = 1000;
    Start();
  }

  // p99 of 200 renders one after the other, ms.
  double GoodClientsMs(const std::string& scene) {
    std::vector<double> ms;
    for (int i = 0; i < 200; ++i) {
      const auto begin = Clock::now();
      EXPECT_TRUE(Render(Request(scene)).ok());
      ms.push_back(std::chrono::duration<double, std::milli>(Clock::now() - begin).count());
    }
    std::sort(ms.begin(), ms.end());
    return ms[ms.size() * 99 / 100];
  }
};

TEST_F(SlowClientsTest, FiveHundredOfThemHurtNobodyAndAreAllGoneInTime) {
  rlimit files{};
  getrlimit(RLIMIT_NOFILE, &files);
  files.rlim_cur = std::min<rlim_t>(files.rlim_max, 4096);
  setrlimit(RLIMIT_NOFILE, &files);
  const std::string scene = MakeScene();
  const double before_ms = GoodClientsMs(scene);
  std::vector<std::unique_ptr<Connection>> bad;
  for (int i = 0; i < 500; ++i) {
    Connection& connection = *bad.emplace_back(std::make_unique<Connection>(server_->grpc_address()));
    ASSERT_TRUE(connection.IsOpen());
    if (i % 4 == 1) connection.Send(kPreface, 10);  // half a preface
    if (i % 4 >= 2) {
      connection.Send(kPreface, sizeof(kPreface) - 1);
      connection.Send(kSettings, sizeof(kSettings));
      const unsigned char half_a_frame[] = {0, 1, 0, 1, 4};  // of HEADERS
      connection.Send(half_a_frame, sizeof(half_a_frame));
    }
  }
  const double with_ms = GoodClientsMs(scene);
  const auto begin = Clock::now();
  auto next_byte = begin;
  size_t open = bad.size();
  while (open > 0 && Clock::now() < begin + 30s) {
    if (Clock::now() >= next_byte) {
      next_byte += 1s;
      for (size_t i = 3; i < bad.size(); i += 4) bad[i]->Send("\0", 1);  // a byte a second
    }
    open = size_t(std::count_if(bad.begin(), bad.end(), [](const auto& connection) { return connection->IsOpen(); }));
    std::this_thread::sleep_for(20ms);
  }
  std::printf("good clients' p99 %.1f ms without, %.1f ms with 500 bad ones; all of those gone after %.1f s\n",
              before_ms, with_ms, std::chrono::duration<double>(Clock::now() - begin).count());
  EXPECT_EQ(open, 0u);
  EXPECT_TRUE(Render(Request(scene)).ok());
}

}  // namespace
}  // namespace halfshade
