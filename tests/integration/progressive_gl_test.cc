// Progressive streams of the real renderer: what comes first, and that what comes last is what Render gives.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>

#include "client/client.h"
#include "client/glb_writer.h"
#include "server/digest.h"
#include "server/scene_name.h"
#include "tests/support/scene_makers.h"
#include "tests/support/status_matchers.h"

namespace halfshade {
namespace {

using testing::StartsWith;

class ProgressiveTest : public testing::Test {
 protected:
  void SetUp() override {
    auto client = Client::Connect({});
    ASSERT_OK(client);
    client_ = *std::move(client);
    const MadeScene made = MakeScene("S2", {});
    files_.root.bytes = WriteGlb(made.meshes);
    files_.root.digest = Sha256Hex(files_.root.bytes);
    files_.name = SceneName(files_.root.digest, {});
    request_.set_scene(files_.name);
    request_.set_width(512);
    request_.set_height(288);
    request_.mutable_budget()->set_max_error(0.002);
    request_.mutable_ground()->set_size_m(8);
    v1::Output* output = request_.add_outputs();
    output->set_kind(v1::OUTPUT_KIND_VISIBILITY);
    output->set_encoding(v1::ENCODING_RAW_F32);
  }

  v1::RenderResponse Render(const v1::RenderRequest& request) {
    auto response = client_->Render(request, &files_);
    EXPECT_OK(response);
    return response.ok() ? *response : v1::RenderResponse();
  }
  v1::RenderResponse RenderProgressively() {
    coarse_.clear();
    auto response =
        client_->Render(request_, &files_, [this](v1::RenderResponse coarse) { coarse_.push_back(std::move(coarse)); });
    EXPECT_OK(response);
    return response.ok() ? *response : v1::RenderResponse();
  }

  std::unique_ptr<Client> client_;
  SceneFiles files_;
  v1::RenderRequest request_;
  std::vector<v1::RenderResponse> coarse_;
};

TEST_F(ProgressiveTest, TheLastIsWhatRenderGivesAndEachCoarseOneWhatItsOwnRequestGives) {
  const v1::RenderResponse whole = RenderProgressively();
  ASSERT_EQ(coarse_.size(), 2u);
  request_.set_cache(v1::CACHE_MODE_REFRESH);
  const v1::RenderResponse unary = Render(request_);
  EXPECT_EQ(whole.images(0).data(), unary.images(0).data());
  EXPECT_EQ(whole.report().outputs(0).pixel_sha256(), unary.report().outputs(0).pixel_sha256());
  EXPECT_EQ(whole.report().content_key(), unary.report().content_key());
  EXPECT_EQ(whole.report().reason(), unary.report().reason());
  const std::pair<int, double> steps[] = {{4, 0.03}, {2, 0.01}};
  double error = 1, done_ms = 0;
  for (size_t i = 0; i < coarse_.size(); ++i) {
    v1::RenderRequest own = request_;
    own.set_width(request_.width() / uint32_t(steps[i].first));
    own.set_height(request_.height() / uint32_t(steps[i].first));
    own.clear_budget();
    const v1::RenderReport& report = coarse_[i].report();
    *own.mutable_method() = report.options();
    const v1::RenderResponse expected = Render(own);
    EXPECT_EQ(coarse_[i].images(0).width(), own.width());
    EXPECT_TRUE(coarse_[i].images(0).data() == expected.images(0).data()) << i << ": " << report.reason();
    EXPECT_EQ(report.outputs(0).pixel_sha256(), Sha256Hex(coarse_[i].images(0).data()));
    EXPECT_THAT(report.reason(), StartsWith("coarse, a "));
    EXPECT_GT(report.error().predicted(), 0);
    EXPECT_LE(report.error().predicted(), steps[i].second);
    EXPECT_LE(report.error().predicted(), error);
    error = report.error().predicted();
    EXPECT_GT(report.timing().total_ms(), done_ms) << "all count from the same moment";
    done_ms = report.timing().total_ms();
  }
  EXPECT_LE(whole.report().error().predicted(), error);
  EXPECT_GT(whole.report().timing().total_ms(), done_ms);
}

TEST_F(ProgressiveTest, WhatWasRenderedBeforeComesAlone) {
  const v1::RenderResponse first = Render(request_);
  const v1::RenderResponse again = RenderProgressively();
  EXPECT_TRUE(coarse_.empty());
  EXPECT_EQ(again.images(0).data(), first.images(0).data());
}

TEST_F(ProgressiveTest, ADearFirstImageIsThereInATenthOfTheTime) {
  request_.clear_budget();
  request_.mutable_method()->mutable_ray()->set_rays(1024);
  const v1::RenderResponse whole = RenderProgressively();
  ASSERT_EQ(coarse_.size(), 2u);
  EXPECT_LT(coarse_[0].report().timing().total_ms(), 0.1 * whole.report().timing().total_ms())
      << "quarter size by 8 rows, and 1024 rays a pixel: a hundredth of the work";
}

}  // namespace
}  // namespace halfshade
