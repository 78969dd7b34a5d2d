// Scenes that nobody here made, through the client and the real service: each renders or says what it lacks; four
// encodings of one mesh give one shadow; what moves, moves. The folder that HALFSHADE_TEST_DATA names holds them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "client/client.h"
#include "client/view_file.h"
#include "tests/support/status_matchers.h"

namespace halfshade {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

struct Shot {
  int width = 0, height = 0;
  std::vector<float> visibility;
  std::vector<float> depth;   // 0: nothing
  std::vector<float> object;  // node + 1, the ground after all nodes; 0: nothing
};

std::vector<float> Floats(const v1::OutputImage& image) {
  std::vector<float> values(image.data().size() / sizeof(float));
  std::memcpy(values.data(), image.data().data(), values.size() * sizeof(float));
  return values;
}

// What the shadow is off by where either is in it, on average.
double Mae(const Shot& a, const Shot& b) {
  double sum = 0;
  int pixels = 0;
  for (size_t i = 0; i < a.visibility.size(); ++i) {
    if (a.visibility[i] == 1 && b.visibility[i] == 1) continue;
    sum += std::abs(a.visibility[i] - b.visibility[i]);
    ++pixels;
  }
  return pixels == 0 ? 0 : sum / pixels;
}

class RealScenesTest : public testing::Test {
 protected:
  void SetUp() override {
    const char* data = std::getenv("HALFSHADE_TEST_DATA");
    if (data == nullptr) GTEST_SKIP() << "HALFSHADE_TEST_DATA is not set";
    folder_ = data;
    auto client = Client::Connect({});
    ASSERT_OK(client);
    client_ = *std::move(client);
  }

  // By the view of that name, where there is one.
  v1::RenderRequest RequestOf(const std::string& view, int width = 240, int height = 160) const {
    v1::RenderRequest request;
    const fs::path file = folder_ / "views" / (view + ".json");
    if (fs::exists(file)) {
      EXPECT_OK(ApplyViewFile(file, &request));
    }
    request.set_width(uint32_t(width));
    request.set_height(uint32_t(height));
    for (const v1::OutputKind kind : {v1::OUTPUT_KIND_VISIBILITY, v1::OUTPUT_KIND_DEPTH, v1::OUTPUT_KIND_OBJECT_ID}) {
      v1::Output* output = request.add_outputs();
      output->set_kind(kind);
      output->set_encoding(v1::ENCODING_RAW_F32);
    }
    return request;
  }

  Shot Render(v1::RenderRequest request, const std::string& file) {
    const auto files = ReadSceneFiles(folder_ / "scenes" / file);
    EXPECT_OK(files) << file;
    if (!files.ok()) return {};
    request.set_scene(files->name);
    const auto response = client_->Render(request, &*files);
    EXPECT_OK(response) << file;
    if (!response.ok() || response->images_size() != 3) return {};
    return {int(request.width()), int(request.height()), Floats(response->images(0)), Floats(response->images(1)),
            Floats(response->images(2))};
  }

