#include "renderer/shadow/pcss/pcss.h"

#include <glad/gl.h>

#include <algorithm>
#include <limits>

#include "renderer/gl/framebuffer.h"
#include "renderer/gl/handles.h"
#include "renderer/light/depth_pyramid.h"
#include "renderer/light/fullscreen.h"
#include "renderer/light/sample_maps.h"
#include "renderer/light/tiles.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

// llvmpipe, two cores.
constexpr double kClassifyNanosecondsPerPixel = 60;
constexpr double kResolveNanosecondsPerPixel = 60;
constexpr double kResolveNanosecondsPerTap = 4;
constexpr int kMapsUnit = kPlanesUnit + 1;
constexpr int kHiddenCenterUnit = kPlanesUnit + 2;
constexpr GLuint kPyramidBinding = 1;
constexpr size_t kMaxLevels = 12;  // of pcss/windows.glsl: 2^11 squares of 4 texels a side are 8192

struct PcssData : LightData {
  AreaLight light;
  std::unique_ptr<SampleMaps> maps;  // from the centre, all sides
  gl::Buffer ranges;
  std::vector<glm::vec4> levels;
  uint64_t pyramid_bytes = 0;
  uint64_t SizeBytes() const override { return maps->SizeBytes() + pyramid_bytes; }
  uint64_t MapsDrawn() const override { return maps->MapsDrawn(); }
};

absl::Status BuildPyramid(const DrawContext& draw, PcssData& data) {
  const SampleMaps::FrontMap front = data.maps->front_map();
  std::vector<float> depths(size_t(front.map_size) * front.map_size);
  RETURN_IF_ERROR(front.maps->ReadFloats(depths.data(), depths.size()));
  const DepthPyramid pyramid = BuildDepthPyramid(depths, front.map_size);
  for (const DepthPyramid::Level& level : pyramid.levels) data.levels.emplace_back(level.first, level.side, 0, 0);
  ASSIGN_OR_RETURN(data.ranges, gl::Buffer::Create(*draw.context, pyramid.ranges));
  data.pyramid_bytes = pyramid.ranges.size() * sizeof(glm::vec2);
  return absl::OkStatus();
}

// What pcss/windows.glsl and both passes read.
void SetMap(const DrawContext& draw, gl::Program& program, const PcssData& data, const Receivers& receivers) {
  const SampleMaps::FrontMap front = data.maps->front_map();
  SetReceivers(program, receivers, data.light);
  draw.context->gl().BindBufferBase(GL_SHADER_STORAGE_BUFFER, kPyramidBinding, data.ranges.id());
  program.Set("levels", data.levels);
  program.Set("level_count", int(data.levels.size()));
  program.Set("map_size", float(front.map_size));
  program.Set("first_center", glm::vec2(front.first_center));
  program.Set("slope_per_texel", glm::vec2(front.slope_per_texel));
  program.Set("z_near", float(front.z_near));
  program.Set("half_edges", glm::vec2(data.light.width_m / 2, data.light.height_m / 2));
  program.Set("front_slope", float(front.side_slope));
}

// Writes 0 or 1 where the pyramid proves it; the tiles that hold anything else come back.
absl::StatusOr<TileList> Classify(const DrawContext& draw, const PcssData& data, const Receivers& receivers,
                                  const gl::Texture& sums) {
  const GladGLContext& gl = draw.context->gl();
  ASSIGN_OR_RETURN(const gl::Framebuffer framebuffer, gl::Framebuffer::Create(*draw.context, {&sums}));
  ASSIGN_OR_RETURN(gl::Program * program, draw.programs->Get("common/fullscreen.vert", "pcss/classify.frag"));
  framebuffer.Bind();
  gl.Viewport(0, 0, receivers.width, receivers.height);
  program->Use();
  SetMap(draw, *program, data, receivers);
  RETURN_IF_ERROR(DrawFullscreen(draw, receivers.width, receivers.height, kClassifyNanosecondsPerPixel));
  std::vector<float> proofs(size_t(receivers.width) * receivers.height);
  RETURN_IF_ERROR(sums.ReadFloats(proofs.data(), proofs.size()));
  std::vector<bool> is_undecided(proofs.size());
  std::transform(proofs.begin(), proofs.end(), is_undecided.begin(), [](float proof) { return proof < 0; });
  return ListTiles(receivers.width, receivers.height, is_undecided);
}

const char* WeightsName(FilterWeights weights) { return weights == FilterWeights::kMean ? "MEAN" : "GAUSSIAN"; }

}  // namespace

