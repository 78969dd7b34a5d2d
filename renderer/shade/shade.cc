#include "renderer/shade/shade.h"

#include <glad/gl.h>

#include <cmath>

#include "renderer/gl/framebuffer.h"
#include "renderer/light/fullscreen.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

constexpr double kAmbientNanosecondsPerPixel = 15;  // llvmpipe, two cores
constexpr double kLightNanosecondsPerPixel = 120;
constexpr int kBaseColorsUnit = kPlanesUnit + 1;
constexpr int kNormalsUnit = kPlanesUnit + 2;
constexpr int kVisibilityUnit = kPlanesUnit + 3;

// Edges shorter than this fraction of the distance to the scene shade as a line or a point: the polygon's edge
// integrals would cancel in float.
constexpr double kSmallestEdge = 1e-6;

enum Shape { kRectangle, kLine, kPoint };

struct Emitter {
  Shape shape = kRectangle;
  glm::dvec3 emitted{0};  // radiance of a rectangle, intensity of a line or point
};

Emitter MakeEmitter(const AreaLight& light, const Camera& camera) {
  const double distance = glm::length(light.center_ws - camera.target_ws);
  const bool is_thin_u = light.width_m <= kSmallestEdge * distance;
  const bool is_thin_v = light.height_m <= kSmallestEdge * distance;
  if (!is_thin_u && !is_thin_v) return {kRectangle, light.radiance};
  const double area = light.width_m * light.height_m;
  const glm::dvec3 intensity = area > 0 ? glm::dvec3(light.radiance) * area : glm::dvec3(light.intensity);
  return {is_thin_u && is_thin_v ? kPoint : kLine, intensity};
}

double Exposure(const RenderRequest& request) { return std::exp2(request.shading.exposure_ev); }

absl::Status BindFrame(const DrawContext& draw, const gl::Texture& frame, const RenderRequest& request,
                       gl::Framebuffer& framebuffer) {
  ASSIGN_OR_RETURN(framebuffer, gl::Framebuffer::Create(*draw.context, {&frame}));
  framebuffer.Bind();
  draw.context->gl().Viewport(0, 0, request.width, request.height);
  draw.context->gl().Disable(GL_DEPTH_TEST);
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<gl::Texture> StartFrame(const DrawContext& draw, const GBuffer& gbuffer, const RenderRequest& request) {
  ASSIGN_OR_RETURN(gl::Texture frame, gl::Texture::Create2D(*draw.context, GL_RGBA32F, request.width, request.height));
  gl::Framebuffer framebuffer;
  RETURN_IF_ERROR(BindFrame(draw, frame, request, framebuffer));
  ASSIGN_OR_RETURN(gl::Program * program, draw.programs->Get("common/fullscreen.vert", "shade/ambient.frag"));
  program->Use();
  gbuffer.planes.Bind(kPlanesUnit);
  gbuffer.base_colors.Bind(kBaseColorsUnit);
  program->Set("planes", kPlanesUnit);
  program->Set("base_colors", kBaseColorsUnit);
  const float exposure = float(Exposure(request));
  program->Set("ambient", request.shading.ambient * exposure);
  program->Set("background", request.shading.background * exposure);
  draw.context->gl().Disable(GL_BLEND);
  RETURN_IF_ERROR(DrawFullscreen(draw, request.width, request.height, kAmbientNanosecondsPerPixel));
  RETURN_IF_ERROR(draw.context->Check("shade/ambient"));
  return frame;
}

absl::Status AddLight(const DrawContext& draw, const GBuffer& gbuffer, const Receivers& receivers,
                      const AreaLight& light, const gl::Texture& visibility, const RenderRequest& request,
                      gl::Texture& frame) {
  gl::Framebuffer framebuffer;
  RETURN_IF_ERROR(BindFrame(draw, frame, request, framebuffer));
  ASSIGN_OR_RETURN(gl::Program * program, draw.programs->Get("common/fullscreen.vert", "shade/light.frag"));
  program->Use();
  SetReceivers(*program, receivers, light);
  gbuffer.base_colors.Bind(kBaseColorsUnit);
  gbuffer.normals.Bind(kNormalsUnit);
  visibility.Bind(kVisibilityUnit);
  program->Set("base_colors", kBaseColorsUnit);
  program->Set("normals", kNormalsUnit);
  program->Set("visibility", kVisibilityUnit);
  const Emitter emitter = MakeEmitter(light, request.camera);
  program->Set("shape", int(emitter.shape));
  program->Set("emitted", glm::vec3(emitter.emitted * Exposure(request)));
  program->Set("half_edges", glm::vec2(light.width_m / 2, light.height_m / 2));
  const GladGLContext& gl = draw.context->gl();
  gl.Enable(GL_BLEND);
  gl.BlendFunc(GL_ONE, GL_ONE);
  RETURN_IF_ERROR(DrawFullscreen(draw, request.width, request.height, kLightNanosecondsPerPixel));
  gl.Disable(GL_BLEND);
  return draw.context->Check("shade/light");
}

}  // namespace halfshade
