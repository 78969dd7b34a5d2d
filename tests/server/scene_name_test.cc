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
  EXPECT_TRUE(ParseSceneManifest(SceneManifest(a, files), &root, &read));
  EXPECT_EQ(root, a);
  EXPECT_EQ(read, files);
}

TEST(SceneNameTest, WhatIsNoManifestIsRefused) {
  const std::string a(64, 'a');
  std::string root;
  std::map<std::string, std::string> files;
  EXPECT_TRUE(ParseSceneManifest(a + "\n", &root, &files));
  EXPECT_TRUE(ParseSceneManifest(a + "\n" + a + " x\n", &root, &files));
  for (const std::string& text :
       {std::string(), a, std::string(64, 'A') + "\n", a + "\n" + a + " x", a + "\n" + a + "\n", a + "\n\n",
        a + "\n" + a + "\tx\n", a + "\n" + a + " y\n" + a + " x\n", a + "\n" + std::string(64, 'g') + " x\n"}) {
    EXPECT_FALSE(ParseSceneManifest(text, &root, &files)) << text;
  }
}

TEST(IsSceneNameTest, WantsLowerCaseHex) {
  EXPECT_TRUE(IsSceneName("scenes/" + std::string(64, '0')));
  EXPECT_FALSE(IsSceneName("scenes/" + std::string(63, '0')));
  EXPECT_FALSE(IsSceneName("scenes/" + std::string(64, 'G')));
  EXPECT_FALSE(IsSceneName("scene/" + std::string(64, '0')));
}

}  // namespace
}  // namespace halfshade
