// What operators see: /metrics, the ids of calls, the log's lines.
#include "server/metrics.h"

#include <gmock/gmock.h>

#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "halfshade/v1/server.grpc.pb.h"
#include "server/call_log.h"
#include "server/log.h"
#include "tests/integration/http_get.h"
#include "tests/integration/service_fixture.h"

namespace halfshade {
namespace {

using testing::HasSubstr;
using testing::Not;

// Every line is a comment or "name{labels} value"; a name has one HELP and one TYPE, before its values, all together.
void ExpectWellFormed(const std::string& text) {
  std::set<std::string> closed;
  std::string open;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    const bool is_help = line.starts_with("# HELP ");
    const std::string name =
        line.starts_with("# ") ? line.substr(7, line.find(' ', 7) - 7) : line.substr(0, line.find_first_of("{ "));
    EXPECT_EQ(name.find_first_not_of("abcdefghijklmnopqrstuvwxyz_0123456789"), std::string::npos) << line;
    if (is_help) {
      closed.insert(open);
      EXPECT_FALSE(closed.contains(name)) << name << " twice";
      open = name;
    } else {
      EXPECT_TRUE(name.starts_with(open)) << line << " within " << open;
    }
  }
}

TEST(MetricsTest, CountsCallsByCodeAndRendersByStageMethodSkipAndError) {
  Metrics metrics;
  metrics.CountCall("Render", absl::StatusCode::kOk, 0.015);
  metrics.CountCall("Render", absl::StatusCode::kOk, 3);
  metrics.CountCall("Render", absl::StatusCode::kResourceExhausted, 0.0001);
  v1::RenderReport report;
  report.set_method("shaft");
  report.mutable_timing()->set_resolve_ms(30);
  v1::Pass* pass = report.add_passes();
  pass->set_name("light[7]/shaft");
  pass->set_skipped(true);
  report.mutable_error()->set_measured(0.004);
  metrics.CountRender(report);
  const std::string text = metrics.Text({{"halfshade_queue_waiting", "Waiting.", false, "", "", 3},
                                         {"halfshade_cache_bytes", "Bytes.", false, "cache", "scene", 5},
                                         {"halfshade_cache_bytes", "Bytes.", false, "cache", "view", 6}});
  ExpectWellFormed(text);
  EXPECT_THAT(text, HasSubstr("halfshade_calls_total{code=\"OK\",rpc=\"Render\"} 2"));
  EXPECT_THAT(text, HasSubstr("halfshade_calls_total{code=\"RESOURCE_EXHAUSTED\",rpc=\"Render\"} 1"));
  EXPECT_THAT(text, HasSubstr("halfshade_call_seconds_bucket{code=\"OK\",rpc=\"Render\",le=\"0.02\"} 1"));
  EXPECT_THAT(text,
              HasSubstr("halfshade_call_seconds_bucket{code=\"RESOURCE_EXHAUSTED\",rpc=\"Render\",le=\"0.001\"} 1"));
  EXPECT_THAT(text, HasSubstr("halfshade_renders_total{method=\"shaft\"} 1"));
  EXPECT_THAT(text, HasSubstr("halfshade_stage_seconds_sum{stage=\"resolve\"} 0.03"));
  EXPECT_THAT(text, HasSubstr("halfshade_skips_total{pass=\"shaft\"} 1"));
  EXPECT_THAT(text, HasSubstr("halfshade_visibility_error_count{kind=\"measured\"} 1"));
  EXPECT_THAT(text, Not(HasSubstr("kind=\"predicted\""))) << "nothing was";
  EXPECT_THAT(text, HasSubstr("halfshade_queue_waiting 3"));
  EXPECT_THAT(text, HasSubstr("halfshade_cache_bytes{cache=\"view\"} 6"));
  EXPECT_THAT(text, HasSubstr("process_resident_memory_bytes "));
}

TEST(TraceparentTest, IsAsW3cHasIt) {
  const std::string good = "00-0af7651916cd43dd8448eb211c80319c-b7ad6b7169203331-01";
  EXPECT_TRUE(IsTraceparent(good));
  for (const std::string& bad :
       {std::string(), good + "0", "01" + good.substr(2), "00-" + std::string(32, '0') + good.substr(35),
        good.substr(0, 36) + std::string(16, '0') + good.substr(52), "00-0AF7651916CD43DD" + good.substr(19),
        good.substr(0, 54) + "\n"}) {
    EXPECT_FALSE(IsTraceparent(bad)) << bad;
  }
}

TEST(LogTest, AnEndIsOneLineOfTextOrTheFieldsOfAnObject) {
  const CallLine line = {.request_id = "a-1",
                         .rpc = "Render",
                         .peer = "ipv4:127.0.0.1:5",
                         .traceparent = "",
                         .code = "INVALID_ARGUMENT",
                         .message = "scene: \"\n\xff\"",
                         .ms = 12.25};
  EXPECT_THAT(ToText(line), testing::StartsWith("a-1 Render INVALID_ARGUMENT 12 ms: scene: "));
  const auto object = nlohmann::json::parse("{" + ToJsonFields(line) + "}");
  EXPECT_EQ(object["rpc"], "Render");
  EXPECT_EQ(object["ms"], 12.25);
  EXPECT_EQ(object["message"], "scene: \"\n\uFFFD\"");
  EXPECT_FALSE(object.contains("traceparent"));
}

class MetricsServiceTest : public ServiceTest {
 protected:
  void SetUp() override {
    options_.http = "127.0.0.1:0";
    ServiceTest::SetUp();
  }
};

TEST_F(MetricsServiceTest, CallsAreCountedAndHaveAnIdThatTheirErrorsCarry) {
  const std::string scene = MakeScene();
  grpc::ClientContext good, bad;
  EXPECT_TRUE(Render(Request(scene), &good).ok());
  v1::RenderRequest request = Request(scene);
  request.set_width(99999);
  bad.AddMetadata("traceparent", "00-0af7651916cd43dd8448eb211c80319c-b7ad6b7169203331-01");
  EXPECT_FALSE(Render(request, &bad).ok());
  const auto id_of = [](const grpc::ClientContext& context) {
    const auto found = context.GetServerTrailingMetadata().find(kRequestIdKey);
    return found == context.GetServerTrailingMetadata().end() ? std::string()
                                                              : std::string(found->second.data(), found->second.size());
  };
  EXPECT_NE(id_of(good), "");
  EXPECT_NE(id_of(bad), "");
  EXPECT_NE(id_of(good), id_of(bad));
  const std::string text = HttpGet(server_->http_address(), "/metrics");
  ExpectWellFormed(text);
  EXPECT_THAT(text, HasSubstr("halfshade_calls_total{code=\"OK\",rpc=\"Render\"} 1"));
  EXPECT_THAT(text, HasSubstr("halfshade_calls_total{code=\"INVALID_ARGUMENT\",rpc=\"Render\"} 1"));
  EXPECT_THAT(text, HasSubstr("halfshade_calls_total{code=\"OK\",rpc=\"CreateScene\"} 1"));
  EXPECT_THAT(text, HasSubstr("halfshade_queue_capacity 2"));
  EXPECT_THAT(text, HasSubstr("halfshade_contexts 1"));
  EXPECT_THAT(text, HasSubstr("halfshade_cache_misses_total{cache=\"result\"} 1"));
}

}  // namespace
}  // namespace halfshade
