// A renderer whose textures are raw texels, and scenes with materials, for the tests of shading.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "renderer/renderer.h"
#include "tests/support/render_fixture.h"

namespace halfshade {

using Rgba = std::vector<uint8_t>;  // 4 a texel

// Draws with a renderer of its own on the test context; decodes EncodedImage::bytes as raw RGBA.
class ShadeTest : public testing::Test {
 protected:
  // The images of the request's outputs; empty and a failed test on an error.
  std::vector<RenderedImage> Render(const FlatScene& scene, const RenderRequest& request);
  Image RenderFrame(const FlatScene& scene, RenderRequest request);

  const std::vector<std::string>& decoded() const { return decoded_; }
  const RenderReport& report() const { return report_; }
  void Forget() {
    Shared().ForgetScene("scene");
    decoded_.clear();
  }

 private:
  static Renderer& Shared();
  static std::vector<std::string> decoded_;  // names of images, in order
  RenderReport report_;
};

// A new texture of the scene: its index.
int32_t AddTexture(FlatScene* scene, uint32_t width, uint32_t height, const Rgba& texels,
                   const Texture& sampling = {.magnifies_to_nearest = true});

// A plate in y = 0 of edge `size` around the origin, seen from above with u along x and v along z. One mesh, material
// 0.
FlatScene TexturedPlate(double size);

// Straight down on the middle of a plate: n x n pixels over size_m. No light, no ambient, black background.
RenderRequest LookDownOn(double size_m, int n);

}  // namespace halfshade
