#include "renderer/calibrate.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <thread>

#include "tests/support/status_matchers.h"

namespace halfshade {
namespace {

// Draws nothing, for as long as it is told.
class SleepingRenderer : public Renderer {
 public:
  explicit SleepingRenderer(std::vector<int> ms) : ms_(std::move(ms)) {}
  absl::StatusOr<RenderResult> Render(const std::string& name, const FlatScene&, const RenderRequest& request,
                                      const StopCheck&) override {
    EXPECT_EQ(request.cache, CacheMode::kRefresh) << "what is cached takes no time";
    scene_ = name;
    const int ms = ms_[size_t(renders_) % ms_.size()];
    ++renders_;
    if (ms < 0) return absl::InternalError("broken");
    std::this_thread::sleep_for(std::chrono::milliseconds(ms));
    return RenderResult();
  }
  void ForgetScene(const std::string& name) override { is_forgotten_ = name == scene_; }
  bool is_forgotten() const { return is_forgotten_; }

 private:
  const std::vector<int> ms_;
  int renders_ = 0;
  bool is_forgotten_ = false;
  std::string scene_;
};

TEST(MeasureSlownessTest, TheLeastTimeCountsSoThatOneHiccupDoesNot) {
  SleepingRenderer even({40}), hiccups({200, 40, 200});
  const auto slowness = MeasureSlowness(even), with_hiccups = MeasureSlowness(hiccups);
  ASSERT_OK(slowness);
  ASSERT_OK(with_hiccups);
  EXPECT_GT(*slowness, 1);
  EXPECT_LT(*with_hiccups, 3 * *slowness) << "200 ms would be five times as slow";
  EXPECT_TRUE(even.is_forgotten());
}

TEST(MeasureSlownessTest, IsBoundedOnBothSides) {
  SleepingRenderer quick({0}), slow({420});
  EXPECT_EQ(*MeasureSlowness(quick), 1.0 / 16);
  EXPECT_EQ(*MeasureSlowness(slow), 64);
}

TEST(MeasureSlownessTest, ABrokenRendererSaysSo) {
  SleepingRenderer broken({1, -1});
  EXPECT_THAT(MeasureSlowness(broken), StatusIs(absl::StatusCode::kInternal, testing::HasSubstr("broken")));
}

}  // namespace
}  // namespace halfshade
