#include "tests/renderer/shade/shade_fixture.h"

namespace halfshade {

std::vector<std::string> ShadeTest::decoded_;

Renderer& ShadeTest::Shared() {
  // Never destroyed, as the context.
  static Renderer& renderer = *[] {
    auto created = Renderer::Create(&TestContext(), [](const EncodedImage& image) -> absl::StatusOr<Rgba8Image> {
      decoded_.push_back(image.name);
      return Rgba8Image{int(image.width), int(image.height), {image.bytes.begin(), image.bytes.end()}};
    });
    EXPECT_OK(created);
    return created->release();
  }();
  return renderer;
}

std::vector<RenderedImage> ShadeTest::Render(const FlatScene& scene, const RenderRequest& request) {
  Forget();
  auto result = Shared().Render("scene", scene, request, [] { return absl::OkStatus(); });
  EXPECT_OK(result);
  if (!result.ok()) return {};
  report_ = result->report;
  return std::move(result->images);
}

Image ShadeTest::RenderFrame(const FlatScene& scene, RenderRequest request) {
  request.outputs = {OutputKind::kFrame};
  std::vector<RenderedImage> images = Render(scene, request);
  return images.empty() ? Image(request.width, request.height, 4) : std::move(images[0].image);
}

int32_t AddTexture(FlatScene* scene, uint32_t width, uint32_t height, const Rgba& texels, const Texture& sampling) {
  EXPECT_EQ(texels.size(), 4 * size_t(width) * height);
  Texture texture = sampling;
  texture.image = uint32_t(scene->images.size());
  scene->images.push_back(
      {"/images/" + std::to_string(texture.image), std::string(texels.begin(), texels.end()), width, height});
  scene->textures.push_back(texture);
  return int32_t(scene->textures.size()) - 1;
}

FlatScene TexturedPlate(double size) {
  GlbMesh plate = MakePlate({0, 0, 0}, size, size);
  for (const glm::vec3& p : plate.positions) plate.texcoords.emplace_back(p.x / size + 0.5, p.z / size + 0.5);
  plate.normals.assign(4, {0, 1, 0});
  plate.base_color = glm::vec4(1);
  return MakeFlatScene({plate});
}

RenderRequest LookDownOn(double size_m, int n) {
  RenderRequest request;
  request.camera = LookDown(10, size_m);
  request.width = request.height = n;
  request.method = HardOptions{16};
  request.shading.ambient = glm::vec3(0);
  request.shading.background = glm::vec3(0);
  return request;
}

}  // namespace halfshade
