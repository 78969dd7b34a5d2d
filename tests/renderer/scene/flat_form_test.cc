#include "renderer/scene/flat_form.h"

#include <gtest/gtest.h>
#define XXH_INLINE_ALL
#include <xxhash.h>

#include <cstring>
#include <functional>
#include <limits>

#include "renderer/scene/animate.h"
#include "renderer/scene/check_flat_scene.h"
#include "renderer/scene/deform.h"
#include "renderer/scene/pose.h"
#include "tests/renderer/scene/every_array_scene.h"
#include "tests/support/status_matchers.h"

namespace halfshade {
namespace {

using testing::HasSubstr;

constexpr size_t kVersionAt = 8, kPayloadAt = 12, kChecksumBytes = 8;
constexpr size_t kLayoutBytes = 2452;  // of MakeEveryArrayScene

// As a forger would: the checksum fits again.
void Seal(std::string* bytes) {
  const size_t size = bytes->size() - kChecksumBytes;
  const XXH64_hash_t checksum = XXH3_64bits(bytes->data(), size);
  std::memcpy(bytes->data() + size, &checksum, sizeof(checksum));
}

TEST(FlatFormTest, TheSceneThatIsReadIsTheOneThatWasWritten) {
  const FlatScene scene = MakeEveryArrayScene();
  ASSERT_OK(CheckFlatScene(scene));
  const std::string bytes = FlatSceneBytes(scene);
  const auto read = ReadFlatScene(bytes);
  ASSERT_OK(read);
  // Every field is in the bytes: scenes that differ in any have other ones (below).
  EXPECT_EQ(FlatSceneBytes(*read), bytes);
  EXPECT_EQ(read->SizeBytes(), scene.SizeBytes());
  EXPECT_EQ(read->positions, scene.positions);
  EXPECT_EQ(read->nodes[1].skin, 0);
  EXPECT_EQ(read->materials[0].base_color_texture.texcoord, 1);
  EXPECT_TRUE(read->materials[0].is_double_sided);
  EXPECT_EQ(read->images[0].bytes, "bytes");
  EXPECT_EQ(read->scenes[0].roots, scene.scenes[0].roots);
  EXPECT_EQ(read->degenerate_triangles_dropped, 7u);
  EXPECT_EQ(read->warnings, scene.warnings);
}

TEST(FlatFormTest, AnEmptySceneHasAFormToo) {
  FlatScene scene;
  scene.materials.resize(1);
  scene.scenes.resize(1);
  EXPECT_OK(ReadFlatScene(FlatSceneBytes(scene)));
}

TEST(FlatFormTest, ASinkThatRefusesEndsTheWriting) {
  FlatScene scene = MakeEveryArrayScene();
  scene.images[0].bytes.assign(1 << 20, 'x');
  int calls = 0;
  EXPECT_FALSE(WriteFlatScene(scene, [&calls](const void*, size_t) { return ++calls < 2; }));
  EXPECT_EQ(calls, 2);
}

TEST(FlatFormTest, CutAtAnyByteItIsRefused) {
  const std::string bytes = FlatSceneBytes(MakeEveryArrayScene());
  for (size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_EQ(ReadFlatScene(bytes.substr(0, size)).status().code(), absl::StatusCode::kDataLoss) << size;
    std::string forged = bytes.substr(0, size);
    if (size < kPayloadAt + kChecksumBytes) continue;
    Seal(&forged);
    EXPECT_EQ(ReadFlatScene(forged).status().code(), absl::StatusCode::kDataLoss) << size;
  }
  std::string longer = bytes + "x";
  Seal(&longer);
  EXPECT_THAT(ReadFlatScene(longer), StatusIs(absl::StatusCode::kDataLoss, HasSubstr("counts do not fit")));
}

TEST(FlatFormTest, WithAnyBitFlippedItIsRefused) {
  std::string bytes = FlatSceneBytes(MakeEveryArrayScene());
  for (size_t i = 0; i < 8 * bytes.size(); ++i) {
    bytes[i / 8] = char(bytes[i / 8] ^ (1 << i % 8));
    EXPECT_EQ(ReadFlatScene(bytes).status().code(), absl::StatusCode::kDataLoss) << i;
    bytes[i / 8] = char(bytes[i / 8] ^ (1 << i % 8));
  }
}

TEST(FlatFormTest, AnotherVersionIsNamed) {
  std::string bytes = FlatSceneBytes(MakeEveryArrayScene());
  bytes[kVersionAt] = char(kFlatFormVersion + 1);
  Seal(&bytes);
  EXPECT_THAT(ReadFlatScene(bytes),
              StatusIs(absl::StatusCode::kDataLoss, HasSubstr("version " + std::to_string(kFlatFormVersion + 1))));
}

TEST(FlatFormTest, ThisLayoutIsOfThisVersion) {
  const std::string bytes = FlatSceneBytes(MakeEveryArrayScene());
  EXPECT_EQ(kFlatFormVersion, 1u);
  EXPECT_EQ(bytes.size(), kLayoutBytes) << "the form has changed: raise kFlatFormVersion, then this";
}

// Whatever a forger makes of any byte: refused, or a scene that can be posed, animated and bent.
TEST(FlatFormTest, AForgedByteIsRefusedOrHarmless) {
  const std::string bytes = FlatSceneBytes(MakeEveryArrayScene());
  int refused = 0, harmless = 0;
  for (size_t i = kPayloadAt; i < bytes.size() - kChecksumBytes; ++i) {
    for (const int value : {0, 1, 2, 127, 128, 255}) {
      std::string forged = bytes;
      forged[i] = char(value);
      Seal(&forged);
      auto scene = ReadFlatScene(forged);
      if (!scene.ok()) {
        EXPECT_EQ(scene.status().code(), absl::StatusCode::kDataLoss);
        ++refused;
        continue;
      }
      ++harmless;
      for (uint32_t s = 0; s < scene->scenes.size(); ++s) EXPECT_OK(BuildPose(*scene, s)) << i;
      for (uint32_t a = 0; a < scene->animations.size(); ++a) {
        const Motion motion = Animate(*scene, {a, .5});
        FlatScene copy = *scene;
        (void)Deform(motion.overrides, motion.morph_weights, &copy).ok();  // it may reach too far
      }
    }
  }
  EXPECT_GT(refused, 1000);
  EXPECT_GT(harmless, 1000);
}

struct Forgery {
  const char* place;
  std::function<void(FlatScene&)> forge;
};

TEST(CheckFlatSceneTest, NamesWhatIsNotValid) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  const Forgery forgeries[] = {
      {"positions", [](FlatScene& s) { s.positions[0].x = kNan; }},
      {"places", [](FlatScene& s) { s.places[1].scale.z = std::numeric_limits<float>::infinity(); }},
      {"differ in length", [](FlatScene& s) { s.normals.pop_back(); }},
      {"differ in length", [](FlatScene& s) { s.texcoords1.pop_back(); }},
      {"joint_from_mesh", [](FlatScene& s) { s.joint_from_mesh.pop_back(); }},
      {"materials[0]", [](FlatScene& s) { s.materials[0].emissive_texture.texture = 1; }},
      {"materials[0]", [](FlatScene& s) { s.materials[0].emissive_texture.texture = -2; }},
      {"materials[0]", [](FlatScene& s) { s.materials[0].base_color_texture.texcoord = 2; }},
      {"materials[0]", [](FlatScene& s) { s.materials[0].alpha_mode = AlphaMode(3); }},
      {"materials[0]", [](FlatScene& s) { s.materials[0].base_color.a = kNan; }},
      {"textures[0]", [](FlatScene& s) { s.textures[0].image = 1; }},
      {"textures[0]", [](FlatScene& s) { s.textures[0].wrap_t = Wrap(3); }},
      {"images[0]", [](FlatScene& s) { s.images[0].width = 0; }},
      {"cameras[0]", [](FlatScene& s) { s.cameras[0].fovy_rad = kNan; }},
      {"skins[0]", [](FlatScene& s) { s.skins[0].joint_count = 2; }},
      {"skins[0]", [](FlatScene& s) { s.skins[0].joint_count = 0; }},
      {"skin_joints[0]", [](FlatScene& s) { s.skin_joints[0] = 3; }},
      {"nodes[0]", [](FlatScene& s) { s.nodes[0].mesh_count = 3; }},
      {"nodes[0]", [](FlatScene& s) { s.nodes[0].first_mesh = ~0u; }},
      {"nodes[0]", [](FlatScene& s) { s.nodes[0].camera = 1; }},
      {"nodes[1]", [](FlatScene& s) { s.nodes[1].skin = 1; }},
      {"nodes[0]", [](FlatScene& s) { s.nodes[0].place_count = 3; }},
      {"nodes[1]", [](FlatScene& s) { s.nodes[1].place_count = 1; }},
      {"nodes[1]", [](FlatScene& s) { s.nodes[1].first_weight = 1; }},
      {"nodes[2]", [](FlatScene& s) { s.nodes[2].parent = 3; }},
      {"nodes[", [](FlatScene& s) { s.nodes[0].parent = 2; }},  // a ring
      {"nodes[2]", [](FlatScene& s) { s.nodes[2].parent = 2; }},
      {"nodes[0]", [](FlatScene& s) { s.nodes[0].local[3][0] = 2e18; }},
      {"scenes[0]", [](FlatScene& s) { s.scenes[0].roots = {3}; }},
      {"scenes[0]", [](FlatScene& s) { s.scenes[0].roots = {2}; }},  // another one's child
      {"scenes[0]",
       [](FlatScene& s) {
         s.scenes[0].roots = {0, 0};
       }},
      {"default_scene[1]", [](FlatScene& s) { s.default_scene = 1; }},
      {"default_scene[0]", [](FlatScene& s) { s.scenes.clear(); }},
      {"deformed[0]", [](FlatScene& s) { s.deformed[0].node = 3; }},
      {"deformed[0]", [](FlatScene& s) { s.deformed[0].mesh = 0; }},
      {"deformed[0]", [](FlatScene& s) { s.deformed[0].first_bind = 1; }},
      {"deformed[0]", [](FlatScene& s) { s.deformed[0].first_bind_index = 1; }},
      {"deformed[0]", [](FlatScene& s) { s.deformed[0].influence_count = 2; }},
      {"deformed[0]", [](FlatScene& s) { s.deformed[0].first_delta = 1; }},
      {"deformed[0]", [](FlatScene& s) { s.deformed[0].target_count = 2; }},
      {"deformed[0]", [](FlatScene& s) { s.nodes[1].skin = -1; }},
      {"deformed[0]", [](FlatScene& s) { s.bind_indices[2] = 3; }},
      {"deformed[0]", [](FlatScene& s) { s.influences[0].joint = 1; }},
      {"deformed[1]", [](FlatScene& s) { s.deformed.push_back(s.deformed[0]); }},
      {"meshes[0]", [](FlatScene& s) { s.indices[0] = 3; }},
      {"meshes[0]", [](FlatScene& s) { s.meshes[0].index_count = 2; }},
      {"meshes[0]", [](FlatScene& s) { s.meshes[0].material = 1; }},
      {"meshes[0]", [](FlatScene& s) { s.meshes[0].cluster_count = 2; }},
      {"meshes[0]", [](FlatScene& s) { s.clusters[0].triangle_count = 2; }},
      {"meshes[0]", [](FlatScene& s) { s.meshes[0].bounds = {}; }},
      {"meshes[0]", [](FlatScene& s) { s.meshes[0].origin.y = kNan; }},
      {"meshes[1]", [](FlatScene& s) { s.meshes[1].first_index = 0; }},  // another one's
      {"meshes[1]", [](FlatScene& s) { s.meshes[1].first_vertex = 0; }},
      {"meshes[1]", [](FlatScene& s) { s.meshes[1].first_vertex = 4; }},
      {"rests[0]", [](FlatScene& s) { s.rests[0].scale.x = kNan; }},
      {"rests[1]", [](FlatScene& s) { s.rests[1].node = 1; }},
      {"animations[0]", [](FlatScene& s) { s.animations[0].channel_count = 3; }},
      {"channels[0]", [](FlatScene& s) { s.channels[0].node = 0; }},  // has no rest
      {"channels[0]", [](FlatScene& s) { s.channels[0].width = 3; }},
      {"channels[0]", [](FlatScene& s) { s.channels[0].key_count = 0; }},
      {"channels[0]", [](FlatScene& s) { s.channels[0].key_count = 3; }},
      {"channels[0]",
       [](FlatScene& s) {
         s.animation_times = {1, 0};
       }},
      {"channels[1]", [](FlatScene& s) { s.channels[1].first_value = 9; }},
  };
  int row = 0;
  for (const Forgery& forgery : forgeries) {
    FlatScene scene = MakeEveryArrayScene();
    forgery.forge(scene);
    EXPECT_THAT(CheckFlatScene(scene), StatusIs(absl::StatusCode::kDataLoss, HasSubstr(forgery.place))) << row;
    EXPECT_EQ(ReadFlatScene(FlatSceneBytes(scene)).status().code(), absl::StatusCode::kDataLoss) << row;
    ++row;
  }
}

}  // namespace
}  // namespace halfshade