  fs::path folder_;
  std::unique_ptr<Client> client_;
};

TEST_F(RealScenesTest, EveryFileRendersOrNamesWhatItLacks) {
  std::ifstream manifest(folder_ / "scenes/manifest.tsv");
  std::string line;
  std::getline(manifest, line);
  int rendered = 0, empty = 0;
  while (std::getline(manifest, line)) {
    std::istringstream cells(line);
    std::string name, file;
    std::getline(cells, name, '\t');
    std::getline(cells, file, '\t');
    SCOPED_TRACE(file);
    const auto files = ReadSceneFiles(folder_ / "scenes" / file);
    ASSERT_OK(files);
    const auto scene = client_->UploadScene(*files);
    ASSERT_OK(scene);
    v1::RenderRequest request = RequestOf(fs::path(name).stem());
    request.mutable_method()->mutable_shaft();
    const Shot shot = Render(request, file);
    ASSERT_EQ(shot.visibility.size(), shot.depth.size());
    float darkest = 1;
    for (size_t i = 0; i < shot.visibility.size(); ++i) {
      ASSERT_TRUE(shot.visibility[i] >= 0 && shot.visibility[i] <= 1);
      ASSERT_TRUE(std::isfinite(shot.depth[i]) && shot.depth[i] >= 0);
      darkest = std::min(darkest, shot.visibility[i]);
    }
    if (scene->triangles() > 0) {
      ++rendered;
      EXPECT_LT(darkest, 0.9f) << "something is in shadow, or turned away from the light";
    } else {
      ++empty;
      EXPECT_THAT(scene->warnings(), testing::Contains(HasSubstr("points and lines are not drawn")));
    }
  }
  EXPECT_EQ(rendered + empty, 43);
  EXPECT_EQ(empty, 4) << "points and lines, with indices and without";
}

// The silhouettes differ by what quantization moves: less than a pixel of these 480 x 320. The shadows differ by what
// RAY, which knows the meshes best, says that they do, and each method's own noise.
TEST_F(RealScenesTest, FourEncodingsOfOneMeshGiveOneShadow) {
  const v1::RenderRequest base = RequestOf("spot", 480, 320);
  std::vector<std::pair<std::string, v1::Method>> methods(5);
  methods[0].first = "ray";
  methods[0].second.mutable_ray()->set_rays(256);
  methods[1].first = "shaft";
  methods[1].second.mutable_shaft();
  methods[2].first = "ssm";
  methods[2].second.mutable_ssm();
  methods[3].first = "sssm";
  methods[3].second.mutable_sssm();
  methods[4].first = "hard";
  methods[4].second.mutable_hard();
  double of_ray[3] = {};
  for (const auto& [name, method] : methods) {
    v1::RenderRequest request = base;
    *request.mutable_method() = method;
    const Shot truth = Render(request, "spot/spot.glb");
    ASSERT_FALSE(truth.visibility.empty());
    int i = 0;
    for (const std::string other : {"spot_quantized", "spot_draco", "spot_meshopt"}) {
      const Shot shot = Render(request, other + "/" + other + ".glb");
      ASSERT_EQ(shot.visibility.size(), truth.visibility.size());
      const float truth_ground = *std::max_element(truth.object.begin(), truth.object.end());
      const float shot_ground = *std::max_element(shot.object.begin(), shot.object.end());
      int far = 0, mesh_pixels = 0;
      for (int y = 1; y + 1 < shot.height; ++y) {
        for (int x = 1; x + 1 < shot.width; ++x) {
          const auto is_mesh = [&](const Shot& of, float ground, int dx, int dy) {
            const float object = of.object[size_t((y + dy) * of.width + x + dx)];
            return object > 0 && object < ground;
          };
          bool has_neighbour = false;
          for (int n = 0; n < 9; ++n)
            has_neighbour |= is_mesh(truth, truth_ground, n % 3 - 1, n / 3 - 1) == is_mesh(shot, shot_ground, 0, 0);
          far += !has_neighbour;
          mesh_pixels += is_mesh(truth, truth_ground, 0, 0);
        }
      }
      EXPECT_GT(mesh_pixels, 5000);
      EXPECT_EQ(far, 0) << name << " " << other << ": pixels of the silhouette more than one off";
      const double mae = Mae(shot, truth);
      RecordProperty(name + "_" + other, std::to_string(mae));
      std::printf("%s %s mae %.5f\n", name.c_str(), other.c_str(), mae);
      if (name == "ray") {
        // One ray of 256 meets another triangle in half of the pixels.
        EXPECT_LT(mae, 0.5 / 256) << other;
        of_ray[i] = mae;
      }
      // An edge in a map may go to the next texel, where rays see by how much it moved.
      EXPECT_LE(mae, 3 * of_ray[i]) << name << " " << other;
      ++i;
    }
  }
}

// Of the animations of a file, three moments: the picture moves, and the shadow with it.
TEST_F(RealScenesTest, SkinsAndTargetsMoveAndTheirShadowsToo) {
  for (const std::string name : {"fox", "tentacles", "morph_stress"}) {
    const std::string file = name + "/" + name + (name == "morph_stress" ? ".gltf" : ".glb");
    v1::RenderRequest request = RequestOf(name);
    request.mutable_method()->mutable_shaft();
    std::vector<Shot> shots;
    for (const double time_s : {0.1, 0.4, 0.7, 0.1}) {
      request.mutable_animation()->set_time_s(time_s);
      shots.push_back(Render(request, file));
      ASSERT_FALSE(shots.back().visibility.empty()) << name;
    }
    for (const auto& [a, b] : {std::pair{0, 1}, std::pair{1, 2}, std::pair{0, 2}}) {
      EXPECT_NE(shots[size_t(a)].depth, shots[size_t(b)].depth) << name;
      int moved = 0;
      for (size_t i = 0; i < shots[0].visibility.size(); ++i) {
        moved += std::abs(shots[size_t(a)].visibility[i] - shots[size_t(b)].visibility[i]) > 0.25f;
      }
      EXPECT_GT(moved, 20) << name << ": pixels that came into shadow, or out of it";
    }
    EXPECT_EQ(shots[0].visibility, shots[3].visibility) << name;
  }
}

}  // namespace
}  // namespace halfshade
