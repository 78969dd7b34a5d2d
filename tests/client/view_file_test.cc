#include "client/view_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "client/exit_code.h"
#include "client/render_flags.h"
#include "tests/client/temporary_folder.h"
#include "tests/support/status_matchers.h"

namespace halfshade {
namespace {

using testing::HasSubstr;

constexpr char kCamera[] = R"("camera": {"eye": [1, 2, 3], "target": [0, 1, 0], "up": [0, 1, 0], "fovy_deg": 40})";

std::string Light(const std::string& u, const std::string& v, const std::string& normal, const std::string& size) {
  return R"({"center": [0, 4, 0], "u": )" + u + R"(, "v": )" + v + R"(, "normal": )" + normal + size + "}";
}

// u x v = normal: 2 wide, 3 high, shining down.
const std::string kRightHanded = Light("[1, 0, 0]", "[0, 0, 1]", "[0, -1, 0]", R"(, "width": 2, "height": 3)");

absl::StatusOr<v1::RenderRequest> Read(const std::string& json) {
  const TemporaryFolder folder;
  v1::RenderRequest request;
  const absl::Status status = ApplyViewFile(folder.Write("views/v.json", json), &request);
  if (!status.ok()) return status;
  return request;
}

TEST(ViewFileTest, CameraLightAndGroundBecomeFieldsOfTheRequest) {
  const auto request = Read("{" + std::string(kCamera) + R"(, "light": )" + kRightHanded +
                            R"(, "ground": {"y": -0.5, "size": 12, "add": true}, "units": "scene units"})");
  ASSERT_OK(request);
  EXPECT_EQ(request->camera().look_at().eye().z(), 3);
  EXPECT_EQ(request->camera().look_at().target().y(), 1);
  EXPECT_EQ(request->camera().look_at().fovy_deg(), 40);
  ASSERT_EQ(request->lights_size(), 1);
  const v1::AreaLight& light = request->lights(0);
  EXPECT_EQ(light.center().y(), 4);
  EXPECT_EQ(light.edge_u().x(), 2);
  EXPECT_EQ(light.edge_v().z(), 3);
  EXPECT_FALSE(light.has_direction());
  EXPECT_EQ(request->ground().height_m(), -0.5);
  EXPECT_EQ(request->ground().size_m(), 12);
}

TEST(ViewFileTest, LeftHandedAxesNegateEdgeVSoThatTheLightShinesAlongItsNormal) {
  const auto request =
      Read(R"({"light": )" + Light("[1, 0, 0]", "[0, 0, -1]", "[0, -1, 0]", R"(, "width": 2, "height": 3)") + "}");
  ASSERT_OK(request);
  EXPECT_EQ(request->lights(0).edge_u().x(), 2);
  EXPECT_EQ(request->lights(0).edge_v().z(), 3);
}

TEST(ViewFileTest, AnEdgeOfLengthZeroBringsItsDirection) {
  const auto request =
      Read(R"({"light": )" + Light("[1, 0, 0]", "[0, 0, 1]", "[0, -1, 0]", R"(, "width": 2, "height": 0)") + "}");
  ASSERT_OK(request);
  EXPECT_EQ(request->lights(0).direction().y(), -1);
}

TEST(ViewFileTest, AGroundThatIsNotToBeAddedTakesAwayTheRequestFilesGround) {
  const TemporaryFolder folder;
  v1::RenderRequest request;
  request.mutable_ground()->set_size_m(1);
  ASSERT_OK(ApplyViewFile(folder.Write("v.json", R"({"ground": {"y": 0, "size": 1, "add": false}})"), &request));
  EXPECT_FALSE(request.has_ground());
}

TEST(ViewFileTest, WhatTheViewDoesNotStateStays) {
  const TemporaryFolder folder;
  v1::RenderRequest request;
  request.add_lights();
  request.mutable_camera()->set_index(1);
  request.set_scene("a.glb");
  ASSERT_OK(ApplyViewFile(folder.Write("v.json", "{}"), &request));
  EXPECT_EQ(request.lights_size(), 1);
  EXPECT_EQ(request.camera().index(), 1u);
  EXPECT_EQ(request.scene(), "a.glb");
}

TEST(ViewFileTest, ItsSceneLiesUnderTheFolderAboveTheViewAndTheCommandLineWins) {
  const TemporaryFolder folder;
  RenderFlags flags;
  flags.view_file = folder.Write("views/v.json", R"({"scene": "scenes/a/a.glb"})");
  auto job = PrepareRender(flags);
  ASSERT_OK(job);
  EXPECT_EQ(job->request.scene(), folder / "scenes/a/a.glb");
  flags.scene = "b.glb";
  job = PrepareRender(flags);
  ASSERT_OK(job);
  EXPECT_EQ(job->request.scene(), "b.glb");
}

TEST(ViewFileTest, SeveralLightsAreReadInOrderAndFlagsReplaceThem) {
  const TemporaryFolder folder;
  RenderFlags flags;
  flags.scene = "a.glb";
  flags.view_file = folder.Write("v.json", R"({"lights": [)" + kRightHanded + "," + kRightHanded + "]}");
  auto job = PrepareRender(flags);
  ASSERT_OK(job);
  EXPECT_EQ(job->request.lights_size(), 2);
  flags.lights = {"center=1,1,1"};
  job = PrepareRender(flags);
  ASSERT_OK(job);
  EXPECT_EQ(job->request.lights_size(), 1);
}

TEST(ViewFileTest, FaultsAreNamedByTheirKey) {
  const auto code = absl::StatusCode::kInvalidArgument;
  EXPECT_THAT(Read("nonsense"), StatusIs(code, HasSubstr("not JSON")));
  EXPECT_THAT(Read("[]"), StatusIs(code, HasSubstr("not a JSON object")));
  EXPECT_THAT(Read(R"({"camera": {"eye": [1, 2]}})"), StatusIs(code, HasSubstr("camera.eye: needs three numbers")));
  EXPECT_THAT(Read(R"({"camera": 5})"), StatusIs(code, HasSubstr("camera.eye")));
  EXPECT_THAT(Read(R"({"lights": [)" + kRightHanded + ", {}]}"), StatusIs(code, HasSubstr("lights[1].u")));
  EXPECT_THAT(Read(R"({"lights": 3})"), StatusIs(code, HasSubstr("lights[0].u")));
  EXPECT_THAT(Read(R"({"ground": {"y": 0}})"), StatusIs(code, HasSubstr("ground.add: needs true or false")));
  EXPECT_THAT(
      Read(R"({"light": )" + Light("[1, 0, 0]", "[0, 0, 1]", "[1, 0, 0]", R"(, "width": 2, "height": 3)") + "}"),
      StatusIs(code, HasSubstr("light.normal")));
}

TEST(ViewFileTest, EveryViewOfTheTestDataGivesALightThatShinesAlongItsNormal) {
  const char* data = std::getenv("HALFSHADE_TEST_DATA");
  if (data == nullptr) GTEST_SKIP() << "HALFSHADE_TEST_DATA is not set";
  int views = 0;
  for (const auto& entry : std::filesystem::directory_iterator(std::filesystem::path(data) / "views")) {
    if (entry.path().extension() != ".json") continue;
    v1::RenderRequest request;
    ASSERT_OK(ApplyViewFile(entry.path().string(), &request)) << entry.path();
    EXPECT_EQ(request.lights_size(), 1);
    EXPECT_TRUE(std::filesystem::exists(request.scene())) << request.scene();
    ++views;
  }
  EXPECT_GE(views, 25);
}

}  // namespace
}  // namespace halfshade
