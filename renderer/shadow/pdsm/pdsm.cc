#include "renderer/shadow/pdsm/pdsm.h"

#include <absl/strings/str_cat.h>
#include <glad/gl.h>

#include <algorithm>
#include <optional>

#include "renderer/gl/framebuffer.h"
#include "renderer/gl/handles.h"
#include "renderer/gl/texture.h"
#include "renderer/light/fullscreen.h"
#include "renderer/light/sample_maps.h"
#include "renderer/light/sample_points.h"
#include "renderer/shadow/pdsm/draw_sample_maps.h"
#include "renderer/shadow/pdsm/event_builder.h"
#include "renderer/shadow/pdsm/slice_builder.h"
#include "renderer/shadow/pdsm/soft_events.h"
#include "renderer/shadow/pdsm/stored_functions.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

// llvmpipe, two cores.
constexpr double kResolveNanosecondsPerPixel = 60;
constexpr double kResolveNanosecondsPerFunction = 20;
constexpr double kResolveNanosecondsPerSample = 2;
constexpr int kVolumeUnit = kPlanesUnit + 1;
constexpr int kSideHiddenUnit = kPlanesUnit + 2;
constexpr GLuint kPointsBinding = 1, kFirstBinding = 2, kVerticesBinding = 3;
constexpr int kSlices = 64;
constexpr const char* kConstructionNames[] = {"TRAVERSAL", "SCATTER", "SLICES"};
constexpr const char* kLayoutNames[] = {"INDEXED", "VOLUME"};

struct PdsmData : LightData {
  AreaLight light;
  PdsmConstruction construction = PdsmConstruction::kSlices;
  PdsmLayout layout = PdsmLayout::kVolume;
  pdsm::Grid grid;
  int point_count = 0;
  bool is_loaded = false;      // from the store: no maps were drawn for the functions
  gl::Buffer points;           // vec2 each, light frame
  gl::Buffer first, vertices;  // PdsmLayout::kIndexed
  size_t vertex_count = 0;
  gl::Texture volume;          // PdsmLayout::kVolume
  pdsm::SliceSpacing spacing;  // of it
  uint64_t function_bytes = 0;
  std::unique_ptr<SampleMaps> side_maps;  // beyond the front window; null: nothing is there
  uint64_t SizeBytes() const override {
    return function_bytes + point_count * sizeof(glm::vec2) + (side_maps == nullptr ? 0 : side_maps->SizeBytes());
  }
  uint64_t MapsDrawn() const override {
    return (is_loaded ? 0 : point_count) + (side_maps == nullptr ? 0 : side_maps->MapsDrawn());
  }
  uint64_t MapsRedrawn() const override { return side_maps == nullptr ? 0 : side_maps->MapsRedrawn(); }
  std::vector<std::pair<std::string, std::string>> ChosenOptions() const override {
    return {{"construction", kConstructionNames[int(construction)]}, {"layout", kLayoutNames[int(layout)]}};
  }
};

absl::Status StoreFunctions(const DrawContext& draw, const pdsm::AttenuationFunctions& functions, PdsmData& data) {
  ASSIGN_OR_RETURN(data.first, gl::Buffer::Create(*draw.context, functions.first));
  // A buffer is never empty.
  ASSIGN_OR_RETURN(data.vertices, functions.vertices.empty()
                                      ? gl::Buffer::Create(*draw.context, std::vector<pdsm::Vertex>(1))
                                      : gl::Buffer::Create(*draw.context, functions.vertices));
  data.vertex_count = functions.vertices.size();
  data.function_bytes = functions.SizeBytes();
  return absl::OkStatus();
}

absl::Status StoreVolume(const DrawContext& draw, const pdsm::SliceVolume& volume, PdsmData& data) {
  const GladGLContext& gl = draw.context->gl();
  const int slices = int(volume.depths.size());
  ASSIGN_OR_RETURN(data.volume, gl::Texture::Create2DArray(*draw.context, GL_RG16UI, volume.size, volume.size, slices));
  gl.PixelStorei(GL_UNPACK_ALIGNMENT, 4);
  gl.TextureSubImage3D(data.volume.id(), 0, 0, 0, 0, volume.size, volume.size, slices, GL_RG_INTEGER, GL_UNSIGNED_SHORT,
                       volume.counts.data());
  data.function_bytes = data.volume.SizeBytes();
  return draw.context->Check("pdsm/volume");
}

std::vector<pdsm::Stratum> StrataOf(const AreaLight& light, int k) {
  const bool is_point = light.width_m == 0 && light.height_m == 0;
  return pdsm::Strata(glm::dvec2(light.width_m, light.height_m) / 2.0, is_point ? 1 : k);
}

