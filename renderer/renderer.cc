#include "renderer/renderer.h"

#include <glad/gl.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>

#include "renderer/gl/draw_context.h"
#include "renderer/light/occluders_on_context.h"
#include "renderer/plan/frame_plan.h"
#include "renderer/scene/pose.h"
#include "renderer/scene/scene_on_context.h"
#include "renderer/shade/gbuffer.h"
#include "renderer/shade/shade.h"
#include "renderer/shadow/finish_visibility.h"
#include "renderer/shadow/shadow_method.h"
#include "renderer/status.h"
#include "renderer/warm_up.h"

namespace halfshade {
namespace {

// Maps of one light beyond this are drawn again at every resolve instead of being kept.
constexpr uint64_t kMaxLightDataBytes = 256ull << 20;
// Visibility nearer to 0 or 1 than this is umbra or light.
constexpr float kPenumbraMargin = 1.0f / 512;

class Stopwatch {
 public:
  double Milliseconds() const {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start_).count();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

// One frame on its way through the house.
class Frame {
 public:
  Frame(const DrawContext& draw, const LtcTextures& ltc, const FlatScene& scene, const RenderRequest& request)
      : draw_(draw), ltc_(ltc), scene_(scene), request_(request), method_(FindMethod(request.method)) {}

  absl::Status Draw(SceneOnContext& on_context, const ImageDecoder& decoder) {
    ASSIGN_OR_RETURN(pose_, BuildPose(scene_, request_.scene_index));
    plan_ = PlanFrame(scene_, pose_, request_);
    DescribePlan();
    if (plan_.needs_textures) {
      const uint64_t before = on_context.decoded_images();
      RETURN_IF_ERROR(Timed("textures", &report_.upload_ms,
                            [&] { return on_context.NeedTextures(draw_, scene_, decoder, plan_.needs_shading); }));
      report_.passes.back().count = on_context.decoded_images() - before;
    }
    RETURN_IF_ERROR(Timed("gbuffer", &report_.shade_ms, [&]() -> absl::Status {
      ASSIGN_OR_RETURN(gbuffer_, DrawGBuffer(draw_, scene_, on_context, plan_.draws_gbuffer ? pose_ : Pose{}, request_,
                                             plan_.needs_shading));
      report_.passes.back().count = gbuffer_.triangles_drawn;
      return absl::OkStatus();
    }));
    receivers_ = {&gbuffer_.planes, request_.camera, request_.width, request_.height};
    if (plan_.needs_shading) {
      RETURN_IF_ERROR(Timed("ambient", &report_.shade_ms, [&]() -> absl::Status {
        ASSIGN_OR_RETURN(frame_, StartFrame(draw_, ltc_, gbuffer_, receivers_, request_));
        return absl::OkStatus();
      }));
    }
    for (size_t i = 0; i < request_.lights.size(); ++i) RETURN_IF_ERROR(DrawLight(i, on_context));
    FinishShares();
    return absl::OkStatus();
  }

  // In the order of RenderRequest::outputs.
  absl::StatusOr<RenderResult> TakeResult() {
    RenderResult result;
    for (const OutputKind kind : request_.outputs) {
      if (kind == OutputKind::kVisibility) {
        result.images.push_back({kind, visibility_});
      } else {
        Image image(request_.width, request_.height, 4);
        RETURN_IF_ERROR(Timed("readback", &report_.readback_ms, [&] { return ReadBack(frame_, image); }));
        result.images.push_back({kind, std::move(image)});
      }
    }
    result.report = std::move(report_);
    return result;
  }

 private:
  void DescribePlan() {
    report_.method = method_.name;
    report_.options = method_.method->DescribeOptions(request_.method);
    report_.reason = request_.method_reason;
    if (!plan_.draws_gbuffer) Skip("gbuffer", plan_.gbuffer_reason);
    if (!plan_.needs_shading) Skip("shade", "only visibility is asked");
    if (!plan_.needs_textures) Skip("textures", "no output needs them");
    if (Wants(OutputKind::kVisibility)) {
      visibility_ = Image(request_.width, request_.height, int(request_.lights.size()));
    }
  }

