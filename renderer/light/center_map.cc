#include "renderer/light/center_map.h"

#include <glad/gl.h>

#include <limits>
#include <utility>

#include "renderer/gl/framebuffer.h"
#include "renderer/light/depth_pyramid.h"
#include "renderer/light/fullscreen.h"
#include "renderer/math/light_frame.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

// llvmpipe, two cores.
constexpr double kClassifyNanosecondsPerPixel = 60;
constexpr double kFilterNanosecondsPerPixel = 60;
constexpr double kFilterNanosecondsPerTap = 4;
constexpr int kMapUnit = kPlanesUnit + 1;
constexpr int kHiddenCenterUnit = kPlanesUnit + 2;
static_assert(kHiddenCenterUnit < CenterMap::kFirstFreeUnit);
// A Gaussian cut at two deviations of half its window each has the variance (1 - 4 phi(2) / (2 Phi(2) - 1)) / 4 = .1934
// of half the window squared, a rectangle 1/3: sqrt(1/3 / .1934). Narrower, its penumbrae would be too.
constexpr double kGaussianExtent = 1.3129;
constexpr GLuint kPyramidBinding = 1;
constexpr size_t kMaxLevels = 12;  // of light/windows.glsl: 2^11 squares of 4 texels a side are 8192

}  // namespace

const char* WeightsName(FilterWeights weights) { return weights == FilterWeights::kMean ? "MEAN" : "GAUSSIAN"; }

absl::StatusOr<std::unique_ptr<CenterMap>> CenterMap::Create(const DrawContext& draw,
                                                             std::shared_ptr<const OccludersOnContext> occluders,
                                                             const AreaLight& light, const AreaLight& cell,
                                                             int map_size) {
  auto map = std::make_unique<CenterMap>();
  map->cell_ = cell;
  const glm::dvec2 center(PointToLight(MakeLightFrame(light), cell.center_ws));
  // Its few maps are always kept while they are used; what is larger than the cache is not kept longer.
  ASSIGN_OR_RETURN(map->maps_, SampleMaps::Create(draw, std::move(occluders), light, {center}, map_size,
                                                  std::numeric_limits<uint64_t>::max()));
  const SampleMaps::FrontMap front = map->maps_->front_map();
  std::vector<float> depths(size_t(map_size) * map_size);
  RETURN_IF_ERROR(front.maps->ReadFloats(depths.data(), depths.size()));
  const DepthPyramid pyramid = BuildDepthPyramid(depths, map_size);
  for (const DepthPyramid::Level& level : pyramid.levels) map->levels_.emplace_back(level.first, level.side, 0, 0);
  ASSIGN_OR_RETURN(map->ranges_, gl::Buffer::Create(*draw.context, pyramid.ranges));
  map->pyramid_bytes_ = pyramid.ranges.size() * sizeof(glm::vec2);
  return map;
}

uint64_t CenterMap::PredictedBytes(int map_size) {
  const uint64_t texels = uint64_t(map_size) * map_size;
  // A third more than a sixteenth of the texels are squares of the pyramid.
  return 4 * texels + texels / 16 * 4 / 3 * sizeof(glm::vec2);
}

void CenterMap::SetUniforms(const DrawContext& draw, gl::Program& program, const Receivers& receivers,
                            const WindowTaps& taps, const gl::Texture* hidden_center) const {
  const SampleMaps::FrontMap front = maps_->front_map();
  SetReceivers(program, receivers, cell_);
  draw.context->gl().BindBufferBase(GL_SHADER_STORAGE_BUFFER, kPyramidBinding, ranges_.id());
  program.Set("levels", levels_);
  program.Set("level_count", int(levels_.size()));
  program.Set("map_size", float(front.map_size));
  program.Set("first_center", glm::vec2(front.first_center));
  program.Set("slope_per_texel", glm::vec2(front.slope_per_texel));
  program.Set("z_near", float(front.z_near));
  const double extent = taps.weights == FilterWeights::kGaussian ? kGaussianExtent : 1;
  program.Set("half_edges", glm::vec2(glm::dvec2(cell_.width_m, cell_.height_m) * (extent / 2)));
  program.Set("front_slope", float(front.side_slope));
  front.maps->Bind(kMapUnit);
  program.Set("maps", kMapUnit);
  program.Set("hidden_center", hidden_center != nullptr && *hidden_center ? kHiddenCenterUnit : kPlanesUnit);
  if (hidden_center != nullptr && *hidden_center) hidden_center->Bind(kHiddenCenterUnit);
  program.Set("blocker_taps", taps.blocker);
  program.Set("filter_taps", taps.filter);
  program.Set("is_gaussian", int(taps.weights == FilterWeights::kGaussian));
}

