// `halfshade` from outside: exit codes and messages that need neither a server nor GL.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/client/temporary_folder.h"
#include "tests/integration_cli/process.h"

namespace halfshade {
namespace {

using testing::HasSubstr;

class CommandLineTest : public testing::Test {
 protected:
  CommandLineTest() { folder_.Write("scene.gltf", R"({"asset": {"version": "2.0"}})"); }
  Ran Run(const std::vector<std::string>& arguments) { return RunHalfshade(arguments, folder_.path()); }
  void Expect(int exit_code, const std::string& message, const std::vector<std::string>& arguments) {
    const Ran ran = Run(arguments);
    const std::string line = testing::PrintToString(arguments);
    EXPECT_EQ(ran.exit_code, exit_code) << line << ran.err;
    EXPECT_THAT(ran.err, HasSubstr(message)) << line;
    EXPECT_EQ(ran.out, "") << line;
  }
  const TemporaryFolder folder_;
};

TEST_F(CommandLineTest, WrongCommandLinesExitWith64) {
  Expect(64, "Usage", {});
  Expect(64, "nope", {"nope"});
  Expect(64, "--nope", {"info", "--nope"});
  Expect(64, "SCENE", {"render"});
  Expect(64, "-o FILE", {"render", "scene.gltf"});
  Expect(64, "extensions", {"render", "scene.gltf", "-o", "a.bmp"});
  Expect(64, "--size", {"render", "scene.gltf", "-o", "a.png", "--size", "0x0"});
  Expect(64, "--size", {"render", "scene.gltf", "-o", "a.png", "--size", "-64x64"});
  Expect(64, "rows", {"render", "scene.gltf", "-o", "a.png", "--method", "hard", "--set", "rows=8"});
  Expect(64, "vulkan", {"info", "--gl", "vulkan"});
  Expect(64, "not HOST:PORT", {"info", "--server", "somewhere"});
  Expect(64, "not available yet", {"info", "--ca", "ca.pem"});
  Expect(64, "FILE", {"upload"});
}

TEST_F(CommandLineTest, AbsentFilesExitWith66) {
  folder_.Write("empty.json", "{}");
  Expect(66, "absent.glb", {"render", "absent.glb", "-o", "a.png"});
  Expect(66, "absent.json", {"render", "scene.gltf", "--request", "absent.json", "-o", "a.png"});
  Expect(66, "absent.json", {"render", "scene.gltf", "--view", "absent.json", "-o", "a.png"});
  Expect(66, "not a regular file", {"render", "/dev/zero", "-o", "a.png"});
  Expect(66, "not a regular file", {"upload", "."});
}

TEST_F(CommandLineTest, AScenesOwnFaultsExitWith65AndTheirPointer) {
  folder_.Write("bad.gltf", R"({"buffers": [{"uri": "../../etc/passwd", "byteLength": 4}]})");
  Expect(65, "/buffers/0/uri: ../../etc/passwd: outside the scene's folder", {"render", "bad.gltf", "-o", "a.png"});
}

TEST_F(CommandLineTest, AFolderThatIsNotThereExitsWith74BeforeAnythingIsRendered) {
  Expect(74, "none/a.png", {"render", "scene.gltf", "-o", "none/a.png"});
}

TEST_F(CommandLineTest, ASampleNeedsATemplateThatMakesLines) {
  Expect(64, "TEMPLATE", {"sample"});
  Expect(66, "absent.json", {"sample", "absent.json"});
  folder_.Write("t.json", R"({"id": "t", "scene": "scene.gltf", "width": {"$uniform": [2, 1]}})");
  Expect(65, "t.json: /width/$uniform: must be [a, b]", {"sample", "t.json"});
}

TEST_F(CommandLineTest, AQueryNeedsItsPoints) {
  Expect(64, "POINTS.csv", {"query", "scene.gltf"});
  Expect(66, "absent.csv", {"query", "scene.gltf", "absent.csv"});
  folder_.Write("bad.csv", "1,2\n");
  Expect(65, "bad.csv:1: 2 values", {"query", "scene.gltf", "bad.csv"});
}

TEST_F(CommandLineTest, AServerThatIsNotThereExitsWith69) {
  Expect(69, "", {"info", "--server", "127.0.0.1:1", "--timeout", "1"});
}

TEST_F(CommandLineTest, HelpAndVersionAreDataOnStdout) {
  for (const char* flag : {"--help", "--version"}) {
    const Ran ran = Run({flag});
    EXPECT_EQ(ran.exit_code, 0);
    EXPECT_THAT(ran.out, HasSubstr("halfshade"));
    EXPECT_EQ(ran.err, "");
  }
}

TEST_F(CommandLineTest, PrintRequestNeedsNoServerAndItsOutputIsARequestFile) {
  const Ran first = Run({"--server", "127.0.0.1:1", "render", "scene.gltf", "--print-request", "--size", "64x32",
                         "--method", "multi_map", "--set", "k=8", "--camera", "eye=1,2,nan target=0,0,0"});
  ASSERT_EQ(first.exit_code, 0) << first.err;
  const nlohmann::json request = nlohmann::json::parse(first.out);
  EXPECT_EQ(request["scene"], "scene.gltf");
  EXPECT_EQ(request["width"], 64);
  EXPECT_EQ(request["method"]["multiMap"]["k"], 8);
  EXPECT_EQ(request["camera"]["lookAt"]["eye"]["z"], "NaN");
  folder_.Write("again.json", first.out);
  const Ran second = Run({"render", "-", "--request", "again.json", "--print-request"});
  EXPECT_EQ(second.out, first.out) << second.err;
}

}  // namespace
}  // namespace halfshade
