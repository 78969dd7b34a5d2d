// Contexts that are lost: what their calls get, what health says, and when they draw again.
#include <glad/gl.h>
#include <gmock/gmock.h>

#include <mutex>

#include "client/client.h"
#include "renderer/scene_loader/decode_image.h"
#include "tests/integration/service_fixture.h"

namespace halfshade {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

class LostContextTest : public ServiceTest {
 protected:
  std::string Health() {
    ClientOptions options;
    options.servers = {server_->grpc_address()};
    const auto client = Client::Connect(options);
    const auto health = (*client)->CheckHealth(server_->grpc_address());
    return health.ok() ? *health : std::string(health.status().message());
  }
  bool BecomesHealth(const std::string& wanted) {
    for (int i = 0; i < 5000; ++i) {
      if (Health() == wanted) return true;
      std::this_thread::sleep_for(1ms);
    }
    return false;
  }
};

TEST_F(LostContextTest, ItsCallIsRedoneOnceAndHealthSaysSoMeanwhile) {
  const std::string scene = MakeScene();
  EXPECT_EQ(Health(), "SERVING");
  losses_to_come = 1;
  make_ms = 300;
  grpc::Status status;
  std::thread call([&] { status = Render(Request(scene)); });
  EXPECT_TRUE(BecomesHealth("NOT_SERVING"));
  call.join();
  EXPECT_TRUE(status.ok()) << status.error_message();
  EXPECT_EQ(renders_begun, 2);
  EXPECT_EQ(contexts_made, 2);
  EXPECT_TRUE(BecomesHealth("SERVING"));
}

TEST_F(LostContextTest, ACallThatLosesTwoContextsIsUnavailable) {
  const std::string scene = MakeScene();
  losses_to_come = 2;
  const grpc::Status status = Render(Request(scene));
  EXPECT_EQ(status.error_code(), grpc::StatusCode::UNAVAILABLE);
  EXPECT_THAT(status.error_message(), HasSubstr("the GL context is lost"));
  EXPECT_EQ(renders_begun, 2);
  EXPECT_TRUE(Render(Request(scene)).ok());
}

TEST_F(LostContextTest, ASecondContextDrawsWhileOneIsMadeAnew) {
  server_.reset();
  options_.contexts = 2;
  Start();
  const std::string scene = MakeScene();
  contexts_made = 1;
  losses_to_come = 1;
  make_ms = 60'000;  // longer than the test
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_TRUE(Render(Request(scene)).ok());
  EXPECT_TRUE(Render(Request(scene)).ok());
  EXPECT_LT(std::chrono::steady_clock::now() - begin, 50s);
  EXPECT_EQ(Health(), "NOT_SERVING") << "one context is lost";
  make_ms = 0;
}

// Real GL.
class LostGlContextTest : public LostContextTest {
 protected:
  void SetUp() override {
    options_.listen = "127.0.0.1:0";
    options_.canary_ms = 3'600'000;  // or it would take the faults that are meant for a render
    const RendererFactory make =
        MakeGlRendererFactory({}, [](const EncodedImage& image) { return DecodeImage(image, 1 << 20); }, {});
    options_.renderer_factory = [this, make]() -> absl::StatusOr<WorkerRenderer> {
      auto worker = make();
      const std::lock_guard lock(mutex_);
      if (worker.ok()) {
        context_ = worker->context.get();
        ++made_;
      }
      return worker;
    };
    Start();
  }
  void Inject(unsigned error, int checks) {
    const std::lock_guard lock(mutex_);
    context_->InjectError(error, checks);
  }

  std::mutex mutex_;
  gl::Context* context_ = nullptr;
  int made_ = 0;  // another may stand where the first stood
};

// At the first GL check of a render, the second, ... up to the last: a wrong picture never, and a context that draws
// on.
TEST_F(LostGlContextTest, WhereverAFrameLosesItsContextThePictureIsTheSame) {
  v1::RenderRequest request = Request(MakeScene());
  request.set_cache(v1::CACHE_MODE_REFRESH);
  request.mutable_method()->mutable_multi_map()->set_k(4);
  v1::RenderResponse whole;
  grpc::ClientContext context;
  ASSERT_TRUE(renders_->Render(&context, request, &whole).ok());
  std::chrono::duration<double> longest{};
  for (int checks = 0; checks < 40; checks += checks < 8 ? 1 : 8) {
    Inject(GL_CONTEXT_LOST, checks);
    grpc::ClientContext again;
    v1::RenderResponse response;
    const auto begin = std::chrono::steady_clock::now();
    const grpc::Status status = renders_->Render(&again, request, &response);
    longest = std::max<std::chrono::duration<double>>(longest, std::chrono::steady_clock::now() - begin);
    ASSERT_TRUE(status.ok()) << status.error_message();
    EXPECT_EQ(response.report().outputs(0).pixel_sha256(), whole.report().outputs(0).pixel_sha256()) << checks;
  }
  std::printf("a frame whose context is lost, made anew and drawn again takes at most %.0f ms\n",
              longest.count() * 1e3);
}

TEST_F(LostGlContextTest, OutOfMemoryAndErrorsEndTheirCallAlone) {
  v1::RenderRequest request = Request(MakeScene());
  request.set_cache(v1::CACHE_MODE_REFRESH);
  Inject(GL_OUT_OF_MEMORY, 2);
  const grpc::Status exhausted = Render(request);
  EXPECT_EQ(exhausted.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED) << exhausted.error_message();
  EXPECT_TRUE(Render(request).ok());
  Inject(GL_INVALID_OPERATION, 2);
  const grpc::Status status = Render(request);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::INTERNAL);
  EXPECT_THAT(status.error_message(), HasSubstr("GL_INVALID_OPERATION"));
  EXPECT_TRUE(Render(request).ok());
}

TEST_F(LostGlContextTest, AnIdleContextThatIsLostIsFoundAndMadeAnew) {
  server_.reset();
  options_.canary_ms = 50;
  Start();
  ASSERT_TRUE(Render(Request(MakeScene())).ok());
  const int made = made_;
  Inject(GL_CONTEXT_LOST, 0);
  const auto is_another = [&] {
    const std::lock_guard lock(mutex_);
    return made_ > made;
  };
  for (int i = 0; i < 10'000 && !is_another(); ++i) std::this_thread::sleep_for(1ms);
  EXPECT_TRUE(is_another());
  EXPECT_TRUE(BecomesHealth("SERVING"));
}

}  // namespace
}  // namespace halfshade
