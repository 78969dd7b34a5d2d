#include "renderer/shadow/sssm/sssm.h"

#include <glad/gl.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <sstream>
#include <utility>

#include "renderer/gl/framebuffer.h"
#include "renderer/light/center_map.h"
#include "renderer/light/fullscreen.h"
#include "renderer/light/sub_lights.h"
#include "renderer/math/camera.h"
#include "renderer/math/light_frame.h"
#include "renderer/passes.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

// llvmpipe, two cores.
constexpr double kStartNanosecondsPerPixel = 90;
constexpr double kPassNanosecondsPerPixel = 90;
constexpr double kAddNanosecondsPerPixel = 30;
constexpr double kNanosecondsPerTap = 4;
constexpr double kNanosecondsPerSharedRow = 20;
constexpr int kLeastTaps = 300;  // 7 and 15 a side are 274: as dear either way; 11 and 21 are 562
constexpr int kRowsUnit = CenterMap::kFirstFreeUnit;
constexpr int kProofsUnit = CenterMap::kFirstFreeUnit + 1;
constexpr int kNearerRowsUnit = CenterMap::kFirstFreeUnit + 2;
constexpr int kHiddenUnit = kPlanesUnit + 1;  // of the pass that adds cells
constexpr int kBlockersUnit = kPlanesUnit + 2;

// A map for each cell of the light.
struct SssmData : LightData {
  std::vector<std::unique_ptr<CenterMap>> maps;
  uint64_t SizeBytes() const override {
    uint64_t bytes = 0;
    for (const auto& map : maps) bytes += map->SizeBytes();
    return bytes;
  }
  uint64_t MapsDrawn() const override {
    uint64_t drawn = 0;
    for (const auto& map : maps) drawn += map->MapsDrawn();
    return drawn;
  }
};

// The eye is in the light's plane, close to the light.
bool LooksFrom(const AreaLight& light, const Camera& camera) {
  const glm::dvec3 to_eye = camera.eye_ws - light.center_ws;
  const double near = 1e-6 * std::max(light.width_m, light.height_m);
  return !camera.is_orthographic && std::abs(glm::dot(to_eye, light.normal_ws)) <= near &&
         glm::length(to_eye) <= 16 * (light.width_m + light.height_m);
}

