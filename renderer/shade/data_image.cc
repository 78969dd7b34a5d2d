#include "renderer/shade/data_image.h"

#include <algorithm>
#include <cassert>

#include "renderer/math/camera.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

constexpr double kNanosecondsPerPixel = 20;

// Sets the image's pixels one by one from the texels of one texture, asking the stop check in between.
// write(x, y, texel, pixel): texel and pixel have the channels of texture and image.
template <typename Write>
absl::StatusOr<Image> Convert(const DrawContext& draw, const gl::Texture& texture, int texture_channels,
                              int image_channels, const Write& write) {
  Image texels(texture.width(), texture.height(), texture_channels);
  RETURN_IF_ERROR(texture.ReadFloats(texels.data(), texels.size()));
  Image image(texture.width(), texture.height(), image_channels);
  for (int y = 0; y < image.height(); ++y) {
    RETURN_IF_ERROR(draw.pacer->Charge(kNanosecondsPerPixel * 1e-6 * image.width()));
    for (int x = 0; x < image.width(); ++x) {
      const size_t pixel = size_t(y) * image.width() + x;
      write(x, y, texels.data() + pixel * texture_channels, image.data() + pixel * image_channels);
    }
  }
  return image;
}

struct Point {
  double depth = 0;           // along the camera's axis
  glm::dvec3 from_eye_ws{0};  // world axes
};

// Where the ray through a pixel meets the plane in its texel (Receivers::planes). Nothing is drawn: all zero.
class PixelRays {
 public:
  PixelRays(const Camera& camera, int width, int height)
      : is_orthographic_(camera.is_orthographic),
        ray_from_ndc_(RayFromNdc(camera, double(width) / height)),
        ndc_from_pixel_(2.0 / width, -2.0 / height) {}

  Point Meet(int x, int y, const float* plane) const {
    const glm::dvec3 normal(plane[0], plane[1], plane[2]);
    if (normal == glm::dvec3(0)) return {};
    const glm::dvec2 ndc = glm::dvec2(x + 0.5, y + 0.5) * ndc_from_pixel_ + glm::dvec2(-1, 1);
    const glm::dvec3 across = ray_from_ndc_[0] * ndc.x + ray_from_ndc_[1] * ndc.y;
    const glm::dvec3 origin = is_orthographic_ ? across : glm::dvec3(0);
    const glm::dvec3 ray = is_orthographic_ ? ray_from_ndc_[2] : across + ray_from_ndc_[2];
    const double depth = (plane[3] - glm::dot(normal, origin)) / glm::dot(normal, ray);
    return {depth, origin + ray * depth};
  }

 private:
  bool is_orthographic_;
  glm::dmat3 ray_from_ndc_;
  glm::dvec2 ndc_from_pixel_;
};

}  // namespace

absl::StatusOr<Image> ReadDataImage(const DrawContext& draw, OutputKind kind, const GBuffer& gbuffer,
                                    const Camera& camera) {
  const PixelRays rays(camera, gbuffer.planes.width(), gbuffer.planes.height());
  switch (kind) {
    case OutputKind::kDepth:
      return Convert(draw, gbuffer.planes, 4, 1, [&](int x, int y, const float* plane, float* depth) {
        *depth = float(rays.Meet(x, y, plane).depth);
      });
    case OutputKind::kPosition:
      return Convert(draw, gbuffer.planes, 4, 3, [&](int x, int y, const float* plane, float* position) {
        const Point point = rays.Meet(x, y, plane);
        const glm::dvec3 position_ws = point.depth == 0 ? glm::dvec3(0) : camera.eye_ws + point.from_eye_ws;
        for (int c = 0; c < 3; ++c) position[c] = float(position_ws[c]);
      });
    case OutputKind::kNormal:
      return Convert(draw, gbuffer.normals, 4, 3, [](int, int, const float* half, float* normal) {
        const glm::dvec3 rounded(half[0], half[1], half[2]);
        const double length = glm::length(rounded);
        for (int c = 0; c < 3; ++c) normal[c] = length > 0 ? float(rounded[c] / length) : 0.0f;
      });
    case OutputKind::kAlbedo:
      return Convert(draw, gbuffer.base_colors, 4, 3,
                     [](int, int, const float* rgba, float* albedo) { std::copy_n(rgba, 3, albedo); });
    case OutputKind::kObjectId:
      return Convert(draw, gbuffer.object_ids, 1, 1, [](int, int, const float* in, float* out) { *out = *in; });
    default:
      assert(false && "not a data image");
      return absl::InternalError("not a data image");
  }
}

}  // namespace halfshade
