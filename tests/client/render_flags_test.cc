#include "client/render_flags.h"

#include <gtest/gtest.h>

#include <cmath>

#include "client/exit_code.h"
#include "tests/client/temporary_folder.h"
#include "tests/support/status_matchers.h"

namespace halfshade {
namespace {

using absl::StatusCode;
using testing::HasSubstr;

RenderFlags Flags() {
  RenderFlags flags;
  flags.scene = "scene.glb";
  return flags;
}

void ExpectUsageError(const RenderFlags& flags, const std::string& message) {
  const auto job = PrepareRender(flags);
  ASSERT_FALSE(job.ok()) << message;
  EXPECT_EQ(ExitCodeOf(job.status()), kExitUsage) << job.status();
  EXPECT_THAT(std::string(job.status().message()), HasSubstr(message));
}

TEST(RenderFlagsTest, NothingGivenLeavesEverythingToTheServer) {
  const auto job = PrepareRender(Flags());
  ASSERT_OK(job);
  v1::RenderRequest expected;
  expected.set_scene("scene.glb");
  EXPECT_EQ(job->request.DebugString(), expected.DebugString());
  EXPECT_TRUE(job->files.empty());
}

TEST(RenderFlagsTest, CameraTakesItsWordsAndPassesNanOn) {
  RenderFlags flags = Flags();
  flags.camera = "eye=1,-2.5,3e1  target=0,nan,0 up=0,1,0 fovy=45";
  const auto job = PrepareRender(flags);
  ASSERT_OK(job);
  const v1::LookAt& look_at = job->request.camera().look_at();
  EXPECT_EQ(look_at.eye().x(), 1);
  EXPECT_EQ(look_at.eye().y(), -2.5);
  EXPECT_EQ(look_at.eye().z(), 30);
  EXPECT_TRUE(std::isnan(look_at.target().y()));
  EXPECT_EQ(look_at.up().y(), 1);
  EXPECT_EQ(look_at.fovy_deg(), 45);
}

TEST(RenderFlagsTest, CameraRefusesWhatHasNotItsForm) {
  RenderFlags flags = Flags();
  for (const auto& [text, message] : {std::pair("eye=1,2", "3 numbers"), std::pair("eye=1,2,x", "'x' is not a number"),
                                      std::pair("eye=1,2,3 eye=1,2,3", "given twice"),
                                      std::pair("nose=1,2,3", "no key 'nose'"), std::pair("fovy", "needs a value"),
                                      std::pair("fovy=45deg", "'45deg'"), std::pair("eye=1,2,3,4", "3 numbers")}) {
    flags.camera = text;
    ExpectUsageError(flags, message);
  }
}

TEST(RenderFlagsTest, EveryLightIsAddedWithItsFields) {
  RenderFlags flags = Flags();
  flags.lights = {"center=0,3,0 edge_u=1,0,0 edge_v=0,0,1 direction=0,-1,0 radiance=10,9,8",
                  "center=1,1,1 edge_u=0,0,0 edge_v=0,0,0 direction=0,-1,0 intensity=1,2,3 two_sided"};
  const auto job = PrepareRender(flags);
  ASSERT_OK(job);
  ASSERT_EQ(job->request.lights_size(), 2);
  EXPECT_EQ(job->request.lights(0).radiance().g(), 9);
  EXPECT_EQ(job->request.lights(0).direction().y(), -1);
  EXPECT_FALSE(job->request.lights(0).has_intensity());
  EXPECT_FALSE(job->request.lights(0).two_sided());
  EXPECT_TRUE(job->request.lights(1).has_edge_u());
  EXPECT_EQ(job->request.lights(1).intensity().b(), 3);
  EXPECT_TRUE(job->request.lights(1).two_sided());
}

TEST(RenderFlagsTest, GroundTakesHeightSizeAndCatcher) {
  RenderFlags flags = Flags();
  flags.ground = "height=-0.5 size=10 catcher";
  const auto job = PrepareRender(flags);
  ASSERT_OK(job);
  EXPECT_EQ(job->request.ground().height_m(), -0.5);
  EXPECT_EQ(job->request.ground().size_m(), 10);
  EXPECT_TRUE(job->request.ground().shadow_catcher());
}

TEST(RenderFlagsTest, SizeIsTwoPositiveNumbersAndTheServerJudgesHowLarge) {
  RenderFlags flags = Flags();
  flags.size = "100000x100000";
  const auto job = PrepareRender(flags);
  ASSERT_OK(job);
  EXPECT_EQ(job->request.width(), 100000u);
  EXPECT_EQ(job->request.height(), 100000u);
  for (const char* size : {"0x0", "640x0", "0x480", "-640x480", "640x-480", "640", "640x", "x480", "640X480",
                           "640x480x", " 640x480", "6.4e2x480", "99999999999x1", "nanxnan"}) {
    flags.size = size;
    ExpectUsageError(flags, "--size");
  }
}

TEST(RenderFlagsTest, EveryMethodOfTheWireCanBeNamed) {
  RenderFlags flags = Flags();
  for (const char* method : {"ssm", "pdsm", "sssm", "shaft", "pcss", "hard", "multi_map", "ray", "auto", "MULTI_MAP"}) {
    flags.method = method;
    const auto job = PrepareRender(flags);
    ASSERT_OK(job);
    EXPECT_NE(job->request.method().method_case(), v1::Method::METHOD_NOT_SET) << method;
  }
  flags.method = "magic";
  ExpectUsageError(flags, "no method 'magic'; there are ssm");
}

TEST(RenderFlagsTest, SetReachesEveryTypeOfOption) {
  RenderFlags flags = Flags();
  flags.method = "pdsm";
  flags.options = {"k=32", "eps=0.25", "soft_events=true", "filter=wide2", "layout=VOLUME", "surface_only=false"};
  const auto job = PrepareRender(flags);
  ASSERT_OK(job);
  const v1::PdsmOptions& pdsm = job->request.method().pdsm();
  EXPECT_EQ(pdsm.k(), 32u);
  EXPECT_EQ(pdsm.eps(), 0.25f);
  EXPECT_TRUE(pdsm.soft_events());
  EXPECT_TRUE(pdsm.has_surface_only());
  EXPECT_FALSE(pdsm.surface_only());
  EXPECT_EQ(pdsm.filter(), v1::PDSM_FILTER_WIDE2);
  EXPECT_EQ(pdsm.layout(), v1::PDSM_LAYOUT_VOLUME);
  EXPECT_FALSE(pdsm.has_map_size());
}

TEST(RenderFlagsTest, SetRefusesForeignKeysAndWrongValues) {
  RenderFlags flags = Flags();
  flags.method = "multi_map";
  for (const auto& [text, message] :
       {std::pair("rows=4", "no option 'rows'; it has k, map_size"), std::pair("k=many", "'many'"),
        std::pair("k=-1", "'-1'"), std::pair("k=1.5", "'1.5'"), std::pair("k", "KEY=VALUE"), std::pair("k=", "''"),
        std::pair("=3", "no option ''")}) {
    flags.options = {text};
    ExpectUsageError(flags, message);
  }
  flags.method = "pdsm";
  for (const char* text : {"soft_events=1", "soft_events=True", "filter=PDSM_FILTER_NEAREST", "filter=unspecified",
                           "filter=0", "eps=1e99"}) {
    flags.options = {text};
    ExpectUsageError(flags, "--set");
  }
  flags.method = "";
  flags.options = {"k=4"};
  ExpectUsageError(flags, "needs --method");
}

TEST(RenderFlagsTest, OutputsAreToldByKindAndExtension) {
  RenderFlags flags = Flags();
  flags.outputs = {"a.png",     "VISIBILITY=b.f32", "depth=c.exr", "FRAME=d.EXR",
                   "./e=f.jpg", "normal=g.tif",     "albedo=h.f16"};
  const auto job = PrepareRender(flags);
  ASSERT_OK(job);
  EXPECT_EQ(job->files, (std::vector<std::string>{"a.png", "b.f32", "c.exr", "d.EXR", "./e=f.jpg", "g.tif", "h.f16"}));
  const auto& outputs = job->request.outputs();
  EXPECT_EQ(outputs[0].kind(), v1::OUTPUT_KIND_FRAME);
  EXPECT_EQ(outputs[0].encoding(), v1::ENCODING_PNG);
  EXPECT_EQ(outputs[1].kind(), v1::OUTPUT_KIND_VISIBILITY);
  EXPECT_EQ(outputs[1].encoding(), v1::ENCODING_RAW_F32);
  EXPECT_EQ(outputs[2].encoding(), v1::ENCODING_EXR_FLOAT);
  EXPECT_EQ(outputs[3].encoding(), v1::ENCODING_EXR_HALF);
  EXPECT_EQ(outputs[4].kind(), v1::OUTPUT_KIND_FRAME);
  EXPECT_EQ(outputs[4].encoding(), v1::ENCODING_JPEG);
  EXPECT_EQ(outputs[5].encoding(), v1::ENCODING_TIFF);
  EXPECT_EQ(outputs[6].encoding(), v1::ENCODING_RAW_F16);
}

TEST(RenderFlagsTest, OutputsThatCannotBeWrittenAreUsageErrors) {
  RenderFlags flags = Flags();
  for (const auto& [text, message] :
       {std::pair("a.bmp", "extensions"), std::pair("a", "extensions"), std::pair("-", "extensions"),
        std::pair("SHADE=a.png", "'SHADE'"), std::pair("VISIBILITY=", "extensions")}) {
    flags.outputs = {text};
    ExpectUsageError(flags, message);
  }
  flags.outputs = {"a.png", "VISIBILITY=./a.png"};
  ExpectUsageError(flags, "twice");
}

TEST(RenderFlagsTest, OutputsOfOneExrBecomeItsLayers) {
  const TemporaryFolder folder;
  RenderFlags flags = Flags();
  flags.request_file = folder.Write("r.json", R"({"outputs": [{"kind": "OUTPUT_KIND_VISIBILITY", "layer": "key"},
                                                              {"kind": "OUTPUT_KIND_DEPTH", "layer": "far"}]})");
  flags.outputs = {"a.exr", "b.png", "VISIBILITY=./a.exr", "DEPTH=c.exr"};
  const auto job = PrepareRender(flags);
  ASSERT_OK(job);
  EXPECT_EQ(job->files, (std::vector<std::string>{"a.exr", "b.png", "", "c.exr"}));
  EXPECT_EQ(job->request.outputs(0).layer(), "frame");
  EXPECT_EQ(job->request.outputs(0).encoding(), v1::ENCODING_EXR_HALF);
  EXPECT_EQ(job->request.outputs(1).layer(), "");
  EXPECT_EQ(job->request.outputs(2).layer(), "key") << "the request file's name for it";
  EXPECT_EQ(job->request.outputs(2).encoding(), v1::ENCODING_EXR_FLOAT);
  EXPECT_EQ(job->request.outputs(3).layer(), "") << "a file of its own";
}