// Between pixels rows are interpolated.
absl::StatusOr<gl::Texture> MakeRows(const DrawContext& draw, const Receivers& receivers) {
  ASSIGN_OR_RETURN(gl::Texture rows,
                   gl::Texture::Create2D(*draw.context, GL_RGBA32F, receivers.width, receivers.height));
  const GladGLContext& gl = draw.context->gl();
  gl.TextureParameteri(rows.id(), GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  gl.TextureParameteri(rows.id(), GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  return rows;
}

// The passes of one cell.
class Passes {
 public:
  Passes(const DrawContext& draw, const CenterMap& map, const Receivers& receivers, const SssmOptions& options)
      : draw_(draw),
        map_(map),
        receivers_(receivers),
        options_(options),
        taps_{options.blocker_taps, options.filter_taps, options.weights} {}

  // Adds to the steps' times, one each.
  absl::StatusOr<CenterMap::Filtered> Draw(std::vector<PassReport>* steps) {
    ASSIGN_OR_RETURN(hidden_, gl::Texture::Create2D(*draw_.context, GL_R32F, receivers_.width, receivers_.height));
    if (receivers_.wants_blockers) {
      ASSIGN_OR_RETURN(blockers_, gl::Texture::Create2D(*draw_.context, GL_RG32F, receivers_.width, receivers_.height));
    }
    ASSIGN_OR_RETURN(blocker_rows_, MakeRows(draw_, receivers_));
    ASSIGN_OR_RETURN(nearer_rows_, MakeRows(draw_, receivers_));
    ASSIGN_OR_RETURN(blurred_rows_, MakeRows(draw_, receivers_));
    static constexpr std::pair<const char*, absl::Status (Passes::*)()> kSteps[] = {
        {"start", &Passes::Start},
        {"blocker_rows", &Passes::SumBlockers},
        {"blur_rows", &Passes::BlurRows},
        {"blur_columns", &Passes::BlurColumns}};
    steps->resize(std::size(kSteps));
    for (size_t i = 0; i < std::size(kSteps); ++i) {
      const auto& [name, draw] = kSteps[i];  // UBSan of GCC 12 takes an indexed member pointer for out of bounds
      PassReport& step = (*steps)[i];
      step.name = name;
      const Stopwatch stopwatch;
      RETURN_IF_ERROR((this->*draw)());
      RETURN_IF_ERROR(draw_.pacer->Finish());
      step.ms += stopwatch.Milliseconds();
      step.count += i == 0 ? 0 : i == 1 ? not_lit_.size() : undecided_.size();
    }
    return CenterMap::Filtered{std::move(hidden_), std::move(blockers_), undecided_.size()};
  }

 private:
  absl::StatusOr<gl::Program*> Use(const std::string& vertex, const std::string& fragment,
                                   const gl::Texture* hidden_center = nullptr) {
    ASSIGN_OR_RETURN(gl::Program * program, draw_.programs->Get(vertex, fragment));
    program->Use();
    map_.SetUniforms(draw_, *program, receivers_, taps_, hidden_center);
    const double aspect = double(receivers_.width) / receivers_.height;
    const glm::dmat3 light_from_ndc =
        MakeLightFrame(map_.cell()).light_from_world_rotation * RayFromNdc(receivers_.camera, aspect);
    program->Set("ndc_from_light", glm::mat3(glm::inverse(light_from_ndc)));
    program->Set("picture_size", glm::vec2(receivers_.width, receivers_.height));
    program->Set("is_relative", int(options_.thresholds == SssmThresholds::kRelative));
    return program;
  }

  absl::Status DrawOver(std::vector<const gl::Texture*> targets, gl::Program& program, const TileList& tiles,
                        double ns_per_pixel) {
    ASSIGN_OR_RETURN(const gl::Framebuffer framebuffer, gl::Framebuffer::Create(*draw_.context, targets));
    framebuffer.Bind();
    return DrawTiles(draw_, program, receivers_.width, receivers_.height, tiles, ns_per_pixel);
  }

  std::vector<const gl::Texture*> Results() const {
    return blockers_ ? std::vector<const gl::Texture*>{&hidden_, &blockers_} : std::vector{&hidden_};
  }

  absl::Status Start() {
    const GladGLContext& gl = draw_.context->gl();
    std::vector<const gl::Texture*> targets = {&hidden_, &blocker_rows_, &blurred_rows_};
    if (blockers_) targets.push_back(&blockers_);
    ASSIGN_OR_RETURN(const gl::Framebuffer framebuffer, gl::Framebuffer::Create(*draw_.context, targets));
    framebuffer.Bind();
    gl.ClearTexImage(nearer_rows_.id(), 0, GL_RGBA, GL_FLOAT, nullptr);  // rows that are not summed hold no blocker
    gl.Viewport(0, 0, receivers_.width, receivers_.height);
    gl.Disable(GL_DEPTH_TEST);
    gl.Disable(GL_BLEND);
    RETURN_IF_ERROR(Use("common/fullscreen.vert", "sssm/start.frag").status());
    RETURN_IF_ERROR(DrawFullscreen(draw_, receivers_.width, receivers_.height, kStartNanosecondsPerPixel));
    if (!options_.skips) {
      undecided_ = not_lit_ = ListTiles(receivers_.width, receivers_.height, {});
      return absl::OkStatus();
    }
    ASSIGN_OR_RETURN(const std::vector<float> proofs, ReadProofs(hidden_));
    const auto list = [&](auto is_wanted) {
      return ListProofs(proofs, receivers_.width, receivers_.height, is_wanted);
    };
    undecided_ = list([](float proof) { return proof < 0; });
    not_lit_ = undecided_.empty() ? TileList() : list([](float proof) { return proof != 0; });
    return absl::OkStatus();
  }

  absl::Status SumBlockers() {
    ASSIGN_OR_RETURN(gl::Program * program, Use("common/tiles.vert", "sssm/blocker_rows.frag"));
    return DrawOver({&blocker_rows_, &nearer_rows_}, *program, not_lit_,
                    kPassNanosecondsPerPixel + kNanosecondsPerTap * taps_.blocker);
  }

  absl::Status BlurRows() {
    ASSIGN_OR_RETURN(gl::Program * program, Use("common/tiles.vert", "sssm/blur_rows.frag"));
    blocker_rows_.Bind(kRowsUnit);
    hidden_.Bind(kProofsUnit);
    program->Set("blocker_rows", kRowsUnit);
    nearer_rows_.Bind(kNearerRowsUnit);
    program->Set("nearer_blocker_rows", kNearerRowsUnit);
    program->Set("proofs", kProofsUnit);
    program->Set("alpha", options_.alpha);
    return DrawOver({&blurred_rows_}, *program, undecided_,
                    kPassNanosecondsPerPixel + kNanosecondsPerTap * taps_.filter + RowsNanoseconds(taps_.blocker));
  }

  absl::Status BlurColumns() {
    gl::Texture hidden_center;
    if (!undecided_.empty()) {
      ASSIGN_OR_RETURN(hidden_center, map_.HiddenCenter(draw_, receivers_));
    }
    ASSIGN_OR_RETURN(gl::Program * program, Use("common/tiles.vert", "sssm/blur_columns.frag", &hidden_center));
    blurred_rows_.Bind(kRowsUnit);
    program->Set("blurred_rows", kRowsUnit);
    program->Set("beta", options_.beta);
    RETURN_IF_ERROR(
        DrawOver(Results(), *program, undecided_, kPassNanosecondsPerPixel + RowsNanoseconds(taps_.filter)));
    return draw_.context->Check("sssm");
  }

  // As if a quarter of the rows were not shared; none is where a threshold is 0.
  double RowsNanoseconds(int taps) const {
    const double own = options_.alpha == 0 || options_.beta == 0 ? 1 : 0.25;
    return taps * (kNanosecondsPerSharedRow + own * kNanosecondsPerTap * taps);
  }

  const DrawContext& draw_;
  const CenterMap& map_;
  const Receivers& receivers_;
  const SssmOptions& options_;
  const WindowTaps taps_;
  gl::Texture hidden_, blockers_, blocker_rows_, nearer_rows_, blurred_rows_;
  TileList not_lit_, undecided_;
};

// Of the cells so far, both RG32F and empty before the first: hidden shares and shares above the receiver's plane;
// what their blockers add up to, if wanted.
absl::Status AddCell(const DrawContext& draw, const Receivers& receivers, const AreaLight& light,
                     const CenterMap::Filtered& cell, gl::Texture* sums, gl::Texture* blockers) {
  const GladGLContext& gl = draw.context->gl();
  const bool is_first = !*sums;
  if (is_first) {
    ASSIGN_OR_RETURN(*sums, gl::Texture::Create2D(*draw.context, GL_RG32F, receivers.width, receivers.height));
    if (receivers.wants_blockers) {
      ASSIGN_OR_RETURN(*blockers, gl::Texture::Create2D(*draw.context, GL_RG32F, receivers.width, receivers.height));
    }
  }
  std::vector<const gl::Texture*> targets = {sums};
  if (receivers.wants_blockers) targets.push_back(blockers);
  ASSIGN_OR_RETURN(const gl::Framebuffer framebuffer, gl::Framebuffer::Create(*draw.context, targets));
  ASSIGN_OR_RETURN(gl::Program * program, draw.programs->Get("common/fullscreen.vert", "sssm/add_cell.frag"));
  framebuffer.Bind();
  gl.Viewport(0, 0, receivers.width, receivers.height);
  program->Use();
  SetReceivers(*program, receivers, light);
  cell.hidden.Bind(kHiddenUnit);
  program->Set("hidden", kHiddenUnit);
  if (receivers.wants_blockers) cell.blockers.Bind(kBlockersUnit);
  program->Set("blockers", receivers.wants_blockers ? kBlockersUnit : kHiddenUnit);
  program->Set("half_edges", glm::vec2(light.width_m / 2, light.height_m / 2));
  if (!is_first) {
    gl.Enable(GL_BLEND);
    gl.BlendFunc(GL_ONE, GL_ONE);
  }
  const absl::Status drawn = DrawFullscreen(draw, receivers.width, receivers.height, kAddNanosecondsPerPixel);
  gl.Disable(GL_BLEND);
  return drawn;
}

}  // namespace

MethodNeeds SssmMethod::Needs(const MethodOptions& options, const SceneFacts&) const {
  const auto& sssm = std::get<SssmOptions>(options);
  const int maps = sssm.sub_lights * sssm.sub_lights;
  return {.maps = uint32_t(maps),
          .map_size = sssm.map_size,
          .light_data_bytes = uint64_t(maps) * CenterMap::PredictedBytes(sssm.map_size)};
}

absl::StatusOr<std::unique_ptr<LightData>> SssmMethod::BuildLightData(const DrawContext& draw,
                                                                      const LightInputs& inputs,
                                                                      const MethodOptions& options) const {
  const auto& sssm = std::get<SssmOptions>(options);
  const SubLights cells = MakeSubLights(inputs.light, sssm.sub_lights);
  auto data = std::make_unique<SssmData>();
  for (size_t i = 0; i < cells.centers.size(); ++i) {
    ASSIGN_OR_RETURN(data->maps.emplace_back(), CenterMap::Create(draw, inputs.occluders, inputs.light,
                                                                  SubLight(inputs.light, cells, i), sssm.map_size));
  }
  return data;
}

std::string SssmMethod::LightDataOptions(const MethodOptions& options) const {
  const auto& sssm = std::get<SssmOptions>(options);
  return "map_size=" + std::to_string(sssm.map_size) + " sub_lights=" + std::to_string(sssm.sub_lights);
}

absl::StatusOr<OcclusionSum> SssmMethod::ResolveOcclusion(const DrawContext& draw, const LightData& light_data,
                                                          const Receivers& receivers,
                                                          const MethodOptions& options) const {
  const auto& data = static_cast<const SssmData&>(light_data);
  const auto& sssm = std::get<SssmOptions>(options);
  // Points have no neighbours; seen from the light, as in a soft shadow map, what stands at the place of a row is there
  // at any depth; and of few taps finding neighbours costs more than it saves.
  const bool shares_nothing = receivers.points != nullptr || LooksFrom(data.maps[0]->cell(), receivers.camera) ||
                              (sssm.alpha == 0 && sssm.beta == 0) ||
                              sssm.blocker_taps * sssm.blocker_taps + sssm.filter_taps * sssm.filter_taps < kLeastTaps;
  OcclusionSum result;
  gl::Texture sums;
  for (const auto& map : data.maps) {
    absl::StatusOr<CenterMap::Filtered> cell =
        shares_nothing ? map->Filter(draw, receivers, {sssm.blocker_taps, sssm.filter_taps, sssm.weights}, sssm.skips)
                       : Passes(draw, *map, receivers, sssm).Draw(&result.steps);
    RETURN_IF_ERROR(cell.status());
    result.count += cell->tiles_drawn;
    if (data.maps.size() == 1) {
      result.sums = std::move(cell->hidden);
      result.blockers = std::move(cell->blockers);
      return result;
    }
    RETURN_IF_ERROR(AddCell(draw, receivers, map->cell(), *cell, &sums, &result.blockers));
  }
  result.sums = std::move(sums);
  result.full_sum = 0;
  return result;
}

std::vector<std::pair<std::string, std::string>> SssmMethod::DescribeOptions(const MethodOptions& options) const {
  const auto& sssm = std::get<SssmOptions>(options);
  std::ostringstream alpha, beta;
  alpha << sssm.alpha;
  beta << sssm.beta;
  return {{"map_size", std::to_string(sssm.map_size)},
          {"blocker_taps", std::to_string(sssm.blocker_taps)},
          {"filter_taps", std::to_string(sssm.filter_taps)},
          {"weights", WeightsName(sssm.weights)},
          {"skip", sssm.skips ? "true" : "false"},
          {"alpha", alpha.str()},
          {"beta", beta.str()},
          {"thresholds", sssm.thresholds == SssmThresholds::kRelative ? "RELATIVE" : "ABSOLUTE"},
          {"sub_lights", std::to_string(sssm.sub_lights)}};
}

}  // namespace halfshade
