#include "renderer/shadow/finish_visibility.h"

#include <glad/gl.h>

#include <algorithm>

#include "renderer/gl/framebuffer.h"
#include "renderer/light/fullscreen.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

constexpr double kNanosecondsPerPixel = 30;  // llvmpipe, two cores
constexpr int kSumsUnit = kPlanesUnit + 1;
constexpr int kBlockersUnit = kPlanesUnit + 2;
constexpr int kOthersUnit = kPlanesUnit + 3;

}  // namespace

absl::StatusOr<gl::Texture> FinishVisibility(const DrawContext& draw, const OcclusionSum* occlusion,
                                             const Receivers& receivers, const AreaLight& light,
                                             gl::Texture* penumbra_width, const gl::Texture* others) {
  const GladGLContext& gl = draw.context->gl();
  ASSIGN_OR_RETURN(gl::Texture visibility,
                   gl::Texture::Create2D(*draw.context, GL_RG32F, receivers.width, receivers.height));
  std::vector<const gl::Texture*> targets = {&visibility};
  if (penumbra_width != nullptr) {
    ASSIGN_OR_RETURN(*penumbra_width, gl::Texture::Create2D(*draw.context, GL_R32F, receivers.width, receivers.height));
    targets.push_back(penumbra_width);
  }
  ASSIGN_OR_RETURN(gl::Framebuffer framebuffer, gl::Framebuffer::Create(*draw.context, targets));
  ASSIGN_OR_RETURN(gl::Program * program, draw.programs->Get("common/fullscreen.vert", "shadow/finish.frag"));
  gl::Texture uploaded;
  const gl::Texture* sums = nullptr;
  if (occlusion != nullptr) {
    sums = std::get_if<gl::Texture>(&occlusion->sums);
    if (sums == nullptr) {
      const auto& values = std::get<std::vector<float>>(occlusion->sums);
      ASSIGN_OR_RETURN(uploaded, gl::Texture::Create2D(*draw.context, GL_R32F, receivers.width, receivers.height));
      RETURN_IF_ERROR(uploaded.WriteFloats(values.data(), values.size()));
      sums = &uploaded;
    }
  }
  framebuffer.Bind();
  gl.Viewport(0, 0, receivers.width, receivers.height);
  gl.Disable(GL_DEPTH_TEST);
  gl.Disable(GL_BLEND);
  program->Use();
  SetReceivers(*program, receivers, light);
  if (sums != nullptr) sums->Bind(kSumsUnit);
  program->Set("hidden_sums", kSumsUnit);
  program->Set("has_sums", int(occlusion != nullptr));
  program->Set("full_sum", occlusion != nullptr ? occlusion->full_sum : 1.0f);
  const bool has_blockers = penumbra_width != nullptr && occlusion != nullptr && occlusion->blockers;
  if (has_blockers) occlusion->blockers.Bind(kBlockersUnit);
  program->Set("blockers", has_blockers ? kBlockersUnit : kSumsUnit);
  program->Set("has_blockers", int(has_blockers));
  if (others != nullptr) others->Bind(kOthersUnit);
  program->Set("others", others != nullptr ? kOthersUnit : kPlanesUnit);
  program->Set("has_others", int(others != nullptr));
  program->Set("half_edges", glm::vec2(light.width_m / 2, light.height_m / 2));
  RETURN_IF_ERROR(DrawFullscreen(draw, receivers.width, receivers.height, kNanosecondsPerPixel));
  RETURN_IF_ERROR(draw.context->Check("shadow/finish"));
  return visibility;
}

std::vector<float> FinishVisibilityOnCpu(const OcclusionSum* occlusion, const CpuReceivers& receivers,
                                         const AreaLight& light) {
  std::vector<float> visibility(receivers.size(), 1);
  for (size_t i = 0; i < visibility.size(); ++i) {
    const CpuReceiver receiver = receivers.At(i);
    if (!receiver.is_receiving) continue;
    const float hidden =
        occlusion != nullptr ? std::get<std::vector<float>>(occlusion->sums)[i] / occlusion->full_sum : 0;
    visibility[i] = std::clamp(1 - hidden, 0.0f, 1.0f) * float(CutAtPlane(light, receivers, receiver).share);
  }
  return visibility;
}

absl::StatusOr<double> LargestFraction(const OcclusionSum& occlusion, size_t receivers) {
  const bool has_own_full_sums = occlusion.full_sum == 0;
  const size_t channels = has_own_full_sums ? 2 : 1;
  std::vector<float> read_back;
  const auto* sums = std::get_if<std::vector<float>>(&occlusion.sums);
  if (sums == nullptr) {
    read_back.resize(receivers * channels);
    RETURN_IF_ERROR(std::get<gl::Texture>(occlusion.sums).ReadFloats(read_back.data(), read_back.size()));
    sums = &read_back;
  }
  double largest = occlusion.largest_fraction;
  for (size_t i = 0; i < sums->size(); i += channels) {
    const float full = has_own_full_sums ? (*sums)[i + 1] : occlusion.full_sum;
    if (full > 0) largest = std::max(largest, double((*sums)[i] / full));
  }
  return largest;
}

}  // namespace halfshade