TEST(RenderFlagsTest, OnlyOneExrHasLayersAndAKindStandsInItOnce) {
  RenderFlags flags = Flags();
  flags.outputs = {"a.exr", "VISIBILITY=a.exr", "DEPTH=b.exr", "NORMAL=b.exr"};
  ExpectUsageError(flags, "several outputs; one may");
  flags.outputs = {"DEPTH=a.exr", "DEPTH=./a.exr"};
  ExpectUsageError(flags, "twice");
}

TEST(RenderFlagsTest, NumbersGoWhereTheyBelong) {
  RenderFlags flags = Flags();
  flags.max_error = 0.01;
  flags.max_latency_ms = 1500.5;
  flags.certify = "4096,256";
  flags.seed = 7;
  flags.cache = "refresh";
  flags.camera_index = 2;
  const auto job = PrepareRender(flags);
  ASSERT_OK(job);
  EXPECT_EQ(job->request.budget().max_error(), 0.01);
  EXPECT_EQ(job->request.budget().max_latency().seconds(), 1);
  EXPECT_EQ(job->request.budget().max_latency().nanos(), 500'500'000);
  EXPECT_EQ(job->request.certify().pixels(), 4096u);
  EXPECT_EQ(job->request.certify().rays(), 256u);
  EXPECT_EQ(job->request.seed(), 7u);
  EXPECT_EQ(job->request.cache(), v1::CACHE_MODE_REFRESH);
  EXPECT_EQ(job->request.camera().index(), 2u);
}

