#include "client/scene_files.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "tests/client/temporary_folder.h"
#include "tests/support/status_matchers.h"

namespace halfshade {
namespace {

namespace fs = std::filesystem;
using absl::StatusCode;
using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

std::string GltfWith(const std::vector<std::string>& buffers, const std::vector<std::string>& images = {}) {
  json gltf = {{"asset", {{"version", "2.0"}}}};
  for (const std::string& uri : buffers) gltf["buffers"].push_back({{"uri", uri}, {"byteLength", 4}});
  for (const std::string& uri : images) gltf["images"].push_back({{"uri", uri}});
  return gltf.dump();
}

std::string Glb(const std::string& text) {
  auto u32 = [](size_t value) {
    std::string bytes;
    for (int i = 0; i < 4; ++i) bytes += static_cast<char>(value >> (8 * i) & 255);
    return bytes;
  };
  return "glTF" + u32(2) + u32(20 + text.size()) + u32(text.size()) + "JSON" + text;
}

std::vector<std::string> Uris(const SceneFiles& scene) {
  std::vector<std::string> uris;
  for (const SceneFile& file : scene.files) uris.push_back(file.uri);
  return uris;
}

class SceneFilesTest : public testing::Test {
 protected:
  absl::StatusOr<SceneFiles> Read(const std::string& text, const std::string& name = "scene.gltf") {
    return ReadSceneFiles(folder_.Write("room/" + name, text));
  }
  // The pointer of the first buffer, the URI as it is told, and why.
  void ExpectFault(const std::string& uri, const std::string& why) {
    EXPECT_THAT(Read(GltfWith({uri})),
                StatusIs(StatusCode::kInvalidArgument, AllOf(StartsWith("/buffers/0/uri: "), HasSubstr(why))))
        << uri;
  }
  const TemporaryFolder folder_;
};

TEST_F(SceneFilesTest, CollectsBuffersAndImagesOnceAndByTheirDecodedUri) {
  folder_.Write("room/a.bin", "aaaa");
  folder_.Write("room/sub/b c.png", "png");
  const auto scene = Read(GltfWith({"a.bin", "a.bin", "data:application/octet-stream;base64,AAAA", "DATA:,x"},
                                   {"sub/b%20c.png", "sub/b c.png"}));
  ASSERT_OK(scene);
  EXPECT_EQ(Uris(*scene), (std::vector<std::string>{"a.bin", "sub/b c.png"}));
  EXPECT_EQ(scene->files[0].bytes, "aaaa");
  EXPECT_EQ(scene->files[0].digest, "61be55a8e2f6b4e172338bddf184d6dbee29c98853e0a0485ecee7f27b9af0b4");
}

TEST_F(SceneFilesTest, ReadsTheJsonOfAGlb) {
  folder_.Write("room/a.bin", "aaaa");
  const auto scene = Read(Glb(GltfWith({"a.bin"})), "scene.glb");
  ASSERT_OK(scene);
  EXPECT_EQ(Uris(*scene), std::vector<std::string>{"a.bin"});
}

TEST_F(SceneFilesTest, APercentSignThatStartsNoEscapeStays) {
  folder_.Write("room/100%.bin", "aaaa");
  const auto scene = Read(GltfWith({"100%.bin"}));
  ASSERT_OK(scene);
  EXPECT_EQ(Uris(*scene), std::vector<std::string>{"100%.bin"});
}

TEST_F(SceneFilesTest, AColonThatIsEscapedIsAFilesName) {
  folder_.Write("room/a:b.bin", "aaaa");
  EXPECT_OK(Read(GltfWith({"a%3Ab.bin"})));
  ExpectFault("a:b.bin", "scheme");
}

TEST_F(SceneFilesTest, TheNameDependsOnContentAndUrisAlone) {
  folder_.Write("room/a.bin", "aaaa");
  const std::string gltf = GltfWith({"a.bin"});
  const auto here = Read(gltf);
  ASSERT_OK(here);
  folder_.Write("elsewhere/a.bin", "aaaa");
  const auto there = ReadSceneFiles(folder_.Write("elsewhere/other.gltf", gltf));
  ASSERT_OK(there);
  EXPECT_EQ(here->name, there->name);
  folder_.Write("elsewhere/a.bin", "aaab");
  const auto changed = ReadSceneFiles(folder_ / "elsewhere/other.gltf");
  ASSERT_OK(changed);
  EXPECT_NE(here->name, changed->name);
}

TEST_F(SceneFilesTest, NothingOutsideTheFolderIsRead) {
  folder_.Write("secret.bin", "aaaa");
  fs::create_directory(folder_ / "room");
  fs::create_symlink("../secret.bin", folder_ / "room/link.bin");
  fs::create_symlink("..", folder_ / "room/up");
  ExpectFault("../secret.bin", "../secret.bin: outside the scene's folder");
  ExpectFault("%2e%2e%2fsecret.bin", "outside the scene's folder");
  ExpectFault("../../../../../../etc/passwd", "../etc/passwd: outside the scene's folder");
  ExpectFault("../../no/such/file", "outside the scene's folder");
  ExpectFault("/etc/passwd", "outside the scene's folder");
  ExpectFault("/dev/zero", "outside the scene's folder");
  ExpectFault("link.bin", "outside the scene's folder");
  ExpectFault("up/secret.bin", "outside the scene's folder");
  ExpectFault("file:///etc/passwd", "scheme");
  ExpectFault("http://127.0.0.1:9/x.bin", "scheme");
}

TEST_F(SceneFilesTest, AFolderWhoseNameBeginsAlikeIsOutside) {
  folder_.Write("room2/a.bin", "aaaa");
  ExpectFault("../room2/a.bin", "outside the scene's folder");
}

TEST_F(SceneFilesTest, OnlyRegularFilesAreRead) {
  fs::create_directories(folder_ / "room/folder.bin");
  ASSERT_EQ(mkfifo((folder_ / "room/pipe.bin").c_str(), 0600), 0);
  fs::create_symlink("loop.bin", folder_ / "room/loop.bin");
  ExpectFault("folder.bin", "not a regular file");
  ExpectFault(".", "not a regular file");
  ExpectFault("pipe.bin", "not a regular file");
  ExpectFault("absent.bin", "no such file");
  ExpectFault("loop.bin", "symbolic link");
  ExpectFault("", "is empty");
  ExpectFault(std::string("ok.bin\0/../../etc/passwd", 24), "NUL");
  ExpectFault("ok.bin%00", "NUL");
  ExpectFault(std::string(5000, 'x'), "too long");
}

TEST_F(SceneFilesTest, ALinkInsideTheFolderIsFollowed) {
  folder_.Write("room/real.bin", "aaaa");
  fs::create_symlink("real.bin", folder_ / "room/link.bin");
  EXPECT_OK(Read(GltfWith({"link.bin"})));
}

TEST_F(SceneFilesTest, AnImagesFaultHasItsOwnPointer) {
  EXPECT_THAT(Read(GltfWith({}, {"data:,", "absent.png"})),
              StatusIs(StatusCode::kInvalidArgument, StartsWith("/images/1/uri: absent.png: no such file")));
}

TEST_F(SceneFilesTest, BrokenJsonNamesNoFilesAndIsLeftToTheServer) {
  const std::string deep = std::string(200000, '[');
  for (const std::string& text : {std::string("{"), std::string(), std::string("\xff\xfe"), deep, std::string("glTF"),
                                  Glb("{"), std::string("null"), std::string(R"({"buffers": {"uri": "a"}})"),
                                  std::string(R"({"buffers": [3, {"uri": 5}]})")}) {
    const auto scene = Read(text);
    ASSERT_OK(scene);
    EXPECT_TRUE(scene->files.empty());
  }
}

TEST_F(SceneFilesTest, AnObjReadsMaterialsFromItsOwnFolderOnly) {
  const std::string triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  folder_.Write("room/a b.mtl", "newmtl red\nKd 1 0 0\n");
  fs::create_symlink("/dev/zero", folder_ / "room/zero.mtl");
  EXPECT_OK(Read("mtllib a\\ b.mtl\n" + triangle, "a.obj"));
  EXPECT_OK(Read("mtllib absent.mtl\n" + triangle, "a.obj"));
  for (const std::string name : {"../../../../../../../etc/passwd", "../../../../../../../dev/zero", "/dev/zero",
                                 "zero.mtl", "a.mtl ../../up.mtl", "ze\\ro.mtl"}) {
    for (const std::string& text : {"mtllib " + name + "\n" + triangle, triangle + "\r \tmtllib\t" + name}) {
      EXPECT_THAT(Read(text, "a.obj"), StatusIs(StatusCode::kInvalidArgument,
                                                AllOf(StartsWith("mtllib "), HasSubstr("outside the scene's folder"))))
          << text;
    }
  }
}

TEST_F(SceneFilesTest, ASceneThatIsNotThereIsNotFound) {
  EXPECT_THAT(ReadSceneFiles(folder_ / "absent.glb"), StatusIs(StatusCode::kNotFound, HasSubstr("absent.glb")));
  EXPECT_THAT(ReadSceneFiles("/dev/zero"), StatusIs(StatusCode::kNotFound, HasSubstr("not a regular file")));
}

}  // namespace
}  // namespace halfshade
