#include "server/fence.h"

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <thread>
#include <vector>

#include "client/glb_writer.h"
#include "renderer/scene/flat_form.h"
#include "renderer/scene_loader/decode_image.h"
#include "tests/renderer/scene_loader/png.h"
#include "tests/support/flat_scene_builder.h"
#include "tests/support/status_matchers.h"

namespace halfshade {
namespace {

using absl::StatusCode;
using testing::AllOf;
using testing::HasSubstr;

std::unique_ptr<Fence> Raise(const FenceOptions& options) {
  auto fence = Fence::Raise(options);
  EXPECT_OK(fence);
  return fence.ok() ? *std::move(fence) : nullptr;
}

// The real loader.
class FenceTest : public testing::Test {
 protected:
  void SetUp() override {
    options_.loader = HALFSHADE_SCENE_LOADER;
    fence_ = Raise(options_);
    ASSERT_NE(fence_, nullptr);
  }
  FenceOptions options_;
  std::unique_ptr<Fence> fence_;
};

TEST_F(FenceTest, ASceneIsTheOneThatIsLoadedWithoutAFence) {
  const std::string glb = WriteGlb({MakeSphere({1, 2, 3}, 1, 16), MakePlate({0, 0, 0}, 4, 4)});
  const auto fenced = fence_->Load(glb, {}, {});
  ASSERT_OK(fenced);
  EXPECT_EQ(FlatSceneBytes(*fenced), FlatSceneBytes(*LoadGltf(glb, {}, {})));
  EXPECT_GT(Fence::last_cpu_s(), 0);
}

TEST_F(FenceTest, FilesComeToTheLoaderByTheirUris) {
  const std::string bytes(36, '\0'), other = "other";
  const std::string root = R"({"asset":{"version":"2.0"},"buffers":[{"uri":"a%20b.bin","byteLength":36}],)"
                           R"("bufferViews":[{"buffer":0,"byteLength":36}]})";
  EXPECT_OK(fence_->Load(root, {{"a b.bin", &bytes}, {"other.bin", &other}}, {}));
  EXPECT_THAT(fence_->Load(root, {{"other.bin", &other}}, {}),
              StatusIs(StatusCode::kInvalidArgument, HasSubstr("/buffers/0")));
}

TEST_F(FenceTest, RefusalsAndLimitsAreTheLoadersOwn) {
  EXPECT_EQ(fence_->Load("no glTF", {}, {}).status(), LoadGltf("no glTF", {}, {}).status());
  const std::string glb = WriteGlb({MakePlate({0, 0, 0}, 1, 1)});
  SceneLoadLimits limits;
  limits.max_triangles = 2;
  EXPECT_OK(fence_->Load(glb, {}, limits));
  limits.max_triangles = 1;
  EXPECT_THAT(fence_->Load(glb, {}, limits), StatusIs(StatusCode::kInvalidArgument, HasSubstr("1 triangles")));
}

TEST_F(FenceTest, AnImageIsTheOneThatIsDecodedWithoutAFence) {
  EncodedImage image;
  image.name = "/images/0";
  image.bytes = MakePng(5, 3);
  const auto fenced = fence_->Decode(image, 15);
  ASSERT_OK(fenced);
  EXPECT_EQ(fenced->width, 5);
  EXPECT_EQ(fenced->height, 3);
  EXPECT_EQ(fenced->texels, DecodeImage(image, 15)->texels);
  EXPECT_THAT(fence_->Decode(image, 14), StatusIs(StatusCode::kInvalidArgument, HasSubstr("/images/0: 15 pixels")));
}

TEST_F(FenceTest, ManyAtATimeDoNotMixTheirAnswers) {
  std::vector<std::thread> threads;
  for (int t = 1; t <= 8; ++t) {
    threads.emplace_back([this, t] {
      const std::string glb = WriteGlb(std::vector<GlbMesh>(size_t(t), MakePlate({0, 0, 0}, 1, 1)));
      for (int i = 0; i < 5; ++i) {
        const auto scene = fence_->Load(glb, {}, {});
        ASSERT_OK(scene);
        EXPECT_EQ(scene->indices.size(), size_t(6 * t));
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
}

TEST(RaiseTheFenceTest, SaysWhatKeepsItFromStanding) {
  FenceOptions options;
  options.loader = "/nowhere/halfshade-scene-loader";
  EXPECT_THAT(Fence::Raise(options),
              StatusIs(StatusCode::kFailedPrecondition, AllOf(HasSubstr("/nowhere"), HasSubstr("No such file"))));
  options.loader = "/bin/true";
  EXPECT_THAT(Fence::Raise(options), StatusIs(StatusCode::kFailedPrecondition, HasSubstr("it is cut")));
}

// A loader that does what its task tells it, behind the same fence.
class BrokenLoaderTest : public testing::Test {
 protected:
  void SetUp() override {
    options_.loader = HALFSHADE_FAULT_LOADER;
    options_.memory_mb = 256;
    options_.cpu_s = 1;
    options_.wall_s = 60;
  }
  absl::Status Do(const std::string& what) {
    const auto fence = Raise(options_);
    const absl::Status status = fence->Load(what, {}, {}).status();
    EXPECT_OK(fence->Load(R"({"asset":{"version":"2.0"}})", {}, {})) << "the next one is well";
    return status;
  }
  FenceOptions options_;
};

TEST_F(BrokenLoaderTest, ACrashIsTheFaultOfItsSceneAlone) {
  EXPECT_THAT(Do("crash"),
              StatusIs(StatusCode::kInvalidArgument, HasSubstr("/: reading it crashes the scene loader (signal 11)")));
  EXPECT_THAT(Do("abort"), StatusIs(StatusCode::kInvalidArgument, HasSubstr("(signal 6)")));
}

// Killed by SIGSYS (31) before the call does anything.
TEST_F(BrokenLoaderTest, NoFileNoSocketNoProcessNoCodeNoSignal) {
  for (const char* what : {"open", "create", "socket", "fork", "execute", "code", "kill"}) {
    EXPECT_THAT(Do(what), StatusIs(StatusCode::kInvalidArgument, HasSubstr("(signal 31)"))) << what;
  }
  EXPECT_FALSE(std::filesystem::exists("/tmp/halfshade_fault"));
}

TEST_F(BrokenLoaderTest, MemoryHasALimit) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers reserve terabytes";
#endif
  EXPECT_OK(Do("allocate_mb:128"));
  EXPECT_THAT(Do("allocate_mb:256"), StatusIs(StatusCode::kResourceExhausted, HasSubstr("more than 256 MB of memory")));
  options_.memory_mb = 512;
  EXPECT_OK(Do("allocate_mb:256"));
}

TEST_F(BrokenLoaderTest, TheAnswerHasTheSameLimit) {
  EXPECT_THAT(Do("answer_mb:256"), StatusIs(StatusCode::kInternal, HasSubstr("answer")));  // nonsense, but whole
  EXPECT_THAT(Do("answer_mb:257"), StatusIs(StatusCode::kResourceExhausted, HasSubstr("more than 256 MB")));
}

TEST_F(BrokenLoaderTest, CpuTimeHasALimitThatGrowsWithTheBytes) {
  EXPECT_OK(Do("burn_ms:700"));
  EXPECT_THAT(Do("loop"),
              StatusIs(StatusCode::kResourceExhausted, HasSubstr("its 4 bytes takes more than 1 s of CPU time")));
  std::string longer = "burn_ms:1700 ";
  longer.resize(FenceOptions::kBytesPerSecond - 1, ' ');
  EXPECT_EQ(Do(longer).code(), StatusCode::kResourceExhausted);
  longer.resize(FenceOptions::kBytesPerSecond, ' ');
  EXPECT_OK(Do(longer));
}

TEST_F(BrokenLoaderTest, OneThatIsStuckIsEnded) {
  options_.wall_s = 2;
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_THAT(Do("stop"), StatusIs(StatusCode::kResourceExhausted, HasSubstr("takes more than 2 s")));
  EXPECT_GE(std::chrono::steady_clock::now() - begin, std::chrono::seconds(2));
}

TEST_F(BrokenLoaderTest, AnAnswerThatIsNoneIsOurFault) {
  EXPECT_THAT(Do("nonsense"), StatusIs(StatusCode::kInternal, HasSubstr("flat scene")));
  EXPECT_THAT(Do("silence"), StatusIs(StatusCode::kInternal, HasSubstr("it is cut")));
  EXPECT_THAT(Do("exit:3"), StatusIs(StatusCode::kInternal, HasSubstr("exit code 3")));
}

TEST_F(BrokenLoaderTest, ItsWordsDoNotHoldItUpAndAreNotKept) {
  EXPECT_THAT(Do("talk:20000000"), StatusIs(StatusCode::kInvalidArgument, HasSubstr("(signal 6)")));
}

}  // namespace
}  // namespace halfshade
