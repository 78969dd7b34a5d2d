#include "renderer/shade/shade.h"

#include <glad/gl.h>

#include <cmath>

#include "renderer/gl/framebuffer.h"
#include "renderer/light/fullscreen.h"
#include "renderer/math/light_frame.h"
#include "renderer/shade/emitter.h"
#include "renderer/shade/fog.h"
#include "renderer/shade/ltc/ltc_table.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

constexpr double kAmbientNanosecondsPerPixel = 50;  // llvmpipe, two cores
constexpr double kLightNanosecondsPerPixel = 120;
constexpr int kBaseColorsUnit = kPlanesUnit + 1;
constexpr int kNormalsUnit = kPlanesUnit + 2;
constexpr int kEmissionsUnit = kPlanesUnit + 3;
constexpr int kVisibilityUnit = kPlanesUnit + 3;
constexpr int kLtcUnit = kPlanesUnit + 4;  // and the next

// Edges shorter than this fraction of the distance to the scene shade as a line or a point: the polygon's edge
// integrals would cancel in float.
constexpr double kSmallestEdge = 1e-6;

double Exposure(const RenderRequest& request) { return std::exp2(request.shading.exposure_ev); }

absl::Status BindFrame(const DrawContext& draw, const gl::Texture& frame, const RenderRequest& request,
                       gl::Framebuffer& framebuffer) {
  ASSIGN_OR_RETURN(framebuffer, gl::Framebuffer::Create(*draw.context, {&frame}));
  framebuffer.Bind();
  draw.context->gl().Viewport(0, 0, request.width, request.height);
  draw.context->gl().Disable(GL_DEPTH_TEST);
  return absl::OkStatus();
}

// What common/material.glsl and common/receiver.glsl read.
void SetSurfaces(gl::Program& program, const LtcTextures& ltc, const GBuffer& gbuffer, const Receivers& receivers,
                 const AreaLight& light) {
  program.Use();
  SetReceivers(program, receivers, light);
  ltc.Bind(program, kLtcUnit);
  gbuffer.base_colors.Bind(kBaseColorsUnit);
  gbuffer.normals.Bind(kNormalsUnit);
  program.Set("base_colors", kBaseColorsUnit);
  program.Set("normals", kNormalsUnit);
}

}  // namespace

Emitter MakeEmitter(const AreaLight& light, const Camera& camera) {
  const double distance = glm::length(light.center_ws - camera.target_ws);
  const bool is_thin_u = light.width_m <= kSmallestEdge * distance;
  const bool is_thin_v = light.height_m <= kSmallestEdge * distance;
  if (!is_thin_u && !is_thin_v) return {{}, light.radiance};
  const double area = light.width_m * light.height_m;
  const glm::dvec3 intensity = area > 0 ? glm::dvec3(light.radiance) * area : glm::dvec3(light.intensity);
  return {{is_thin_u && is_thin_v ? "SHAPE_POINT" : "SHAPE_LINE"}, intensity};
}

