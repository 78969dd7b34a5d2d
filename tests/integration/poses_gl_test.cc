// A moving scene through the real service: what is kept of one moment never shows at another.
#include <gmock/gmock.h>
#include <google/protobuf/util/message_differencer.h>
#include <gtest/gtest.h>

#include <map>
#include <string>
#include <vector>

#include "client/client.h"
#include "server/digest.h"
#include "server/scene_name.h"
#include "tests/renderer/scene_loader/gltf_builder.h"
#include "tests/support/status_matchers.h"

namespace halfshade {
namespace {

using testing::HasSubstr;

enum class Mover { kNothing, kNode, kSkin, kTargets };

// A plate of 1 x 1 m, half a metre above the ground, whose centre stands at x.
GltfBuilder Plate(float x) {
  GltfBuilder gltf;
  const float a = x - 0.5f, b = x + 0.5f;
  gltf.primitive()["attributes"]["POSITION"] =
      gltf.Accessor<float>({a, 0.5, -0.5, b, 0.5, -0.5, b, 0.5, 0.5, a, 0.5, 0.5}, "VEC3", 5126);
  gltf.primitive()["indices"] = gltf.Accessor<uint8_t>({0, 2, 1, 0, 3, 2}, "SCALAR", 5121);
  return gltf;
}

// A plate that goes one metre along x in a second, for two seconds.
GltfBuilder MovingPlate(Mover mover) {
  GltfBuilder gltf = Plate(0);
  if (mover == Mover::kNothing) return gltf;
  const size_t times = gltf.Accessor<float>({0, 2}, "SCALAR", 5126);
  const size_t moves = mover == Mover::kTargets ? gltf.Accessor<float>({0, 1}, "SCALAR", 5126)
                                                : gltf.Accessor<float>({0, 0, 0, 2, 0, 0}, "VEC3", 5126);
  size_t node = 0;
  if (mover == Mover::kSkin) {
    gltf.primitive()["attributes"]["JOINTS_0"] = gltf.Accessor(std::vector<uint8_t>(16, 0), "VEC4", 5121);
    gltf.primitive()["attributes"]["WEIGHTS_0"] =
        gltf.Accessor<float>({1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, "VEC4", 5126);
    gltf.json["nodes"][0]["skin"] = 0;
    gltf.json["nodes"].push_back({{"name", "joint"}});
    gltf.json["scenes"][0]["nodes"] = {0, 1};
    gltf.json["skins"] = {{{"joints", {1}}}};
    node = 1;
  }
  if (mover == Mover::kTargets) {
    gltf.primitive()["targets"] = {
        {{"POSITION", gltf.Accessor<float>({2, 0, 0, 2, 0, 0, 2, 0, 0, 2, 0, 0}, "VEC3", 5126)}}};
  }
  gltf.json["animations"] = {
      {{"samplers", {{{"input", times}, {"output", moves}}}},
       {"channels",
        {{{"sampler", 0},
          {"target", {{"node", node}, {"path", mover == Mover::kTargets ? "weights" : "translation"}}}}}}}};
  return gltf;
}

SceneFiles FilesOf(const GltfBuilder& gltf) {
  SceneFiles files;
  files.root.bytes = gltf.Text();
  files.root.digest = Sha256Hex(files.root.bytes);
  SceneFile& buffer = files.files.emplace_back();
  buffer.uri = "a b.bin";
  buffer.bytes = gltf.bytes;
  buffer.digest = Sha256Hex(buffer.bytes);
  files.name = SceneName(files.root.digest, {{buffer.uri, buffer.digest}});
  return files;
}

v1::RenderRequest RequestOf(const SceneFiles& files) {
  v1::RenderRequest request;
  request.set_scene(files.name);
  request.set_width(96);
  request.set_height(64);
  request.mutable_ground()->set_size_m(8);
  v1::LookAt* camera = request.mutable_camera()->mutable_look_at();
  camera->mutable_eye()->set_y(3);
  camera->mutable_eye()->set_z(4);
  camera->mutable_target()->set_x(1);
  camera->set_fovy_deg(45);
  v1::AreaLight* light = request.add_lights();
  light->mutable_center()->set_y(2);
  light->mutable_edge_u()->set_x(0.5);
  light->mutable_edge_v()->set_z(0.5);
  light->mutable_direction()->set_y(-1);
  for (const v1::OutputKind kind : {v1::OUTPUT_KIND_VISIBILITY, v1::OUTPUT_KIND_DEPTH}) {
    v1::Output* output = request.add_outputs();
    output->set_kind(kind);
    output->set_encoding(v1::ENCODING_RAW_F32);
  }
  return request;
}

// Puts a node to x.
void Move(uint32_t node, float x, v1::RenderRequest* request) {
  v1::NodeOverride* change = request->add_node_overrides();
  change->set_index(node);
  for (int i = 0; i < 16; ++i) change->add_transform(i % 5 == 0 ? 1 : i == 12 ? x : 0);
}

const std::map<std::string, v1::Method>& Methods() {
  static const auto& methods = *[] {
    auto* all = new std::map<std::string, v1::Method>;
    (*all)["hard"].mutable_hard();
    (*all)["multi_map"].mutable_multi_map();
    (*all)["ray"].mutable_ray()->set_rays(16);
    (*all)["pcss"].mutable_pcss();
    (*all)["sssm"].mutable_sssm();
    (*all)["ssm"].mutable_ssm();
    (*all)["pdsm"].mutable_pdsm();
    (*all)["shaft"].mutable_shaft();
    return all;
  }();
  return methods;
}

class PosesTest : public testing::Test {
 protected:
  void SetUp() override {
    auto client = Client::Connect({});
    ASSERT_OK(client);
    client_ = *std::move(client);
  }

  v1::RenderResponse Render(const v1::RenderRequest& request, const SceneFiles& files) {
    auto response = client_->Render(request, &files);
    EXPECT_OK(response);
    return response.ok() ? *response : v1::RenderResponse();
  }
  v1::RenderReport Plan(const v1::RenderRequest& request, const SceneFiles& files) {
    v1::PlanRenderRequest plan;
    *plan.mutable_request() = request;
    auto response = client_->PlanRender(plan, &files);
    EXPECT_OK(response);
    if (!response.ok()) return {};
    response->mutable_plan()->clear_timing();
    return response->plan();
  }
  std::string Query(const v1::RenderRequest& request, const SceneFiles& files) {
    v1::QueryVisibilityRequest query;
    *query.mutable_request() = request;
    for (int i = 0; i < 25; ++i) {
      const float point[3] = {0.1f * float(i), 0.01f, 0};
      query.mutable_points()->append(reinterpret_cast<const char*>(point), sizeof(point));
    }
    auto response = client_->QueryVisibility(query, &files);
    EXPECT_OK(response);
    return response.ok() ? response->visibility() : "";
  }

  std::unique_ptr<Client> client_;
};

// Forth and back, so that everything kept of a moment is met again; the truth is a file in which nothing moves.
TEST_F(PosesTest, EveryMomentIsThatOfAFileThatStandsThere) {
  constexpr double kTimes[] = {0, 1, 0, 2, 1, 1.5, 9};
  for (const Mover mover : {Mover::kNode, Mover::kSkin, Mover::kTargets}) {
    const SceneFiles files = FilesOf(MovingPlate(mover));
    for (const auto& [name, method] : Methods()) {
      v1::RenderRequest request = RequestOf(files);
      *request.mutable_method() = method;
      std::map<double, std::string> keys;
      for (const double time_s : kTimes) {
        const std::string place = name + " " + std::to_string(int(mover)) + " at " + std::to_string(time_s);
        request.mutable_animation()->set_time_s(time_s);
        const float x = float(std::min(time_s, 2.0));
        // What a request moves pdsm leaves to ssm, whoever says so (light_layers.h).
        const bool is_apart = mover == Mover::kNode && name == "pdsm";
        const SceneFiles still_files = FilesOf(Plate(is_apart ? 0 : x));
        v1::RenderRequest still = request;
        still.set_scene(still_files.name);
        still.clear_animation();
        if (is_apart) Move(0, x, &still);
        const v1::RenderResponse moved = Render(request, files), stands = Render(still, still_files);
        ASSERT_EQ(moved.images_size(), 2) << place;
        EXPECT_TRUE(moved.images(0).data() == stands.images(0).data()) << place;
        EXPECT_TRUE(moved.images(1).data() == stands.images(1).data()) << place;
        keys[std::min(time_s, 2.0)] += moved.report().content_key();
        EXPECT_TRUE(Query(request, files) == Query(still, still_files)) << place;
        EXPECT_TRUE(google::protobuf::util::MessageDifferencer::Equals(Plan(request, files), Plan(still, still_files)))
            << place;
      }
      EXPECT_EQ(keys[0].substr(0, 64), keys[0].substr(64)) << "met again, the same name";
      EXPECT_NE(keys[0].substr(0, 64), keys[1].substr(0, 64)) << "another moment, another name";
      EXPECT_EQ(keys[2].substr(0, 64), keys[2].substr(64)) << "after the end the last key holds, under one name";
    }
  }
}

TEST_F(PosesTest, WhatIsTestedMovesAtAll) {
  const SceneFiles files = FilesOf(MovingPlate(Mover::kSkin));
  v1::RenderRequest request = RequestOf(files);
  const std::string before = Query(request, files);
  request.mutable_animation()->set_time_s(2);
  EXPECT_NE(Query(request, files), before);
}

TEST_F(PosesTest, WhatMovesNoJointLeavesTheSceneAsItIs) {
  const SceneFiles files = FilesOf(MovingPlate(Mover::kSkin));
  v1::RenderRequest request = RequestOf(files);
  const std::string at_rest = Query(request, files);
  Move(0, 5, &request);
  EXPECT_EQ(Query(request, files), at_rest) << "a skinned mesh stands where its joints do";
  request.clear_node_overrides();
  Move(1, 5, &request);
  EXPECT_NE(Query(request, files), at_rest) << "and goes with them";
}

TEST_F(PosesTest, AnAnimationThatTheSceneLacksIsRefusedWithTheirNumber) {
  for (const auto& [mover, message] : {std::pair{Mover::kNode, "animation.index: 1; the scene has 1 animations"},
                                       std::pair{Mover::kNothing, "animation.index: 1; the scene has 0 animations"}}) {
    const SceneFiles files = FilesOf(MovingPlate(mover));
    v1::RenderRequest request = RequestOf(files);
    request.mutable_animation()->set_index(1);
    EXPECT_THAT(client_->Render(request, &files), StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr(message)));
  }
}

}  // namespace
}  // namespace halfshade
