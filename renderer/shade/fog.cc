#include "renderer/shade/fog.h"

#include <glad/gl.h>

#include <cmath>

#include "renderer/gl/framebuffer.h"
#include "renderer/light/fullscreen.h"
#include "renderer/math/light_frame.h"
#include "renderer/shade/emitter.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

constexpr double kPointsNanosecondsPerPixel = 60;  // llvmpipe, two cores
constexpr double kLightNanosecondsPerPixel = 80;
constexpr double kOverNanosecondsPerPixel = 120;
constexpr int kVisibilityUnit = kPlanesUnit + 1;
constexpr int kScatteredUnit = kPlanesUnit + 2;
constexpr float kInfinitelyFarM = 1e30f;

absl::Status BindTarget(const DrawContext& draw, const gl::Texture& target, gl::Framebuffer& framebuffer) {
  ASSIGN_OR_RETURN(framebuffer, gl::Framebuffer::Create(*draw.context, {&target}));
  framebuffer.Bind();
  draw.context->gl().Viewport(0, 0, target.width(), target.height());
  draw.context->gl().Disable(GL_DEPTH_TEST);
  draw.context->gl().Disable(GL_BLEND);
  return absl::OkStatus();
}

float Exposure(const RenderRequest& request) { return float(std::exp2(request.shading.exposure_ev)); }

}  // namespace

void SetFog(gl::Program& program, const Fog& fog) {
  program.Set("fog_density", float(fog.density_per_m));
  program.Set("fog_inverse_height", fog.falloff_height_m > 0 ? float(1 / fog.falloff_height_m) : 0.0f);
}

float HeightInFog(const Fog& fog, double height_ws) { return float(height_ws - fog.ground_m); }

absl::StatusOr<FogView> FogView::Create(const DrawContext& draw, const Receivers& pixels,
                                        const RenderRequest& request) {
  FogView view;
  view.pixels_ = pixels;
  view.request_ = &request;
  const size_t count = size_t(pixels.width) * pixels.height;
  view.on_cpu_.camera = pixels.camera;
  view.on_cpu_.width = pixels.width;
  view.on_cpu_.height = pixels.height;
  view.on_cpu_.planes.assign(count, glm::vec4(0, 0, 0, kNoHorizon));
  ReceiverTextures textures;
  ASSIGN_OR_RETURN(textures, UploadReceivers(*draw.context, view.on_cpu_));
  view.no_planes_ = std::move(textures.planes);
  for (gl::Texture* texture : {&view.points_, &view.scattered_}) {
    ASSIGN_OR_RETURN(*texture, gl::Texture::Create2D(*draw.context, GL_RGBA32F, pixels.width, pixels.height));
  }
  const float nothing[4] = {0, 0, 0, 0};
  draw.context->gl().ClearTexImage(view.scattered_.id(), 0, GL_RGBA, GL_FLOAT, nothing);
  return view;
}

absl::StatusOr<Receivers> FogView::StepPoints(const DrawContext& draw, int step, bool on_cpu) {
  gl::Framebuffer framebuffer;
  RETURN_IF_ERROR(BindTarget(draw, points_, framebuffer));
  ASSIGN_OR_RETURN(gl::Program * program, draw.programs->Get("common/fullscreen.vert", "shade/fog_points.frag"));
  program->Use();
  AreaLight world;  // the points are in no light's frame
  world.center_ws = pixels_.camera.eye_ws;
  SetReceivers(*program, pixels_, world);
  SetFog(*program, *request_->fog);
  program->Set("eye_height", HeightInFog(*request_->fog, pixels_.camera.eye_ws.y));
  program->Set("step_index", float(step));
  program->Set("step_count", float(kFogSteps));
  program->Set("background_m", kInfinitelyFarM);
  RETURN_IF_ERROR(DrawFullscreen(draw, pixels_.width, pixels_.height, kPointsNanosecondsPerPixel));
  RETURN_IF_ERROR(draw.context->Check("shade/fog_points"));
  Receivers points = {&no_planes_, pixels_.camera, pixels_.width, pixels_.height};
  points.points = &points_;
  if (on_cpu) {
    on_cpu_.points.resize(on_cpu_.planes.size());
    RETURN_IF_ERROR(points_.ReadFloats(&on_cpu_.points[0].x, 4 * on_cpu_.points.size()));
    points.on_cpu = &on_cpu_;
  }
  return points;
}

absl::Status FogView::AddLight(const DrawContext& draw, const Receivers& points, const AreaLight& light,
                               const gl::Texture& visibility) {
  gl::Framebuffer framebuffer;
  RETURN_IF_ERROR(BindTarget(draw, scattered_, framebuffer));
  const Emitter emitter = MakeEmitter(light, pixels_.camera);
  ASSIGN_OR_RETURN(gl::Program * program,
                   draw.programs->Get("common/fullscreen.vert", "shade/fog_light.frag", emitter.defines));
  program->Use();
  SetReceivers(*program, points, light);
  SetFog(*program, *request_->fog);
  visibility.Bind(kVisibilityUnit);
  program->Set("visibility", kVisibilityUnit);
  program->Set("half_edges", glm::vec2(light.width_m / 2, light.height_m / 2));
  program->Set("emitted", glm::vec3(emitter.emitted) * request_->fog->albedo * (Exposure(*request_) / kFogSteps));
  program->Set("light_height", HeightInFog(*request_->fog, light.center_ws.y));
  program->Set("up", glm::vec3(MakeLightFrame(light).light_from_world_rotation * glm::dvec3(0, 1, 0)));
  const GladGLContext& gl = draw.context->gl();
  gl.Enable(GL_BLEND);
  gl.BlendFunc(GL_ONE, GL_ONE);
  RETURN_IF_ERROR(DrawFullscreen(draw, pixels_.width, pixels_.height, kLightNanosecondsPerPixel));
  gl.Disable(GL_BLEND);
  return draw.context->Check("shade/fog_light");
}

absl::Status FogView::DrawOver(const DrawContext& draw, gl::Texture& frame) {
  // How much the fog takes stands beside the points of any step; without a light there are none yet.
  RETURN_IF_ERROR(StepPoints(draw, 0, false).status());
  gl::Framebuffer framebuffer;
  RETURN_IF_ERROR(BindTarget(draw, frame, framebuffer));
  ASSIGN_OR_RETURN(gl::Program * program, draw.programs->Get("common/fullscreen.vert", "shade/fog_over.frag"));
  program->Use();
  points_.Bind(kPlanesUnit);
  scattered_.Bind(kScatteredUnit);
  program->Set("points", kPlanesUnit);
  program->Set("scattered", kScatteredUnit);
  program->Set("ambient", request_->shading.ambient * request_->fog->albedo * Exposure(*request_));
  const GladGLContext& gl = draw.context->gl();
  gl.Enable(GL_BLEND);
  gl.BlendFuncSeparate(GL_ONE, GL_SRC_ALPHA, GL_ZERO, GL_ONE);
  RETURN_IF_ERROR(DrawFullscreen(draw, pixels_.width, pixels_.height, kOverNanosecondsPerPixel));
  gl.Disable(GL_BLEND);
  return draw.context->Check("shade/fog_over");
}

}  // namespace halfshade