  bool Wants(OutputKind kind) const {
    return std::find(request_.outputs.begin(), request_.outputs.end(), kind) != request_.outputs.end();
  }

  void Skip(const std::string& name, const std::string& reason) {
    report_.passes.push_back({.name = name, .is_skipped = true, .reason = reason});
  }

  // Runs one pass, waits for it, and books its wall time.
  template <typename Pass>
  absl::Status Timed(const std::string& name, double* stage_ms, Pass pass) {
    const Stopwatch stopwatch;
    report_.passes.push_back({.name = name});
    const size_t index = report_.passes.size() - 1;
    RETURN_IF_ERROR(pass());
    RETURN_IF_ERROR(draw_.pacer->Finish());
    report_.passes[index].ms = stopwatch.Milliseconds();
    *stage_ms += report_.passes[index].ms;
    return absl::OkStatus();
  }

  absl::Status DrawLight(size_t index, const SceneOnContext& on_context) {
    const AreaLight& light = request_.lights[index];
    const LightPlan& plan = plan_.lights[index];
    const std::string name = "light[" + std::to_string(index) + "]/";
    if (plan.outcome != LightOutcome::kCompute) Skip(name + method_.name, plan.reason);
    if (plan.outcome == LightOutcome::kSkipped) return absl::OkStatus();
    std::unique_ptr<OccludersOnContext> occluders;
    std::unique_ptr<LightData> data;
    OcclusionSum occlusion;
    const bool computes = plan.outcome == LightOutcome::kCompute;
    if (computes) {
      RETURN_IF_ERROR(Timed(name + "light_data", &report_.light_ms, [&]() -> absl::Status {
        ASSIGN_OR_RETURN(occluders, OccludersOnContext::Create(draw_, scene_, on_context,
                                                               BuildLightSpaceOccluders(scene_, pose_, light)));
        const LightInputs inputs = {occluders.get(), light, request_.seed + uint32_t(index), kMaxLightDataBytes};
        ASSIGN_OR_RETURN(data, method_.method->BuildLightData(draw_, inputs, request_.method));
        report_.passes.back().count = data->MapsDrawn();
        return absl::OkStatus();
      }));
      report_.caches.push_back({.name = name + "light_data", .misses = 1, .bytes = data->SizeBytes()});
    }
    gl::Texture visibility;
    RETURN_IF_ERROR(Timed(name + "resolve", &report_.resolve_ms, [&]() -> absl::Status {
      if (computes) {
        ASSIGN_OR_RETURN(occlusion, method_.method->ResolveOcclusion(draw_, *data, receivers_, request_.method));
      }
      ASSIGN_OR_RETURN(visibility, FinishVisibility(draw_, computes ? &occlusion : nullptr, receivers_, light));
      return absl::OkStatus();
    }));
    RETURN_IF_ERROR(Timed(name + "readback", &report_.readback_ms,
                          [&] { return Collect(index, visibility, computes ? &occlusion : nullptr); }));
    if (plan_.needs_shading) {
      RETURN_IF_ERROR(Timed(name + "shade", &report_.shade_ms, [&] {
        return AddLight(draw_, ltc_, gbuffer_, receivers_, light, visibility, request_, frame_);
      }));
    }
    return absl::OkStatus();
  }

  absl::Status ReadBack(const gl::Texture& texture, Image& image) {
    return texture.ReadFloats(image.data(), image.size());
  }