std::vector<glm::dvec2> PointsOf(const LightInputs& inputs, const PdsmOptions& options) {
  if (!options.has_soft_events) return SobolLightPoints(inputs.light, options.k, inputs.seed);
  std::vector<glm::dvec2> points;
  for (const pdsm::Stratum& stratum : StrataOf(inputs.light, options.k)) points.push_back(stratum.middle);
  return points;
}

// Of maps that are drawn now.
absl::Status Build(const DrawContext& draw, const OccludersOnContext& occluders, const std::vector<glm::dvec2>& points,
                   const PdsmOptions& options, PdsmData& data) {
  const auto add_maps = [&](auto&& add) { return pdsm::DrawSampleMaps(draw, occluders, data.grid, points, add); };
  if (data.construction == PdsmConstruction::kSlices) {
    pdsm::SliceBuilder builder(data.grid, data.spacing.Depths());
    RETURN_IF_ERROR(add_maps([&](const pdsm::SampleMap& map) {
      builder.Add(map);
      return absl::OkStatus();
    }));
    return StoreVolume(draw, builder.Finish(), data);
  }
  const pdsm::Finishing finishing = {
      .eps = options.eps, .is_surface_only = options.is_surface_only, .stop = [&draw] { return draw.pacer->Finish(); }};
  pdsm::EventBuilder::Result result;
  if (options.has_soft_events) {
    const std::vector<pdsm::Stratum> strata = StrataOf(data.light, options.k);
    pdsm::SoftEventBuilder builder(data.grid);
    size_t next = 0;
    RETURN_IF_ERROR(add_maps([&](const pdsm::SampleMap& map) { return builder.Add(map, strata[next++]); }));
    ASSIGN_OR_RETURN(result, builder.Finish(finishing));
  } else {
    const bool traverses = data.construction == PdsmConstruction::kTraversal;
    pdsm::EventBuilder builder(data.grid, traverses ? pdsm::EventForm::kTraversal : pdsm::EventForm::kScatter);
    RETURN_IF_ERROR(add_maps([&](const pdsm::SampleMap& map) { return builder.Add(map); }));
    ASSIGN_OR_RETURN(result, builder.Finish(finishing));
  }
  return StoreFunctions(draw, result.functions, data);
}

// The functions' readers, all but the functions.
absl::StatusOr<std::unique_ptr<PdsmData>> Prepare(const DrawContext& draw, const LightInputs& inputs,
                                                  const PdsmOptions& options, const std::vector<glm::dvec2>& points) {
  auto data = std::make_unique<PdsmData>();
  data->light = inputs.light;
  data->point_count = int(points.size());
  ASSIGN_OR_RETURN(data->points,
                   gl::Buffer::Create(*draw.context, std::vector<glm::vec2>(points.begin(), points.end())));
  const OccluderHull& hull = inputs.occluders->hull();
  data->grid = pdsm::GridOf(hull, glm::dvec2(inputs.light.width_m, inputs.light.height_m) / 2.0, points,
                            options.map_size, options.pdsm_size);
  data->spacing = pdsm::SpaceSlices(kSlices, data->grid.z_near / hull.z_far());
  data->construction = options.construction;
  data->layout = options.layout;
  // Occluders beside the light stand at d = 1, and a whole room in the few slices next to 0: only functions hold both.
  if (hull.NeedsSideWindows() && options.layout == PdsmLayout::kVolume) {
    data->construction = PdsmConstruction::kScatter;
    data->layout = PdsmLayout::kIndexed;
  }
  return data;
}

absl::Status AddSides(const DrawContext& draw, const LightInputs& inputs, const PdsmOptions& options,
                      const std::vector<glm::dvec2>& points, PdsmData& data) {
  if (!inputs.occluders->hull().NeedsSideWindows()) return absl::OkStatus();
  const uint64_t left = inputs.max_light_data_bytes - std::min(inputs.max_light_data_bytes, data.SizeBytes());
  ASSIGN_OR_RETURN(data.side_maps, SampleMaps::Create(draw, inputs.occluders, inputs.light, points, options.map_size,
                                                      left, SampleMaps::Sides::kAllButFront));
  return absl::OkStatus();
}

int FilterWidth(PdsmFilter filter) {
  switch (filter) {
    case PdsmFilter::kNearest:
      return 0;
    case PdsmFilter::kBilinear:
      return 1;
    case PdsmFilter::kWide2:
      return 2;
    case PdsmFilter::kWide3:
      return 3;
  }
  return 1;
}

constexpr const char* kFilterNames[] = {"NEAREST", "BILINEAR", "WIDE2", "WIDE3"};

}  // namespace