absl::StatusOr<gl::Texture> CenterMap::HiddenCenter(const DrawContext& draw, const Receivers& receivers) const {
  if (maps_->front_map().side_slope == 0) return gl::Texture();
  return maps_->CountHidden(draw, receivers);
}

absl::StatusOr<std::vector<float>> ReadProofs(const gl::Texture& proofs) {
  std::vector<float> values(size_t(proofs.width()) * proofs.height());
  RETURN_IF_ERROR(proofs.ReadFloats(values.data(), values.size()));
  return values;
}

absl::StatusOr<CenterMap::Filtered> CenterMap::Filter(const DrawContext& draw, const Receivers& receivers,
                                                      const WindowTaps& taps, bool skips) const {
  const GladGLContext& gl = draw.context->gl();
  ASSIGN_OR_RETURN(gl::Texture hidden,
                   gl::Texture::Create2D(*draw.context, GL_R32F, receivers.width, receivers.height));
  std::vector<const gl::Texture*> targets = {&hidden};
  gl::Texture blockers;
  if (receivers.wants_blockers) {
    ASSIGN_OR_RETURN(blockers, gl::Texture::Create2D(*draw.context, GL_RG32F, receivers.width, receivers.height));
    targets.push_back(&blockers);
  }
  ASSIGN_OR_RETURN(const gl::Framebuffer framebuffer, gl::Framebuffer::Create(*draw.context, targets));
  gl.Disable(GL_DEPTH_TEST);
  gl.Disable(GL_BLEND);
  TileList tiles = ListTiles(receivers.width, receivers.height, {});
  if (skips) {
    ASSIGN_OR_RETURN(gl::Program * program,
                     draw.programs->Get("common/fullscreen.vert", "light/classify_windows.frag"));
    framebuffer.Bind();
    gl.Viewport(0, 0, receivers.width, receivers.height);
    program->Use();
    SetUniforms(draw, *program, receivers, taps);
    RETURN_IF_ERROR(DrawFullscreen(draw, receivers.width, receivers.height, kClassifyNanosecondsPerPixel));
    ASSIGN_OR_RETURN(const std::vector<float> proofs, ReadProofs(hidden));
    tiles = ListProofs(proofs, receivers.width, receivers.height, [](float proof) { return proof < 0; });
  }
  gl::Texture hidden_center;
  if (!tiles.empty()) {
    ASSIGN_OR_RETURN(hidden_center, HiddenCenter(draw, receivers));
  }
  ASSIGN_OR_RETURN(gl::Program * program, draw.programs->Get("common/tiles.vert", "light/filter_window.frag"));
  framebuffer.Bind();
  program->Use();
  SetUniforms(draw, *program, receivers, taps, &hidden_center);
  const double tap_count = double(taps.blocker) * taps.blocker + double(taps.filter) * taps.filter;
  RETURN_IF_ERROR(DrawTiles(draw, *program, receivers.width, receivers.height, tiles,
                            kFilterNanosecondsPerPixel + kFilterNanosecondsPerTap * tap_count));
  RETURN_IF_ERROR(draw.context->Check("light/filter_window"));
  return Filtered{std::move(hidden), std::move(blockers), tiles.size()};
}

}  // namespace halfshade