MethodNeeds PcssMethod::Needs(const MethodOptions& options, const SceneFacts&) const {
  const uint64_t texels = uint64_t(std::get<PcssOptions>(options).map_size) * std::get<PcssOptions>(options).map_size;
  // A third more than a sixteenth of the texels are squares of the pyramid, of 8 bytes.
  return {.maps = 1,
          .map_size = std::get<PcssOptions>(options).map_size,
          .light_data_bytes = 4 * texels + texels / 16 * 4 / 3 * sizeof(glm::vec2)};
}

absl::StatusOr<std::unique_ptr<LightData>> PcssMethod::BuildLightData(const DrawContext& draw,
                                                                      const LightInputs& inputs,
                                                                      const MethodOptions& options) const {
  auto data = std::make_unique<PcssData>();
  data->light = inputs.light;
  // Its few maps are always kept while they are used; what is larger than the cache is not kept longer.
  ASSIGN_OR_RETURN(data->maps,
                   SampleMaps::Create(draw, inputs.occluders, inputs.light, {glm::dvec2(0)},
                                      std::get<PcssOptions>(options).map_size, std::numeric_limits<uint64_t>::max()));
  RETURN_IF_ERROR(BuildPyramid(draw, *data));
  return data;
}

std::string PcssMethod::LightDataOptions(const MethodOptions& options) const {
  return "map_size=" + std::to_string(std::get<PcssOptions>(options).map_size);
}

absl::StatusOr<OcclusionSum> PcssMethod::ResolveOcclusion(const DrawContext& draw, const LightData& light_data,
                                                          const Receivers& receivers,
                                                          const MethodOptions& options) const {
  const auto& data = static_cast<const PcssData&>(light_data);
  const auto& pcss = std::get<PcssOptions>(options);
  const GladGLContext& gl = draw.context->gl();
  const SampleMaps::FrontMap front = data.maps->front_map();
  ASSIGN_OR_RETURN(gl::Texture sums, gl::Texture::Create2D(*draw.context, GL_R32F, receivers.width, receivers.height));
  gl.Disable(GL_DEPTH_TEST);
  gl.Disable(GL_BLEND);
  TileList tiles;
  if (pcss.skips) {
    ASSIGN_OR_RETURN(tiles, Classify(draw, data, receivers, sums));
  } else {
    tiles = ListTiles(receivers.width, receivers.height, {});
  }
  gl::Texture hidden_center;
  if (front.side_slope > 0 && !tiles.empty()) {
    ASSIGN_OR_RETURN(hidden_center, data.maps->CountHidden(draw, receivers));
  }
  ASSIGN_OR_RETURN(const gl::Framebuffer framebuffer, gl::Framebuffer::Create(*draw.context, {&sums}));
  ASSIGN_OR_RETURN(gl::Program * program, draw.programs->Get("common/tiles.vert", "pcss/resolve.frag"));
  framebuffer.Bind();
  program->Use();
  SetMap(draw, *program, data, receivers);
  front.maps->Bind(kMapsUnit);
  if (hidden_center) hidden_center.Bind(kHiddenCenterUnit);
  program->Set("maps", kMapsUnit);
  program->Set("hidden_center", hidden_center ? kHiddenCenterUnit : kPlanesUnit);
  program->Set("blocker_taps", pcss.blocker_taps);
  program->Set("filter_taps", pcss.filter_taps);
  program->Set("is_gaussian", int(pcss.weights == FilterWeights::kGaussian));
  const double taps = double(pcss.blocker_taps) * pcss.blocker_taps + double(pcss.filter_taps) * pcss.filter_taps;
  RETURN_IF_ERROR(DrawTiles(draw, *program, receivers.width, receivers.height, tiles,
                            kResolveNanosecondsPerPixel + kResolveNanosecondsPerTap * taps));
  RETURN_IF_ERROR(draw.context->Check("pcss"));
  OcclusionSum result;
  result.sums = std::move(sums);
  result.count = tiles.size();
  return result;
}

std::vector<std::pair<std::string, std::string>> PcssMethod::DescribeOptions(const MethodOptions& options) const {
  const auto& pcss = std::get<PcssOptions>(options);
  return {{"map_size", std::to_string(pcss.map_size)},
          {"blocker_taps", std::to_string(pcss.blocker_taps)},
          {"filter_taps", std::to_string(pcss.filter_taps)},
          {"weights", WeightsName(pcss.weights)},
          {"skip", pcss.skips ? "true" : "false"}};
}

}  // namespace halfshade
