// More than a server can do: what it gets done, how quickly it says no, and what that costs.
#include <gmock/gmock.h>

#include <algorithm>
#include <mutex>
#include <sstream>
#include <vector>

#include "server/status.h"
#include "tests/integration/http_get.h"
#include "tests/integration/service_fixture.h"
#include "tests/support/process_memory.h"

namespace halfshade {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

class OverloadTest : public ServiceTest {
 protected:
  void SetUp() override {
    ServiceTest::SetUp();
    server_.reset();
    options_.limits.queue = 8;
    options_.contexts = 2;
    options_.result_cache_mb = 0;
    options_.http = "127.0.0.1:0";
    Start();
    render_ms = 10;
  }

  struct Outcome {
    int served = 0, refused = 0, others = 0;
    std::vector<double> refusal_ms;
    int without_pushback = 0;
    double Percentile99() {
      std::sort(refusal_ms.begin(), refusal_ms.end());
      return refusal_ms.empty() ? 0 : refusal_ms[refusal_ms.size() * 99 / 100];
    }
  };

  // How many renders the server had refused within so many seconds ("0.01", a bound of its buckets) of their arrival.
  int RefusedWithin(const std::string& seconds) {
    const std::string begin =
        "halfshade_call_seconds_bucket{code=\"RESOURCE_EXHAUSTED\",rpc=\"Render\",le=\"" + seconds + "\"} ";
    std::istringstream lines(HttpGet(server_->http_address(), "/metrics"));
    for (std::string line; std::getline(lines, line);) {
      if (line.starts_with(begin)) return std::stoi(line.substr(begin.size()));
    }
    return 0;
  }

  // So many clients, a connection each, that ask again as soon as they are answered; one that is refused pauses.
  Outcome Drive(int clients, std::chrono::milliseconds time, std::chrono::milliseconds pause) {
    const std::string scene = MakeScene();
    Outcome sum;
    std::mutex mutex;
    std::atomic<uint32_t> seed{1000};
    const auto end = Clock::now() + time;
    std::vector<std::thread> threads;
    for (int i = 0; i < clients; ++i) {
      threads.emplace_back([&, i] {
        grpc::ChannelArguments own;
        own.SetInt("client", i);  // or channels would share a connection
        const auto stub = v1::RenderService::NewStub(
            grpc::CreateCustomChannel(server_->grpc_address(), grpc::InsecureChannelCredentials(), own));
        Outcome outcome;
        while (Clock::now() < end) {
          v1::RenderRequest request = Request(scene);
          request.set_seed(++seed);
          grpc::ClientContext context;
          v1::RenderResponse response;
          const auto begin = Clock::now();
          const grpc::Status status = stub->Render(&context, request, &response);
          if (status.ok()) {
            ++outcome.served;
          } else if (status.error_code() == grpc::StatusCode::RESOURCE_EXHAUSTED) {
            ++outcome.refused;
            outcome.refusal_ms.push_back(std::chrono::duration<double, std::milli>(Clock::now() - begin).count());
            outcome.without_pushback += context.GetServerTrailingMetadata().count(kPushbackKey) != 1;
            std::this_thread::sleep_for(pause);
          } else {
            ++outcome.others;
          }
        }
        const std::lock_guard lock(mutex);
        sum.served += outcome.served;
        sum.refused += outcome.refused;
        sum.others += outcome.others;
        sum.without_pushback += outcome.without_pushback;
        sum.refusal_ms.insert(sum.refusal_ms.end(), outcome.refusal_ms.begin(), outcome.refusal_ms.end());
      });
    }
    for (std::thread& thread : threads) thread.join();
    return sum;
  }
};

// Ten times what two contexts and a queue of eight hold at a time.
TEST_F(OverloadTest, AtTenTimesItsCapacityItServesOnAndSaysNoAtOnce) {
  const Outcome peak = Drive(10, 2s, 50ms);
  const double before_mb = ResidentMb();
  Outcome overload = Drive(100, 3s, 50ms);
  const double growth_mb = ResidentMb() - before_mb;
  const double goodput = (overload.served / 3.0) / (peak.served / 2.0);
  std::printf("served %.0f/s at peak, %.0f/s of %.0f/s asked at overload (%.2f); p99 of refusals %.1f ms; %+.0f MB\n",
              peak.served / 2.0, overload.served / 3.0, (overload.served + overload.refused) / 3.0, goodput,
              overload.Percentile99(), growth_mb);
  std::printf(
      "by the server's own clock %.2f %% of %d refusals were told within 1 ms of their arrival, %.2f %% within 10\n",
      100.0 * RefusedWithin("0.001") / RefusedWithin("+Inf"), RefusedWithin("+Inf"),
      100.0 * RefusedWithin("0.01") / RefusedWithin("+Inf"));
  EXPECT_GT(RefusedWithin("+Inf"), 0);
  EXPECT_GT(overload.refused, overload.served) << "or it was no overload";
  EXPECT_EQ(overload.others, 0);
  EXPECT_EQ(overload.without_pushback, 0);
  EXPECT_GT(goodput, 0.5) << "a collapse, on whatever machine";
  EXPECT_TRUE(!kIsPlainMemory || growth_mb < 64) << growth_mb;
  // And it recovers.
  const Outcome after = Drive(2, 500ms, 50ms);
  EXPECT_EQ(after.refused, 0);
  EXPECT_GT(after.served, 0);
}

TEST_F(OverloadTest, AModestClientIsServedBesideAGreedyOne) {
  const std::string scene = MakeScene();
  std::atomic<bool> is_over{false};
  std::vector<std::thread> greedy;
  std::atomic<uint32_t> seed{100'000};
  for (int i = 0; i < 40; ++i) {  // of one connection
    greedy.emplace_back([&] {
      while (!is_over) {
        v1::RenderRequest request = Request(scene);
        request.set_seed(++seed);
        if (!Render(request).ok()) std::this_thread::sleep_for(1ms);
      }
    });
  }
  grpc::ChannelArguments own;
  own.SetInt("client", 1);
  const auto stub = v1::RenderService::NewStub(
      grpc::CreateCustomChannel(server_->grpc_address(), grpc::InsecureChannelCredentials(), own));
  int refused = 0;
  for (int i = 0; i < 30; ++i) {
    v1::RenderRequest request = Request(scene);
    request.set_seed(++seed);
    grpc::ClientContext context;
    v1::RenderResponse response;
    refused += !stub->Render(&context, request, &response).ok();
  }
  is_over = true;
  for (std::thread& thread : greedy) thread.join();
  EXPECT_EQ(refused, 0) << "its share of the queue was there all the time";
}

}  // namespace
}  // namespace halfshade