MethodNeeds PdsmMethod::Needs(const MethodOptions& options, const SceneFacts&) const {
  const auto& pdsm = std::get<PdsmOptions>(options);
  // Of 60 spheres, k = 64, eps = .01 an indexed function has 29 vertices.
  constexpr uint64_t kVerticesARay = 30;
  const uint64_t bytes_a_ray = pdsm.layout == PdsmLayout::kVolume
                                   ? kSlices * sizeof(pdsm::SliceCounts)
                                   : sizeof(uint32_t) + kVerticesARay * sizeof(pdsm::Vertex);
  return {.maps = uint32_t(pdsm.k),
          .map_size = pdsm.map_size,
          .light_data_bytes = bytes_a_ray * pdsm.pdsm_size * pdsm.pdsm_size};
}

absl::StatusOr<std::unique_ptr<LightData>> PdsmMethod::BuildLightData(const DrawContext& draw,
                                                                      const LightInputs& inputs,
                                                                      const MethodOptions& options) const {
  const auto& pdsm = std::get<PdsmOptions>(options);
  const std::vector<glm::dvec2> points = PointsOf(inputs, pdsm);
  ASSIGN_OR_RETURN(std::unique_ptr<PdsmData> data, Prepare(draw, inputs, pdsm, points));
  RETURN_IF_ERROR(Build(draw, *inputs.occluders, points, pdsm, *data));
  RETURN_IF_ERROR(AddSides(draw, inputs, pdsm, points, *data));
  return data;
}

absl::StatusOr<std::string> PdsmMethod::SaveLightData(const DrawContext& draw, const LightData& light_data) const {
  const auto& data = static_cast<const PdsmData&>(light_data);
  const GladGLContext& gl = draw.context->gl();
  pdsm::StoredFunctions stored;
  stored.grid = data.grid;
  if (data.layout == PdsmLayout::kVolume) {
    pdsm::SliceVolume volume;
    volume.size = data.grid.size;
    volume.maps = data.point_count;
    volume.depths = data.spacing.Depths();
    volume.counts.resize(kSlices * data.grid.RayCount());
    gl.PixelStorei(GL_PACK_ALIGNMENT, 4);
    gl.GetTextureImage(data.volume.id(), 0, GL_RG_INTEGER, GL_UNSIGNED_SHORT,
                       GLsizei(volume.counts.size() * sizeof(pdsm::SliceCounts)), volume.counts.data());
    stored.functions = std::move(volume);
  } else {
    pdsm::AttenuationFunctions functions;
    functions.size = data.grid.size;
    functions.first.resize(data.grid.RayCount() + 1);
    functions.vertices.resize(data.vertex_count);
    gl.GetNamedBufferSubData(data.first.id(), 0, GLsizeiptr(functions.first.size() * sizeof(uint32_t)),
                             functions.first.data());
    gl.GetNamedBufferSubData(data.vertices.id(), 0, GLsizeiptr(functions.vertices.size() * sizeof(pdsm::Vertex)),
                             functions.vertices.data());
    stored.functions = std::move(functions);
  }
  RETURN_IF_ERROR(draw.context->Check("pdsm/save"));
  return pdsm::Store(stored);
}

absl::StatusOr<std::unique_ptr<LightData>> PdsmMethod::LoadLightData(const DrawContext& draw, const LightInputs& inputs,
                                                                     const MethodOptions& options,
                                                                     const std::string& bytes) const {
  const auto& pdsm = std::get<PdsmOptions>(options);
  const std::vector<glm::dvec2> points = PointsOf(inputs, pdsm);
  ASSIGN_OR_RETURN(std::unique_ptr<PdsmData> data, Prepare(draw, inputs, pdsm, points));
  const std::optional<pdsm::StoredFunctions> stored = pdsm::Restore(bytes);
  // Another light's or scene's are on another grid.
  if (!stored || stored->grid != data->grid) return std::unique_ptr<LightData>();
  const auto* volume = std::get_if<pdsm::SliceVolume>(&stored->functions);
  if (volume != nullptr) {
    if (data->layout != PdsmLayout::kVolume || volume->maps != data->point_count ||
        volume->depths != data->spacing.Depths()) {
      return std::unique_ptr<LightData>();
    }
    RETURN_IF_ERROR(StoreVolume(draw, *volume, *data));
  } else {
    if (data->layout != PdsmLayout::kIndexed) return std::unique_ptr<LightData>();
    RETURN_IF_ERROR(StoreFunctions(draw, std::get<pdsm::AttenuationFunctions>(stored->functions), *data));
  }
  data->is_loaded = true;
  RETURN_IF_ERROR(AddSides(draw, inputs, pdsm, points, *data));
  return data;
}