  // Visibility to memory: the image, the shares, the largest sum. A NaN out of a pass is our bug.
  absl::Status Collect(size_t light, const gl::Texture& texture, const OcclusionSum* occlusion) {
    Image pairs(request_.width, request_.height, 2);
    RETURN_IF_ERROR(ReadBack(texture, pairs));
    const size_t pixels = size_t(request_.width) * request_.height;
    const size_t channels = request_.lights.size();
    const bool wants_image = visibility_.size() > 0;
    for (size_t i = 0; i < pixels; ++i) {
      const float v = pairs.data()[2 * i];
      const float share = pairs.data()[2 * i + 1];
      if (!(v >= 0 && v <= 1)) {
        return absl::InternalError(method_.name + ": visibility " + std::to_string(v) + " at pixel " +
                                   std::to_string(i % request_.width) + "," + std::to_string(i / request_.width));
      }
      if (wants_image) visibility_.data()[i * channels + light] = v;
      if (share <= 0) continue;
      ++(v <= kPenumbraMargin ? umbra_ : v < 1 - kPenumbraMargin ? penumbra_ : lit_);
    }
    if (occlusion != nullptr) {
      Image sums(request_.width, request_.height, 1);
      RETURN_IF_ERROR(ReadBack(occlusion->sums, sums));
      const float largest = *std::max_element(sums.data(), sums.data() + sums.size());
      report_.max_sum = std::max(report_.max_sum, double(largest / occlusion->full_sum));
    }
    return absl::OkStatus();
  }

  void FinishShares() {
    const double total = double(umbra_ + penumbra_ + lit_);
    if (total == 0) return;
    report_.share_umbra = double(umbra_) / total;
    report_.share_penumbra = double(penumbra_) / total;
    report_.share_lit = double(lit_) / total;
  }

  const DrawContext& draw_;
  const LtcTextures& ltc_;
  const FlatScene& scene_;
  const RenderRequest& request_;
  const RegisteredMethod& method_;
  Pose pose_;
  FramePlan plan_;
  GBuffer gbuffer_;
  Receivers receivers_;
  gl::Texture frame_;
  Image visibility_;
  uint64_t umbra_ = 0, penumbra_ = 0, lit_ = 0;
  RenderReport report_;
};

class ContextRenderer : public Renderer {
 public:
  ContextRenderer(gl::Context* context, LtcTextures ltc, ImageDecoder decoder)
      : context_(context), programs_(context), ltc_(std::move(ltc)), decoder_(std::move(decoder)) {}

  absl::StatusOr<RenderResult> Render(const std::string& scene_name, const FlatScene& scene,
                                      const RenderRequest& request, const StopCheck& stop) override {
    gl::Pacer pacer(*context_, stop);
    const DrawContext draw = {context_, &programs_, &pacer};
    const Stopwatch stopwatch;
    auto [entry, is_new] = scenes_.try_emplace(scene_name);
    if (is_new) {
      auto uploaded = SceneOnContext::Create(draw, scene);
      if (!uploaded.ok()) {
        scenes_.erase(entry);
        return uploaded.status();
      }
      entry->second = *std::move(uploaded);
    }
    const double upload_ms = stopwatch.Milliseconds();
    Frame frame(draw, ltc_, scene, request);
    RETURN_IF_ERROR(frame.Draw(*entry->second, decoder_));
    ASSIGN_OR_RETURN(RenderResult result, frame.TakeResult());
    result.report.upload_ms += upload_ms;
    result.report.caches.push_back({.name = "scene_on_context",
                                    .hits = uint64_t(!is_new),
                                    .misses = uint64_t(is_new),
                                    .bytes = entry->second->SizeBytes()});
    return result;
  }

  void SetDecoder(ImageDecoder decoder) { decoder_ = std::move(decoder); }

  void ForgetScene(const std::string& scene_name) override { scenes_.erase(scene_name); }

 private:
  gl::Context* context_;
  gl::ProgramCache programs_;
  LtcTextures ltc_;
  ImageDecoder decoder_;
  std::map<std::string, std::unique_ptr<SceneOnContext>> scenes_;
};

}  // namespace

absl::StatusOr<std::unique_ptr<Renderer>> Renderer::Create(gl::Context* context, ImageDecoder decoder) {
  ASSIGN_OR_RETURN(LtcTextures ltc, LtcTextures::Create(*context));
  auto renderer = std::make_unique<ContextRenderer>(context, std::move(ltc), WarmUpTexel);
  RETURN_IF_ERROR(WarmUp(*renderer));
  renderer->SetDecoder(std::move(decoder));
  return renderer;
}

}  // namespace halfshade