TEST(RenderFlagsTest, BadCertifyCacheAndLatencyAreUsageErrors) {
  RenderFlags flags = Flags();
  flags.certify = "4096";
  ExpectUsageError(flags, "--certify");
  flags = Flags();
  flags.cache = "never";
  ExpectUsageError(flags, "--cache");
  flags = Flags();
  flags.max_latency_ms = std::nan("");
  ExpectUsageError(flags, "--max-latency");
}

TEST(RenderFlagsTest, FlagsOverrideTheRequestFile) {
  const TemporaryFolder folder;
  RenderFlags flags;
  flags.scene = "-";
  flags.request_file = folder.Write("r.json", R"({"scene": "models/a.glb", "width": 10, "height": 20, "seed": 3,
      "method": {"multiMap": {"k": 8, "mapSize": 64}}, "lights": [{"center": {"y": 1}}, {}],
      "outputs": [{"kind": "OUTPUT_KIND_SOFT_SHADOW_MAP", "light_map_size": 99}]})");
  flags.size = "30x40";
  flags.options = {"k=16"};
  flags.lights = {"center=0,5,0"};
  flags.outputs = {"soft_shadow_map=s.f32"};
  const auto job = PrepareRender(flags);
  ASSERT_OK(job);
  EXPECT_EQ(job->request.scene(), folder / "models/a.glb");
  EXPECT_EQ(job->request.width(), 30u);
  EXPECT_EQ(job->request.height(), 40u);
  EXPECT_EQ(job->request.seed(), 3u);
  EXPECT_EQ(job->request.method().multi_map().k(), 16u);
  EXPECT_EQ(job->request.method().multi_map().map_size(), 64u);
  ASSERT_EQ(job->request.lights_size(), 1);
  EXPECT_EQ(job->request.lights(0).center().y(), 5);
  ASSERT_EQ(job->request.outputs_size(), 1);
  EXPECT_EQ(job->request.outputs(0).light_map_size(), 99u);
  EXPECT_EQ(job->request.outputs(0).encoding(), v1::ENCODING_RAW_F32);
}

