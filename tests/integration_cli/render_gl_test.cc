// `halfshade` and `halfshaded` from outside: the same pixels in-process and over a port, and a server that bad input
// neither stops nor changes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "client/glb_writer.h"
#include "tests/client/temporary_folder.h"
#include "tests/integration_cli/process.h"

namespace halfshade {
namespace {

using nlohmann::json;
using testing::HasSubstr;

// A plate one metre over a floor.
std::string PlateOverFloor() {
  auto quad = [](const std::string& name, float half, float y) {
    GlbMesh mesh;
    mesh.name = name;
    mesh.positions = {{-half, y, -half}, {-half, y, half}, {half, y, half}, {half, y, -half}};
    mesh.indices = {0, 1, 2, 0, 2, 3};
    return mesh;
  };
  return WriteGlb({quad("floor", 4, 0), quad("plate", 0.5f, 1)});
}

constexpr int kWidth = 96, kHeight = 64;
const std::vector<std::string> kPicture = {"--camera", "eye=0,4,5 target=0,0,0 up=0,1,0 fovy=50",
                                           "--light",  "center=0,4,0 edge_u=1,0,0 edge_v=0,0,1 radiance=10,10,10",
                                           "--size",   "96x64",
                                           "--method", "multi_map",
                                           "--set",    "k=16",
                                           "--set",    "map_size=256"};

std::vector<std::string> operator+(std::vector<std::string> a, const std::vector<std::string>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

class RenderCommandTest : public testing::Test {
 protected:
  RenderCommandTest() { folder_.Write("scene.glb", PlateOverFloor()); }
  Ran Run(const std::vector<std::string>& arguments) { return RunHalfshade(arguments, folder_.path()); }
  // pixelSha256 of the outputs; fails the test where the render does.
  std::vector<std::string> Digests(const std::vector<std::string>& arguments) {
    const Ran ran = Run(arguments + std::vector<std::string>{"--json"});
    EXPECT_EQ(ran.exit_code, 0) << ran.err;
    std::vector<std::string> digests;
    const json report = json::parse(ran.out, nullptr, false);
    if (!report.is_object()) return digests;
    for (const json& output : report["outputs"]) digests.push_back(output["pixelSha256"]);
    return digests;
  }
  const TemporaryFolder folder_;
};

TEST_F(RenderCommandTest, TheSamePixelsInProcessAndOverAPort) {
  const std::vector<std::string> render = std::vector<std::string>{"render", "scene.glb"} + kPicture;
  const auto here = Digests(render + std::vector<std::string>{"-o", "here.png", "-o", "VISIBILITY=here.f32"});
  ASSERT_EQ(here.size(), 2u);
  EXPECT_EQ(here[0].size(), 64u);
  EXPECT_NE(here[0], here[1]);
  ServerProcess server;
  const auto there = Digests(std::vector<std::string>{"--server", server.address()} + render +
                             std::vector<std::string>{"-o", "there.png", "-o", "VISIBILITY=there.f32"});
  EXPECT_EQ(here, there);
  EXPECT_EQ(ReadAll(folder_ / "here.png"), ReadAll(folder_ / "there.png"));
  EXPECT_EQ(ReadAll(folder_ / "here.png").substr(1, 3), "PNG");
  const std::string visibility = ReadAll(folder_ / "here.f32");
  ASSERT_EQ(visibility.size(), sizeof(float) * kWidth * kHeight);
  EXPECT_EQ(visibility, ReadAll(folder_ / "there.f32"));
  // A full occluder somewhere, light somewhere, and a penumbra between: k = 16 gives sixteenths.
  int umbra = 0, penumbra = 0, lit = 0;
  for (size_t i = 0; i < visibility.size(); i += sizeof(float)) {
    float v = -1;
    std::memcpy(&v, visibility.data() + i, sizeof(v));
    ASSERT_TRUE(v >= 0 && v <= 1) << v;
    ++(v == 0 ? umbra : v == 1 ? lit : penumbra);
  }
  EXPECT_GT(umbra, 10);
  EXPECT_GT(penumbra, 50);
  EXPECT_GT(lit, 1000);
  EXPECT_EQ(server.Stop(), 0);
}

// A floor of 8 x 8 m and, in its file, cameras 5 m above that look straight down: perspective with yfov 2 atan(.4), its
// image 4 m high on the floor, and orthographic with ymag 1.5, 3 m high. Both are wider by the picture's own aspect,
// whatever the file says of it.
TEST_F(RenderCommandTest, TheScenesCamerasSeeWhatTheirPropertiesSay) {
  folder_.Write("floor.bin", std::string("\0\0\x80\xc0\0\0\0\0\0\0\x80\xc0"  // -4 0 -4
                                         "\0\0\x80\xc0\0\0\0\0\0\0\x80\x40"  // -4 0 4
                                         "\0\0\x80\x40\0\0\0\0\0\0\x80\x40"  // 4 0 4
                                         "\0\0\x80\x40\0\0\0\0\0\0\x80\xc0"  // 4 0 -4
                                         "\0\0\1\0\2\0\0\0\2\0\3\0",
                                         60));
  const json scene = {
      {"asset", {{"version", "2.0"}}},
      {"buffers", {{{"uri", "floor.bin"}, {"byteLength", 60}}}},
      {"bufferViews", {{{"buffer", 0}, {"byteLength", 48}}, {{"buffer", 0}, {"byteOffset", 48}, {"byteLength", 12}}}},
      {"accessors",
       {{{"bufferView", 0},
         {"componentType", 5126},
         {"count", 4},
         {"type", "VEC3"},
         {"min", {-4, 0, -4}},
         {"max", {4, 0, 4}}},
        {{"bufferView", 1}, {"componentType", 5123}, {"count", 6}, {"type", "SCALAR"}}}},
      {"meshes", {{{"primitives", {{{"attributes", {{"POSITION", 0}}}, {"indices", 1}}}}}}},
      {"cameras",
       {{{"type", "perspective"}, {"perspective", {{"yfov", 2 * std::atan(0.4)}, {"aspectRatio", 7}, {"znear", 0.1}}}},
        {{"type", "orthographic"}, {"orthographic", {{"xmag", 9}, {"ymag", 1.5}, {"znear", 0}, {"zfar", 5.5}}}},
        {{"type", "orthographic"}, {"orthographic", {{"xmag", 9}, {"ymag", 1.5}, {"znear", 0}, {"zfar", 4.5}}}}}},
      // A quarter turn about x: -z looks down.
      {"nodes",
       {{{"mesh", 0}},
        {{"camera", 0}, {"translation", {1, 5, 0}}, {"rotation", {-std::sqrt(0.5), 0, 0, std::sqrt(0.5)}}},
        {{"camera", 1}, {"translation", {1, 5, 0}}, {"rotation", {-std::sqrt(0.5), 0, 0, std::sqrt(0.5)}}},
        {{"camera", 2}, {"translation", {1, 5, 0}}, {"rotation", {-std::sqrt(0.5), 0, 0, std::sqrt(0.5)}}}}},
      {"scenes", {{{"nodes", {0, 1, 2, 3}}}}}};
  folder_.Write("cameras.gltf", scene.dump());
  constexpr int kColumns = 80, kRows = 40;
  const auto floats = [&](const std::string& file) {
    const std::string bytes = ReadAll(folder_ / file);
    std::vector<float> values(bytes.size() / sizeof(float));
    std::memcpy(values.data(), bytes.data(), values.size() * sizeof(float));
    return values;
  };
  const auto render = [&](int camera) {
    return Run({"render", "cameras.gltf", "--camera-index", std::to_string(camera), "--size", "80x40", "-o",
                "depth=d.f32", "-o", "position=p.f32", "-o", "object_id=i.f32"});
  };
  const double image_heights_m[] = {4, 3};
  for (int camera = 0; camera < 2; ++camera) {
    const Ran ran = render(camera);
    ASSERT_EQ(ran.exit_code, 0) << ran.err;
    const std::vector<float> depth = floats("d.f32"), position = floats("p.f32"), id = floats("i.f32");
    ASSERT_EQ(depth.size(), size_t(kColumns * kRows));
    ASSERT_EQ(position.size(), 3 * depth.size());
    ASSERT_EQ(id.size(), depth.size());
    const double pixel_m = image_heights_m[camera] / kRows;
    for (int y = 0; y < kRows; ++y) {
      for (int x = 0; x < kColumns; ++x) {
        const size_t i = size_t(y * kColumns + x);
        const double world_x = 1 + (x + 0.5 - kColumns / 2.0) * pixel_m, world_z = (y + 0.5 - kRows / 2.0) * pixel_m;
        const bool is_floor = world_x < 4;
        EXPECT_NEAR(depth[i], is_floor ? 5 : 0, 3e-6) << x << "," << y;
        EXPECT_EQ(id[i], is_floor ? 1 : 0);
        EXPECT_NEAR(position[3 * i], is_floor ? world_x : 0, 3e-6);
        EXPECT_NEAR(position[3 * i + 1], 0, 3e-6);
        EXPECT_NEAR(position[3 * i + 2], is_floor ? world_z : 0, 3e-6);
      }
    }
  }
  ASSERT_EQ(render(2).exit_code, 0);
  for (const float depth : floats("d.f32")) EXPECT_EQ(depth, 0) << "zfar is before the floor";
  const Ran none = render(3);
  EXPECT_EQ(none.exit_code, 65);
  EXPECT_THAT(none.err, HasSubstr("camera.index: 3; the scene has 3"));
}

// A point straight under the plate's middle has all of the light hidden, one far beside it none.
TEST_F(RenderCommandTest, ACatcherIsTransparentButForTheShadow) {
  folder_.Write("plate.glb", PlateOverFloor());
  folder_.Write("request.json", R"({"samples": 4, "shading": {"ambient": {}, "toneMap": "TONE_MAP_NEUTRAL"}})");
  const Ran ran = Run({"render", "plate.glb", "--request", "request.json", "--camera",
                       "eye=0,0.5,0 target=0,0,0 up=0,0,-1 ortho_height=2", "--light",
                       "center=0,4,0 edge_u=0.2,0,0 edge_v=0,0,0.2 direction=0,-1,0 radiance=10,10,10", "--ground",
                       "height=0.1 size=20 catcher", "--size", "20x20", "-o", "frame.f32"});
  ASSERT_EQ(ran.exit_code, 0) << ran.err;
  const std::string bytes = ReadAll(folder_ / "frame.f32");
  ASSERT_EQ(bytes.size(), sizeof(float) * 4 * 20 * 20);
  float middle[4], corner[4];
  std::memcpy(middle, bytes.data() + sizeof(middle) * (20 * 10 + 10), sizeof(middle));
  std::memcpy(corner, bytes.data(), sizeof(corner));
  EXPECT_EQ(middle[3], 1);
  EXPECT_EQ(middle[0], 0);
  for (const float channel : corner) EXPECT_EQ(channel, 0);
}

TEST_F(RenderCommandTest, OneExrHasFrameAndVisibilityAsLayersEqualToFilesOfTheirOwn) {
  const std::vector<std::string> render = std::vector<std::string>{"render", "scene.glb"} + kPicture;
  const auto layers = Digests(render + std::vector<std::string>{"-o", "all.exr", "-o", "VISIBILITY=all.exr"});
  const auto files = Digests(render + std::vector<std::string>{"-o", "frame.exr", "-o", "VISIBILITY=visibility.exr"});
  ASSERT_EQ(layers.size(), 2u);
  EXPECT_EQ(layers, files);
  const std::string bytes = ReadAll(folder_ / "all.exr");
  for (const char* channel : {"frame.R", "frame.A", "visibility.0"}) EXPECT_THAT(bytes, HasSubstr(channel));
}

TEST_F(RenderCommandTest, ACertificateMeasuresTheErrorAndChangesNoPixel) {
  const std::vector<std::string> render = {"render", "scene.glb", "-o", "VISIBILITY=v.f32"};
  const Ran ran = Run(render + kPicture + std::vector<std::string>{"--certify", "1024,256", "--json"});
  ASSERT_EQ(ran.exit_code, 0) << ran.err;
  const json report = json::parse(ran.out);
  ASSERT_TRUE(report["error"].contains("measured")) << ran.out;
  const double measured = report["error"]["measured"];
  EXPECT_GT(measured, 0.002);  // sixteen maps of 256 texels
  EXPECT_LT(measured, 0.05);
  EXPECT_GT(report["error"]["ci95"], 0);
  EXPECT_LT(report["error"]["ci95"], measured);
  EXPECT_LT(report["error"]["noise"], measured / 2);
  EXPECT_THAT(ran.err, HasSubstr(", error 0.0"));
  EXPECT_EQ(Digests(render + kPicture), std::vector<std::string>{report["outputs"][0]["pixelSha256"]});

  const Ran plain = Run(render + kPicture + std::vector<std::string>{"--json"});
  EXPECT_FALSE(json::parse(plain.out)["error"].contains("measured"));
  EXPECT_EQ(Run(render + kPicture + std::vector<std::string>{"--certify", "63,256"}).exit_code, 65);
}

TEST_F(RenderCommandTest, APlanNamesMethodOptionsAndWhatIsLeftOut) {
  const std::vector<std::string> plan = {"plan",  "scene.glb", "--method", "multi_map",
                                         "--set", "k=7",       "-o",       "VISIBILITY=v.f32"};
  const Ran text = Run(plan);
  EXPECT_EQ(text.exit_code, 0) << text.err;
  EXPECT_THAT(text.out, HasSubstr("method   multi_map\noptions  k: 7"));
  EXPECT_THAT(text.out, HasSubstr("skipped  shade: no FRAME is asked\n"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "v.f32"));
  const json report = json::parse(Run(plan + std::vector<std::string>{"--json"}).out);
  EXPECT_EQ(report["method"], "multi_map");
  EXPECT_EQ(report["options"]["multiMap"]["k"], 7);
}

TEST_F(RenderCommandTest, MoreThanFourMebibytesComeThrough) {
  const Ran ran = Run({"render", "scene.glb", "-o", "out.f32", "--size", "640x480", "--method", "hard"});
  EXPECT_EQ(ran.exit_code, 0) << ran.err;
  EXPECT_EQ(ReadAll(folder_ / "out.f32").size(), 640u * 480 * 16);
}

TEST_F(RenderCommandTest, ASceneAloneShowsAPicture) {
  const Ran ran = Run({"render", "scene.glb", "-o", "out.png", "--size", "64x64"});
  EXPECT_EQ(ran.exit_code, 0) << ran.err;
  EXPECT_EQ(ran.out, "");
  EXPECT_GT(ReadAll(folder_ / "out.png").size(), 100u);
}

TEST_F(RenderCommandTest, GlobalOptionsStandBeforeOrAfterTheCommand) {
  ServerProcess server;
  const Ran before = Run({"--server", server.address(), "--json", "info"});
  const Ran after = Run({"info", "--json", "--server", server.address()});
  EXPECT_EQ(before.exit_code, 0) << before.err;
  EXPECT_EQ(before.out, after.out);
  EXPECT_FALSE(json::parse(before.out)["contexts"].empty());
}

TEST_F(RenderCommandTest, ScenesAreUploadedListedAndRenderedByName) {
  ServerProcess server;
  const std::vector<std::string> at = {"--server", server.address()};
  const Ran upload = Run(at + std::vector<std::string>{"upload", "scene.glb"});
  ASSERT_EQ(upload.exit_code, 0) << upload.err;
  const std::string name = upload.out.substr(0, upload.out.size() - 1);
  EXPECT_EQ(name.size(), 71u);
  EXPECT_THAT(Run(at + std::vector<std::string>{"scenes"}).out, HasSubstr(name + "\t4 triangles"));
  const Ran scene = Run(at + std::vector<std::string>{"scene", name, "--json"});
  EXPECT_EQ(json::parse(scene.out)["boundsMax"]["y"], 1);
  EXPECT_EQ(Run(at + std::vector<std::string>{"render", name, "-o", "a.png", "--size", "32x32"}).exit_code, 0);
  const Ran unknown = Run(at + std::vector<std::string>{"scene", "scenes/" + std::string(64, '0')});
  EXPECT_EQ(unknown.exit_code, 66) << unknown.err;
}

TEST_F(RenderCommandTest, HealthSaysServing) {
  ServerProcess server;
  const Ran ran = Run({"health", "--server", server.address()});
  EXPECT_EQ(ran.exit_code, 0) << ran.err;
  EXPECT_EQ(ran.out, "SERVING\n");
}

TEST_F(RenderCommandTest, BadInputIsNamedAndNeitherStopsNorChangesTheServer) {
  ServerProcess server;
  const std::vector<std::string> render = {"--server", server.address(), "render"};
  const std::vector<std::string> good =
      render + std::vector<std::string>{"scene.glb", "-o", "good.png", "--cache", "refresh"} + kPicture;
  const auto before = Digests(good);
  ASSERT_EQ(before.size(), 1u);

  folder_.Write("truncated.glb", PlateOverFloor().substr(0, 200));
  folder_.Write("outside.gltf",
                R"({"asset": {"version": "2.0"}, "buffers": [{"uri": "../../etc/passwd", "byteLength": 4}]})");
  folder_.Write("unknown.json", R"({"lights": [{"glow": 1}]})");
  const std::string point = "center=0,4,0 edge_u=0,0,0 edge_v=0,0,0 intensity=9,9,9";
  struct Case {
    std::vector<std::string> arguments;
    int exit_code;
    std::string message;
  };
  const Case cases[] = {
      {{"scene.glb", "--camera", "eye=nan,1,1 target=0,0,0"}, 65, "camera.look_at.eye"},
      {{"scene.glb", "--light", point}, 65, "lights[0].direction"},
      {{"scene.glb", "--light", point + " direction=0,-1,0", "--size", "32x32"}, 0, ""},
      {{"scene.glb", "--size", "0x0"}, 64, "--size"},
      {{"scene.glb", "--size", "100000x100000"}, 65, "width"},
      {{"scene.glb", "--method", "multi_map", "--set", "rows=3"}, 64, "rows"},
      {{"scene.glb", "--method", "multi_map", "--set", "k=0"}, 65, "multi_map.k"},
      {{"scene.glb", "--request", "unknown.json"}, 65, "glow"},
      {{"truncated.glb"}, 65, ""},
      {{"outside.gltf"}, 65, "/buffers/0/uri"},
      {{"scenes/" + std::string(64, '0')}, 66, ""},
      {{"scene.glb", "-o", "PENUMBRA_WIDTH=d.exr", "--method", "ray"}, 69, "outputs[0].kind"},
      {{"scene.glb", "--max-error", "0.000001"}, 78, "budget.max_error: 1e-06; the least possible is"},
      {{"scene.glb", "--max-latency", "1"}, 78, "budget.max_latency: 1.0 ms; the least possible is"},
  };
  for (const Case& c : cases) {
    const Ran ran = Run(render + c.arguments + std::vector<std::string>{"-o", "bad.png"});
    EXPECT_EQ(ran.exit_code, c.exit_code) << testing::PrintToString(c.arguments) << ran.err;
    EXPECT_THAT(ran.err, HasSubstr(c.message)) << testing::PrintToString(c.arguments);
    EXPECT_TRUE(server.IsAlive());
  }
  EXPECT_EQ(Digests(good), before);
}

TEST_F(RenderCommandTest, AQueryPrintsALineAPointAndAValueALight) {
  folder_.Write("points.csv", "x,y,z\n0,0.5,0\n3,0.5,0\n0,2,0\n");
  const std::vector<std::string> query = {"query",
                                          "scene.glb",
                                          "points.csv",
                                          "--light",
                                          "center=0,4,0 edge_u=1,0,0 edge_v=0,0,1 direction=0,-1,0",
                                          "--light",
                                          "center=6,4,0 edge_u=1,0,0 edge_v=0,0,1 direction=0,-1,0",
                                          "--method",
                                          "ray",
                                          "--set",
                                          "rays=64"};
  const Ran ran = Run(query);
  EXPECT_EQ(ran.exit_code, 0) << ran.err;
  EXPECT_EQ(ran.out, "0,1\n1,1\n1,1\n");
  const Ran as_json = Run(query + std::vector<std::string>{"--json"});
  const json answer = json::parse(as_json.out, nullptr, false);
  ASSERT_TRUE(answer.is_object()) << as_json.out << as_json.err;
  EXPECT_EQ(answer["visibility"], json::parse("[[0,1],[1,1],[1,1]]"));
  EXPECT_EQ(answer["report"]["method"], "ray");
  EXPECT_EQ(answer["report"]["options"]["ray"]["rays"], 64);
}

}  // namespace
}  // namespace halfshade