std::string PdsmMethod::LightDataOptions(const MethodOptions& options) const {
  std::string text;
  for (const auto& [name, value] : DescribeOptions(options)) {
    if (name != "filter") text += name + "=" + value + " ";
  }
  return text;
}

absl::StatusOr<OcclusionSum> PdsmMethod::ResolveOcclusion(const DrawContext& draw, const LightData& light_data,
                                                          const Receivers& receivers,
                                                          const MethodOptions& options) const {
  const auto& data = static_cast<const PdsmData&>(light_data);
  const auto& pdsm = std::get<PdsmOptions>(options);
  const GladGLContext& gl = draw.context->gl();
  gl::Texture side_hidden;
  if (data.side_maps != nullptr) {
    ASSIGN_OR_RETURN(side_hidden, data.side_maps->CountHidden(draw, receivers));
  }
  ASSIGN_OR_RETURN(gl::Texture sums, gl::Texture::Create2D(*draw.context, GL_RG32F, receivers.width, receivers.height));
  ASSIGN_OR_RETURN(const gl::Framebuffer framebuffer, gl::Framebuffer::Create(*draw.context, {&sums}));
  const bool is_volume = data.layout == PdsmLayout::kVolume;
  ASSIGN_OR_RETURN(gl::Program * program, draw.programs->Get("common/fullscreen.vert", "pdsm/resolve.frag",
                                                             {is_volume ? "HAS_VOLUME" : "HAS_FUNCTIONS"}));
  framebuffer.Bind();
  gl.Viewport(0, 0, receivers.width, receivers.height);
  gl.Disable(GL_DEPTH_TEST);
  gl.Disable(GL_BLEND);
  program->Use();
  SetReceivers(*program, receivers, data.light);
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, kPointsBinding, data.points.id());
  if (is_volume) {
    data.volume.Bind(kVolumeUnit);
  } else {
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, kFirstBinding, data.first.id());
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, kVerticesBinding, data.vertices.id());
  }
  if (side_hidden) side_hidden.Bind(kSideHiddenUnit);
  const int width = FilterWidth(pdsm.filter);
  program->Set("volume", kVolumeUnit);
  program->Set("slices", data.spacing.count);
  program->Set("slices_behind", data.spacing.behind);
  program->Set("occluders_from", data.spacing.occluders_from);
  program->Set("side_hidden", side_hidden ? kSideHiddenUnit : kPlanesUnit);
  program->Set("has_sides", int(bool(side_hidden)));
  program->Set("pdsm_size", data.grid.size);
  program->Set("first_center", glm::vec2(data.grid.corner + 0.5 * data.grid.texel));
  program->Set("slope_per_ray", glm::vec2(data.grid.texel));
  program->Set("slope_per_texel", glm::vec2(data.grid.MapTexel()));
  program->Set("z_near", float(data.grid.z_near));
  program->Set("half_edges", glm::vec2(data.light.width_m / 2, data.light.height_m / 2));
  program->Set("point_count", data.point_count);
  program->Set("are_cells", int(pdsm.has_soft_events));
  program->Set("filter_width", width);
  const double functions = (width + 1) * (width + 1);
  RETURN_IF_ERROR(DrawFullscreen(draw, receivers.width, receivers.height,
                                 kResolveNanosecondsPerPixel + kResolveNanosecondsPerFunction * functions +
                                     kResolveNanosecondsPerSample * data.point_count));
  RETURN_IF_ERROR(draw.context->Check("pdsm"));
  OcclusionSum result;
  result.sums = std::move(sums);
  result.full_sum = 0;
  return result;
}

std::vector<std::pair<std::string, std::string>> PdsmMethod::DescribeOptions(const MethodOptions& options) const {
  const auto& pdsm = std::get<PdsmOptions>(options);
  const bool is_chosen = pdsm.layout == PdsmLayout::kVolume;  // by where the occluders stand (BuildLightData)
  return {{"k", std::to_string(pdsm.k)},
          {"map_size", std::to_string(pdsm.map_size)},
          {"pdsm_size", std::to_string(pdsm.pdsm_size)},
          {"eps", absl::StrCat(pdsm.eps)},
          {"construction", is_chosen ? kChosen : kConstructionNames[int(pdsm.construction)]},
          {"layout", is_chosen ? kChosen : kLayoutNames[int(pdsm.layout)]},
          {"filter", kFilterNames[int(pdsm.filter)]},
          {"soft_events", pdsm.has_soft_events ? "true" : "false"},
          {"surface_only", pdsm.is_surface_only ? "true" : "false"}};
}

}  // namespace halfshade
