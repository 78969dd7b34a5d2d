#include "server/scene_name.h"

#include <gtest/gtest.h>

#include "server/digest.h"

namespace halfshade {
namespace {

TEST(Sha256Test, IsTheStandardsExample) {
  EXPECT_EQ(Sha256Hex("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  Sha256 sha;
  sha.Add("a", 1);
  sha.Add("bc", 2);
  EXPECT_EQ(sha.FinishHex(), Sha256Hex("abc"));
}

TEST(SceneNameTest, IsTheDigestOfRootAndFilesSortedByUri) {
  const std::string a(64, 'a'), b(64, 'b'), c(64, 'c');
  EXPECT_EQ(SceneName(a, {{"z.bin", b}, {"Z.bin", c}}),
            "scenes/" + Sha256Hex(a + "\n" + c + " Z.bin\n" + b + " z.bin\n"));
}

TEST(SceneNameTest, ManifestsReadBack) {
  const std::string a(64, 'a'), b(64, 'b');
  const std::map<std::string, std::string> files = {{"dir/a b.bin", b}, {"x", a}};
  std::string root;
  std::map<std::string, std::string> read;
  ParseSceneManifest(SceneManifest(a, files), &root, &read);
  EXPECT_EQ(root, a);
  EXPECT_EQ(read, files);
}

TEST(IsSceneNameTest, WantsLowerCaseHex) {
  EXPECT_TRUE(IsSceneName("scenes/" + std::string(64, '0')));
  EXPECT_FALSE(IsSceneName("scenes/" + std::string(63, '0')));
  EXPECT_FALSE(IsSceneName("scenes/" + std::string(64, 'G')));
  EXPECT_FALSE(IsSceneName("scene/" + std::string(64, '0')));
}

}  // namespace
}  // namespace halfshade
