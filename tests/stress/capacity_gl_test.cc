// What a server serves: previews a second and how long each takes, by clients, contexts and sizes, beside the same
// renders without a server. HALFSHADE_CAPACITY_SECONDS says how long each row takes and asks for the whole table; short
// rows of a few clients unless set. It prints; what it holds to is that every call is served.
#include <grpcpp/create_channel.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <thread>

#include "client/bench/cases.h"
#include "client/client.h"
#include "halfshade/v1/render.grpc.pb.h"
#include "server/encode.h"
#include "server/log.h"
#include "server/output_format.h"
#include "server/server.h"
#include "tests/support/flat_scene_builder.h"
#include "tests/support/render_fixture.h"
#include "tests/support/scene_makers.h"

namespace halfshade {
namespace {

using Clock = std::chrono::steady_clock;

double Ms(Clock::duration time) { return std::chrono::duration<double, std::milli>(time).count(); }

struct Row {
  int clients = 1, contexts = 1;
  uint32_t width = 640, height = 360;
  int scenes = 1;
  uint64_t cache_mb = 1024;  // of scenes, in memory and on contexts
};

struct Served {
  double per_second = 0, p50_ms = 0, p99_ms = 0;
};

// Where a light is dragged to next, with a server or without: no two are alike, so that no light data is found again.
double DragOn() {
  static std::atomic<int> steps = 0;
  return 0.3 * std::sin(0.37 * steps++);
}

bench::Case PreviewOf(const Row& row, int scene) {
  return bench::MakeCase(
      {.scene = "S5", .triangles = 20'000u + 100u * uint32_t(scene), .width = row.width, .height = row.height});
}

class CapacityTest : public testing::Test {
 protected:
  static void SetUpTestSuite() { SetUpLog("off", false); }

  void Start(const Row& row) {
    server_.reset();
    ServerOptions options;
    options.listen = "127.0.0.1:0";
    options.contexts = row.contexts;
    options.scene_cache_mb = options.gl_scene_mb = row.cache_mb;
    auto server = Server::Start(options);
    ASSERT_OK(server);
    server_ = *std::move(server);
    ClientOptions client_options;
    client_options.servers = {server_->grpc_address()};
    const auto client = Client::Connect(client_options);
    ASSERT_OK(client);
    requests_.clear();
    for (int i = 0; i < row.scenes; ++i) {
      bench::Case preview = PreviewOf(row, i);
      ASSERT_OK((*client)->UploadScene(preview.files));
      preview.request.mutable_method()->mutable_pcss();
      v1::Output* output = preview.request.add_outputs();
      output->set_kind(v1::OUTPUT_KIND_FRAME);
      output->set_encoding(v1::ENCODING_JPEG);
      ASSERT_OK((*client)->Render(preview.request, nullptr));
      requests_.push_back(std::move(preview.request));
    }
  }

  // One client, a connection of its own, a call at a time; told to come back it does.
  void Ask(const Row& row, int number, Clock::time_point end, std::vector<double>* ms) {
    ClientOptions options;
    options.servers = {server_->grpc_address()};
    options.is_timeout_per_call = true;
    const auto client = Client::Connect(options);
    ASSERT_OK(client);
    for (int n = number; Clock::now() < end; n += row.clients) {
      v1::RenderRequest request = requests_[size_t(n) % requests_.size()];
      v1::Vec3* center = request.mutable_lights(0)->mutable_center();
      center->set_x(center->x() + DragOn());
      const auto begin = Clock::now();
      const auto response = (*client)->Render(request, nullptr);
      EXPECT_OK(response);
      ms->push_back(Ms(Clock::now() - begin));
    }
  }

  Served Drive(const Row& row, double seconds) {
    const auto begin = Clock::now();
    const auto end = begin + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
    std::vector<std::vector<double>> ms(size_t(row.clients));
    std::vector<std::thread> clients;
    for (int i = 0; i < row.clients; ++i) {
      clients.emplace_back([&, i] { Ask(row, i, end, &ms[size_t(i)]); });
    }
    for (std::thread& client : clients) client.join();
    const double took_s = Ms(Clock::now() - begin) / 1000;
    std::vector<double> all;
    Served served;
    for (int i = 0; i < row.clients; ++i) {
      all.insert(all.end(), ms[size_t(i)].begin(), ms[size_t(i)].end());
    }
    std::sort(all.begin(), all.end());
    if (all.empty()) return served;
    served.per_second = double(all.size()) / took_s;
    served.p50_ms = all[all.size() / 2];
    served.p99_ms = all[all.size() * 99 / 100];
    return served;
  }

  // The same renders and encodings, one after the other on this thread: previews a second.
  static double WithoutServer(const Row& row, double seconds) {
    const FlatScene scene = MakeFlatScene(MakeScene("S5", {.triangles = 20'000, .light_share = 0.2}).meshes);
    RenderRequest request = RequestFor(MakeScene("S5", {.triangles = 20'000, .light_share = 0.2}));
    request.width = int(row.width);
    request.height = int(row.height);
    request.method = PcssOptions{};
    request.outputs = {OutputKind::kFrame};
    const double center_x = request.lights[0].center_ws.x;
    OutputFormat jpeg;
    jpeg.encoding = halfshade::Encoding::kJpeg;
    const auto go_on = [] { return absl::OkStatus(); };
    int count = -1;  // the first is not counted
    auto begin = Clock::now();
    while (count < 1 || Ms(Clock::now() - begin) < 1000 * seconds) {
      request.lights[0].center_ws.x = center_x + DragOn();
      auto result = TestRenderer().Render("capacity", scene, request, go_on);
      if (!result.ok() || !Encode(std::move(result->images), {jpeg}, go_on).ok()) return 0;
      if (++count == 0) begin = Clock::now();
    }
    return count / (Ms(Clock::now() - begin) / 1000);
  }

  std::unique_ptr<Server> server_;
  std::vector<v1::RenderRequest> requests_;
};

TEST_F(CapacityTest, EveryCallIsServedHoweverManyClients) {
  const char* const asked = std::getenv("HALFSHADE_CAPACITY_SECONDS");
  const double seconds = asked != nullptr ? std::atof(asked) : 0.5;
  std::vector<Row> rows;
  for (const int contexts : {1, 2}) {
    for (const auto& [width, height] : {std::pair(640u, 360u), std::pair(1280u, 720u)}) {
      for (const int clients : {1, 4, 16, 64}) {
        if (asked != nullptr || (clients == 4 && width == 640)) rows.push_back({clients, contexts, width, height});
      }
    }
    // Many scenes over a cache for ten.
    rows.push_back({.clients = 16, .contexts = contexts, .scenes = asked != nullptr ? 50 : 12, .cache_mb = 18});
    if (asked == nullptr) break;
  }
  std::printf("clients contexts size scenes: previews a second, of those without a server; p50, p99 ms\n");
  for (const Row& row : rows) {
    Start(row);
    // In turns, for a machine whose speed drifts.
    double alone = WithoutServer(row, seconds / 2);
    const Served served = Drive(row, seconds);
    alone = (alone + WithoutServer(row, seconds / 2)) / 2;
    std::printf("%d %d %ux%u %d: %.1f/s, %.2f; %.0f, %.0f\n", row.clients, row.contexts, row.width, row.height,
                row.scenes, served.per_second, served.per_second / alone, served.p50_ms, served.p99_ms);
    EXPECT_GT(served.per_second, 0);
  }
}

// The first byte of a preview's image that is streamed, beside the time that it took to draw and encode by the report.
TEST_F(CapacityTest, FirstBytesComeSoonAfterThePicture) {
  const char* const asked = std::getenv("HALFSHADE_CAPACITY_SECONDS");
  const Row row{.width = 1280, .height = 720};
  Start(row);
  const auto stub =
      v1::RenderService::NewStub(grpc::CreateChannel(server_->grpc_address(), grpc::InsecureChannelCredentials()));
  std::vector<double> ratios, first_ms;
  for (int n = 0; n < (asked != nullptr ? 40 : 4); ++n) {
    v1::RenderStreamRequest request;
    *request.mutable_request() = requests_[0];
    v1::Vec3* center = request.mutable_request()->mutable_lights(0)->mutable_center();
    center->set_x(center->x() + DragOn());
    grpc::ClientContext context;
    const auto begin = Clock::now();
    const auto reader = stub->RenderStream(&context, request);
    double first = 0, frame = 0;
    for (v1::RenderStreamResponse response; reader->Read(&response);) {
      if (response.has_report()) frame = response.report().timing().total_ms();
      if (first == 0 && response.part_case() == v1::RenderStreamResponse::kChunk) first = Ms(Clock::now() - begin);
    }
    const grpc::Status status = reader->Finish();
    ASSERT_TRUE(status.ok()) << status.error_message();
    ASSERT_GT(frame, 0);
    ratios.push_back(first / frame);
    first_ms.push_back(first);
  }
  std::sort(ratios.begin(), ratios.end());
  std::sort(first_ms.begin(), first_ms.end());
  std::printf("first byte after %.1f ms, %.2f of the frame's own time (medians of %zu)\n",
              first_ms[first_ms.size() / 2], ratios[ratios.size() / 2], ratios.size());
}

}  // namespace
}  // namespace halfshade