TEST(RenderFlagsTest, AnotherMethodDropsTheRequestFilesOptions) {
  const TemporaryFolder folder;
  RenderFlags flags = Flags();
  flags.request_file = folder.Write("r.json", R"({"method": {"multiMap": {"k": 8}}})");
  flags.method = "hard";
  const auto job = PrepareRender(flags);
  ASSERT_OK(job);
  EXPECT_TRUE(job->request.method().has_hard());
}

TEST(RenderFlagsTest, AScenesNameInTheRequestFileStaysAName) {
  const TemporaryFolder folder;
  RenderFlags flags;
  const std::string name = "scenes/" + std::string(64, 'a');
  flags.request_file = folder.Write("r.json", R"({"scene": ")" + name + R"("})");
  auto job = PrepareRender(flags);
  ASSERT_OK(job);
  EXPECT_EQ(job->request.scene(), name);
  flags.request_file = folder.Write("r.json", R"({"scene": "/absolute/a.glb"})");
  job = PrepareRender(flags);
  ASSERT_OK(job);
  EXPECT_EQ(job->request.scene(), "/absolute/a.glb");
}

TEST(RenderFlagsTest, ARequestFileWithAnUnknownFieldIsBadInputThatNamesIt) {
  const TemporaryFolder folder;
  RenderFlags flags = Flags();
  for (const auto& [json, message] :
       {std::pair(R"({"lights": [{"glow": 3}]})", "glow"), std::pair(R"({"width": "wide"})", "width"),
        std::pair(R"({"method": {"magic": {}}})", "magic"), std::pair("{", "r.json"), std::pair("", "r.json")}) {
    flags.request_file = folder.Write("r.json", json);
    const auto job = PrepareRender(flags);
    EXPECT_THAT(job, StatusIs(StatusCode::kInvalidArgument, HasSubstr(message)));
    EXPECT_EQ(ExitCodeOf(job.status()), kExitBadInput);
  }
  flags.request_file = folder / "absent.json";
  EXPECT_EQ(ExitCodeOf(PrepareRender(flags).status()), kExitNoInput);
}

TEST(RenderFlagsTest, WithoutASceneAnywhereItIsAUsageError) {
  ExpectUsageError(RenderFlags(), "SCENE");
  RenderFlags flags;
  flags.scene = "-";
  ExpectUsageError(flags, "SCENE");
}

}  // namespace
}  // namespace halfshade