absl::StatusOr<LtcTextures> LtcTextures::Create(const gl::Context& context) {
  std::vector<glm::vec4> lobes;
  std::vector<glm::vec2> albedos;
  for (const LtcEntry& entry : LtcTable()) {
    lobes.emplace_back(entry.m11, entry.m13, entry.m31, entry.m33);
    albedos.emplace_back(entry.albedo, entry.grazing);
  }
  LtcTextures result;
  ASSIGN_OR_RETURN(result.lobes_, gl::Texture::Create2D(context, GL_RGBA32F, kLtcSize, kLtcSize));
  ASSIGN_OR_RETURN(result.albedos_, gl::Texture::Create2D(context, GL_RG32F, kLtcSize, kLtcSize));
  const GladGLContext& gl = context.gl();
  gl.TextureSubImage2D(result.lobes_.id(), 0, 0, 0, kLtcSize, kLtcSize, GL_RGBA, GL_FLOAT, lobes.data());
  gl.TextureSubImage2D(result.albedos_.id(), 0, 0, 0, kLtcSize, kLtcSize, GL_RG, GL_FLOAT, albedos.data());
  for (const gl::Texture* texture : {&result.lobes_, &result.albedos_}) {
    gl.TextureParameteri(texture->id(), GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    gl.TextureParameteri(texture->id(), GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  }
  RETURN_IF_ERROR(context.Check("shade/ltc"));
  return result;
}

void LtcTextures::Bind(gl::Program& program, int first_unit) const {
  lobes_.Bind(first_unit);
  albedos_.Bind(first_unit + 1);
  program.Set("ltc_lobes", first_unit);
  program.Set("ltc_albedos", first_unit + 1);
  program.Set("ltc_layout", glm::vec2(kMinLtcRoughness, kLtcSize));
}

absl::StatusOr<gl::Texture> StartFrame(const DrawContext& draw, const LtcTextures& ltc, const GBuffer& gbuffer,
                                       const Receivers& receivers, const RenderRequest& request) {
  ASSIGN_OR_RETURN(gl::Texture frame, gl::Texture::Create2D(*draw.context, GL_RGBA32F, request.width, request.height));
  gl::Framebuffer framebuffer;
  RETURN_IF_ERROR(BindFrame(draw, frame, request, framebuffer));
  ASSIGN_OR_RETURN(gl::Program * program, draw.programs->Get("common/fullscreen.vert", "shade/ambient.frag"));
  AreaLight world;  // ambient light has no frame of its own
  world.center_ws = receivers.camera.eye_ws;
  SetSurfaces(*program, ltc, gbuffer, receivers, world);
  gbuffer.emissions.Bind(kEmissionsUnit);
  program->Set("emissions", kEmissionsUnit);
  const float exposure = float(Exposure(request));
  program->Set("exposure", exposure);
  program->Set("ambient", request.shading.ambient * exposure);
  program->Set("background", request.shading.background * exposure);
  draw.context->gl().Disable(GL_BLEND);
  RETURN_IF_ERROR(DrawFullscreen(draw, request.width, request.height, kAmbientNanosecondsPerPixel));
  RETURN_IF_ERROR(draw.context->Check("shade/ambient"));
  return frame;
}

absl::Status AddLight(const DrawContext& draw, const LtcTextures& ltc, const GBuffer& gbuffer,
                      const Receivers& receivers, const AreaLight& light, const gl::Texture& visibility,
                      const RenderRequest& request, gl::Texture& frame) {
  gl::Framebuffer framebuffer;
  RETURN_IF_ERROR(BindFrame(draw, frame, request, framebuffer));
  Emitter emitter = MakeEmitter(light, request.camera);
  if (request.fog) emitter.defines.push_back("HAS_FOG");
  ASSIGN_OR_RETURN(gl::Program * program,
                   draw.programs->Get("common/fullscreen.vert", "shade/light.frag", emitter.defines));
  SetSurfaces(*program, ltc, gbuffer, receivers, light);
  visibility.Bind(kVisibilityUnit);
  program->Set("visibility", kVisibilityUnit);
  program->Set("emitted", glm::vec3(emitter.emitted * Exposure(request)));
  program->Set("half_edges", glm::vec2(light.width_m / 2, light.height_m / 2));
  if (request.fog) {
    SetFog(*program, *request.fog);
    program->Set("light_height", HeightInFog(*request.fog, light.center_ws.y));
    program->Set("up", glm::vec3(MakeLightFrame(light).light_from_world_rotation * glm::dvec3(0, 1, 0)));
  }
  const GladGLContext& gl = draw.context->gl();
  gl.Enable(GL_BLEND);
  gl.BlendFunc(GL_ONE, GL_ONE);
  RETURN_IF_ERROR(DrawFullscreen(draw, request.width, request.height, kLightNanosecondsPerPixel));
  gl.Disable(GL_BLEND);
  return draw.context->Check("shade/light");
}

}  // namespace halfshade
