#include "renderer/frame.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "renderer/budget.h"
#include "renderer/certify.h"
#include "renderer/light/cpu_receivers.h"
#include "renderer/light/picture_error.h"
#include "renderer/light_layers.h"
#include "renderer/math/camera.h"
#include "renderer/passes.h"
#include "renderer/plan/choose_method.h"
#include "renderer/plan/cost_model.h"
#include "renderer/scene/pose.h"
#include "renderer/scene/scene_on_context.h"
#include "renderer/shade/data_image.h"
#include "renderer/shade/finish_frame.h"
#include "renderer/shade/fog.h"
#include "renderer/shade/gbuffer.h"
#include "renderer/shadow/finish_visibility.h"
#include "renderer/shadow/shadow_method.h"
#include "renderer/soft_shadow_map.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

class Frame {
 public:
  Frame(const DrawContext& draw, const LtcTextures& ltc, const std::string& scene_name, const FlatScene& scene,
        const RenderRequest& request, const ImageDecoder& decoder, LightCaches* caches,
        gl::ObjectCache<SeenView>* views)
      : draw_(draw),
        ltc_(ltc),
        decoder_(decoder),
        scene_name_(scene_name),
        scene_(scene),
        request_(request),
        camera_(request.camera),
        method_(FindMethod(request.method)),
        caches_(caches),
        views_(views) {}

  absl::Status Draw(SceneOnContext& on_context) {
    RETURN_IF_ERROR(CheckOutputs(request_, method_));
    ASSIGN_OR_RETURN(pose_, BuildPose(scene_, request_.scene_index, request_.node_overrides));
    ASSIGN_OR_RETURN(apart_, SetMovedApart(scene_, pose_, request_));
    plan_ = PlanFrame(scene_, pose_, request_);
    report_ = DescribePlan(plan_, request_, method_);
    for (const OutputKind kind : {OutputKind::kVisibility, OutputKind::kPenumbraWidth}) {
      if (Wants(kind)) images_[kind] = Image(request_.width, request_.height, int(request_.lights.size()));
    }
    if (plan_.needs_textures) {
      const uint64_t before = on_context.decoded_images();
      RETURN_IF_ERROR(Timed("textures", &report_.upload_ms,
                            [&] { return on_context.NeedTextures(draw_, scene_, decoder_, plan_.needs_materials); }));
      report_.passes.back().count = on_context.decoded_images() - before;
    }
    for (const ViewPlan& view : plan_.views) RETURN_IF_ERROR(DrawView(view, on_context));
    if (Wants(OutputKind::kSoftShadowMap)) RETURN_IF_ERROR(AddSoftShadowMap(on_context));
    if (plan_.needs_shading) {
      RETURN_IF_ERROR(Timed("readback", &report_.readback_ms, [&] {
        return ReadBack(FrameSamples::AreNeeded(request_) ? samples_.Take() : std::move(frame_), OutputKind::kFrame, 4);
      }));
    }
    FinishShares();
    if (predicted_count_ > 0) {
      report_.error.predicted = ErrorOfTold(request_.method) * predicted_sum_ / double(predicted_count_);
    }
    if (request_.certify) ReportCertificate(EstimateError(certified_, request_.seed), report_);
    return absl::OkStatus();
  }

  // In the order of RenderRequest::outputs.
  RenderResult TakeResult() {
    RenderResult result;
    for (auto output = request_.outputs.begin(); output != request_.outputs.end(); ++output) {
      const OutputKind kind = *output;
      const bool is_asked_again = std::find(output + 1, request_.outputs.end(), kind) != request_.outputs.end();
      result.images.push_back({kind, is_asked_again ? images_[kind] : std::move(images_[kind])});
      if (kind == OutputKind::kSoftShadowMap) result.images.back().grid = grid_;
    }
    result.report = std::move(report_);
    return result;
  }

 private:
  // Everything once, with the pixels' samples where the view has them.
  absl::Status DrawView(const ViewPlan& view, const SceneOnContext& on_context) {
    view_ = &view;
    request_.camera = ShiftedCamera(camera_, view.offset_pixels, request_.width, request_.height);
    request_.camera.far_m = plan_.camera_far_m;
    const std::string name =
        plan_.views.size() > 1 ? "view[" + std::to_string(&view - plan_.views.data()) + "]/" : std::string();
    RETURN_IF_ERROR(See(name, on_context));
    receivers_ = {&seen_->gbuffer.planes, request_.camera, request_.width, request_.height};
    receivers_.wants_blockers = view.shows_data && Wants(OutputKind::kPenumbraWidth);
    if (CountComputed(plan_.lights) > 0 && NeedCpuReceivers(draw_, request_, Apart())) {
      RETURN_IF_ERROR(Timed(name + "readback_receivers", &report_.readback_ms, [&] { return NeedOnCpu(); }));
    }
    if (view.shows_data) RETURN_IF_ERROR(ReadData());
    if (view.shows_frame) {
      RETURN_IF_ERROR(Timed(name + "ambient", &report_.shade_ms, [&]() -> absl::Status {
        ASSIGN_OR_RETURN(frame_, StartFrame(draw_, ltc_, seen_->gbuffer, receivers_, request_));
        if (HasCatcher()) {
          ASSIGN_OR_RETURN(unshadowed_, StartFrame(draw_, ltc_, seen_->gbuffer, receivers_, request_));
        }
        if (request_.fog) {
          ASSIGN_OR_RETURN(fog_, FogView::Create(draw_, receivers_, request_));
        }
        return absl::OkStatus();
      }));
    }
    for (const LightPlan& plan : plan_.lights) RETURN_IF_ERROR(DrawLight(plan, name, on_context));
    if (view.shows_frame && request_.fog) {
      RETURN_IF_ERROR(Timed(name + "fog", &report_.shade_ms, [&] { return fog_->DrawOver(draw_, frame_); }));
    }
    if (!view.shows_frame || !FrameSamples::AreNeeded(request_)) return absl::OkStatus();
    return Timed(name + "finish_frame", &report_.shade_ms, [&] {
      const FrameSamples::Catcher catcher = {&unshadowed_, &seen_->gbuffer.object_ids, GroundId(scene_)};
      return samples_.Add(draw_, frame_, HasCatcher() ? &catcher : nullptr, request_);
    });
  }

  // The view's G-buffer. A picture of several samples a pixel has several, and keeps none.
  absl::Status See(const std::string& name, const SceneOnContext& on_context) {
    const GBufferChannels channels = {view_->needs_materials, view_->needs_object_ids};
    if (request_.cache == CacheMode::kUse && plan_.views.size() == 1 && plan_.draws_gbuffer) {
      view_key_ = SeenViewKey(scene_name_, request_, channels);
      seen_ = views_->Find(view_key_);
      if (seen_ != nullptr) {
        report_.passes.push_back(SkippedPass(name + "gbuffer", "the same view was drawn before"));
        report_.caches.push_back({.name = "view", .hits = 1, .bytes = seen_->SizeBytes()});
        return absl::OkStatus();
      }
    }
    seen_ = std::make_shared<SeenView>();
    RETURN_IF_ERROR(Timed(name + "gbuffer", &report_.shade_ms, [&]() -> absl::Status {
      ASSIGN_OR_RETURN(seen_->gbuffer, DrawGBuffer(draw_, scene_, on_context, plan_.draws_gbuffer ? pose_ : Pose{},
                                                   request_, channels));
      report_.passes.back().count = seen_->gbuffer.triangles_drawn;
      if (const uint64_t left_out = seen_->gbuffer.triangles_out_of_view; left_out > 0) {
        report_.passes.back().reason = std::to_string(left_out) + " triangles out of view";
      }
      return absl::OkStatus();
    }));
    if (view_key_.empty()) return absl::OkStatus();
    views_->Keep(view_key_, seen_);
    report_.caches.push_back({.name = "view", .misses = 1, .bytes = seen_->SizeBytes()});
    return absl::OkStatus();
  }

  // Receivers in memory, once a view.
  absl::Status NeedOnCpu() {
    if (!seen_->on_cpu) {
      ASSIGN_OR_RETURN(seen_->on_cpu, ReadBackReceivers(receivers_));
      if (!view_key_.empty()) views_->Keep(view_key_, seen_);  // it has grown
    }
    receivers_.on_cpu = &*seen_->on_cpu;
    return absl::OkStatus();
  }

  absl::Status ReadData() {
    for (const OutputKind kind : request_.outputs) {
      if (kind == OutputKind::kFrame || kind == OutputKind::kSoftShadowMap || images_.contains(kind)) continue;
      RETURN_IF_ERROR(Timed("readback", &report_.readback_ms, [&]() -> absl::Status {
        ASSIGN_OR_RETURN(images_[kind], ReadDataImage(draw_, kind, seen_->gbuffer, request_.camera));
        return absl::OkStatus();
      }));
    }
    return absl::OkStatus();
  }

  const MovedApart* Apart() const { return apart_ ? &*apart_ : nullptr; }
  bool HasCatcher() const { return request_.ground && request_.ground->is_shadow_catcher; }

  bool Wants(OutputKind kind) const {
    return std::find(request_.outputs.begin(), request_.outputs.end(), kind) != request_.outputs.end();
  }

  // One side of a light.
  absl::Status DrawLight(const LightPlan& plan, const std::string& view_name, const SceneOnContext& on_context) {
    const AreaLight& light = plan.light;
    const std::string name = view_name + LightName(plan);
    // Said once, whatever the number of views.
    if (plan.outcome != LightOutcome::kCompute && view_ == plan_.views.data()) {
      report_.passes.push_back(SkippedPass(name + method_.name, plan.reason));
    }
    if (plan.outcome == LightOutcome::kSkipped ||
        !(view_->shows_frame || Wants(OutputKind::kVisibility) || receivers_.wants_blockers)) {
      return absl::OkStatus();
    }
    const bool computes = plan.outcome == LightOutcome::kCompute;
    std::vector<LightLayer>& layers = held_layers_[&plan];
    const LightSource source = SourceOf(on_context);
    if (computes && layers.empty()) {
      ASSIGN_OR_RETURN(layers, PrepareLayers(draw_, source, Apart(), light, name + "light_data", *caches_, report_));
    }
    ResolvedSide resolved;
    RETURN_IF_ERROR(Timed(name + "resolve", &report_.resolve_ms, [&]() -> absl::Status {
      ASSIGN_OR_RETURN(resolved, ResolveSide(draw_, layers, receivers_, light));
      report_.passes.back().count = resolved.occlusion.count;
      report_.passes.back().reason = resolved.occlusion.note;
      ReportChosen(resolved.occlusion.chosen_options, report_);
      return absl::OkStatus();
    }));
    for (PassReport& step : resolved.occlusion.steps) {
      step.name.insert(0, name + "resolve/");
      report_.passes.push_back(std::move(step));
    }
    RETURN_IF_ERROR(Timed(name + "readback", &report_.readback_ms, [&] {
      return Collect(plan.index, resolved.visibility, layers.empty() ? nullptr : &resolved.occlusion);
    }));
    if (resolved.penumbra_width) {
      RETURN_IF_ERROR(Timed(name + "readback", &report_.readback_ms,
                            [&] { return CollectPenumbraWidth(plan.index, resolved.penumbra_width); }));
    }
    if (request_.certify && view_ == plan_.views.data()) RETURN_IF_ERROR(Certify(plan, name, source));
    if (view_->shows_frame) {
      RETURN_IF_ERROR(Timed(name + "shade", &report_.shade_ms, [&] {
        return AddLight(draw_, ltc_, seen_->gbuffer, receivers_, light, resolved.visibility, request_, frame_);
      }));
    }
    if (view_->shows_frame && request_.fog) {
      RETURN_IF_ERROR(Timed(name + "fog", &report_.shade_ms, [&] { return LightFog(layers, light); }));
    }
    if (view_->shows_frame && HasCatcher()) {
      RETURN_IF_ERROR(Timed(name + "shade_unshadowed", &report_.shade_ms, [&]() -> absl::Status {
        ASSIGN_OR_RETURN(const gl::Texture share, FinishVisibility(draw_, nullptr, receivers_, light));
        return AddLight(draw_, ltc_, seen_->gbuffer, receivers_, light, share, request_, unshadowed_);
      }));
    }
    if (view_ == &plan_.views.back() && !Wants(OutputKind::kSoftShadowMap)) held_layers_.erase(&plan);
    return absl::OkStatus();
  }

  // What the fog in front of everything scatters of one side of a light.
  absl::Status LightFog(const std::vector<LightLayer>& layers, const AreaLight& light) {
    const bool on_cpu = !layers.empty() && NeedCpuReceivers(draw_, request_, Apart());
    for (int step = 0; step < kFogSteps; ++step) {
      ASSIGN_OR_RETURN(const Receivers points, fog_->StepPoints(draw_, step, on_cpu));
      ASSIGN_OR_RETURN(const ResolvedSide resolved, ResolveSide(draw_, layers, points, light));
      RETURN_IF_ERROR(fog_->AddLight(draw_, points, light, resolved.visibility));
    }
    report_.passes.back().count = kFogSteps;
    return absl::OkStatus();
  }

  absl::Status AddSoftShadowMap(const SceneOnContext& on_context) {
    const LightPlan& plan = plan_.lights[0];
    if (plan.outcome != LightOutcome::kCompute && plan_.views.empty()) {
      report_.passes.push_back(SkippedPass(LightName(plan) + method_.name, plan.reason));
    }
    ASSIGN_OR_RETURN(SoftShadowMap map, DrawSoftShadowMap(draw_, SourceOf(on_context), Apart(), plan,
                                                          held_layers_[&plan], *caches_, report_));
    images_[OutputKind::kSoftShadowMap] = std::move(map.image);
    grid_ = map.grid;
    return absl::OkStatus();
  }

  LightSource SourceOf(const SceneOnContext& on_context) const {
    return {scene_name_, scene_, pose_, request_, method_, &on_context, decoder_, CountComputed(plan_.lights)};
  }

  template <typename Pass>
  absl::Status Timed(const std::string& name, double* stage_ms, Pass pass) {
    return TimedPass(draw_, report_, name, stage_ms, pass);
  }

  absl::Status ReadBack(const gl::Texture& texture, OutputKind kind, int channels) {
    Image& image = images_[kind] = Image(request_.width, request_.height, channels);
    return texture.ReadFloats(image.data(), image.size());
  }

  // Visibility to memory: the image, the shares, the largest sum. A NaN out of a pass is our bug.
  absl::Status Collect(size_t light, const gl::Texture& texture, const OcclusionSum* occlusion) {
    Image& pairs = visibility_and_share_ = Image(request_.width, request_.height, 2);
    RETURN_IF_ERROR(texture.ReadFloats(pairs.data(), pairs.size()));
    const size_t pixels = size_t(request_.width) * request_.height;
    const size_t channels = request_.lights.size();
    const bool wants_image = view_->shows_data && Wants(OutputKind::kVisibility);
    float* const visibility = wants_image ? images_[OutputKind::kVisibility].data() : nullptr;
    for (size_t i = 0; i < pixels; ++i) {
      const float v = pairs.data()[2 * i];
      const float share = pairs.data()[2 * i + 1];
      if (!(v >= 0 && v <= 1)) {
        return absl::InternalError(method_.name + ": visibility " + std::to_string(v) + " at pixel " +
                                   std::to_string(i % request_.width) + "," + std::to_string(i / request_.width));
      }
      if (wants_image) {
        float& image_v = visibility[i * channels + light];
        image_v = std::max(image_v, v);  // of both sides, one is 0
      }
      if (share <= 0) continue;
      ++(v <= kPenumbraMargin ? umbra_ : v < 1 - kPenumbraMargin ? penumbra_ : lit_);
    }
    if (occlusion == nullptr) return absl::OkStatus();
    if (!occlusion->errors.empty()) {
      const bool reads_picture = occlusion->has_independent_errors && seen_->on_cpu.has_value();
      const PictureError expected =
          ExpectPictureError(pairs, occlusion->errors, reads_picture ? &*seen_->on_cpu : nullptr);
      predicted_sum_ += expected.sum;
      predicted_count_ += expected.pixels;
    }
    ASSIGN_OR_RETURN(const double largest, LargestFraction(*occlusion, pixels));
    report_.max_sum = std::max(report_.max_sum, largest);
    return absl::OkStatus();
  }

  absl::Status CollectPenumbraWidth(size_t light, const gl::Texture& texture) {
    std::vector<float> widths(size_t(request_.width) * request_.height);
    RETURN_IF_ERROR(texture.ReadFloats(widths.data(), widths.size()));
    float* const image = images_[OutputKind::kPenumbraWidth].data();
    for (size_t i = 0; i < widths.size(); ++i) {
      float& width = image[i * request_.lights.size() + light];
      width = std::max(width, widths[i]);  // of both sides, one is 0
    }
    return absl::OkStatus();
  }

  // Traces some pixels of what was just collected, occluded or not: a skip may be wrong too.
  absl::Status Certify(const LightPlan& plan, const std::string& name, const LightSource& source) {
    if (ray_scene_ == nullptr) {
      ASSIGN_OR_RETURN(ray_scene_, PrepareRayScene(draw_, source, *caches_, report_));
    }
    return Timed(name + "certify", &certify_ms_, [&]() -> absl::Status {
      RETURN_IF_ERROR(NeedOnCpu());
      const auto sides = uint32_t(std::count_if(plan_.lights.begin(), plan_.lights.end(), [](const LightPlan& side) {
        return side.outcome != LightOutcome::kSkipped;
      }));
      const uint32_t pixels = std::max(1u, request_.certify->pixels / sides);
      std::vector<ChosenPixel> chosen = ChoosePixels(visibility_and_share_, pixels, request_.seed);
      for (ChosenPixel& pixel : chosen) pixel.stratum += kStrata * certified_sides_;
      ++certified_sides_;
      ASSIGN_OR_RETURN(const std::vector<CertifiedPixel> certified,
                       CertifyPixels(*ray_scene_, plan.light, *seen_->on_cpu, chosen, visibility_and_share_,
                                     request_.certify->rays, request_.seed, [&] { return draw_.pacer->Finish(); }));
      certified_.insert(certified_.end(), certified.begin(), certified.end());
      report_.passes.back().count = certified.size();
      return absl::OkStatus();
    });
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
  const ImageDecoder& decoder_;
  const std::string& scene_name_;
  const FlatScene& scene_;
  RenderRequest request_;  // its camera: the view's
  const Camera camera_;
  const RegisteredMethod& method_;
  LightCaches* caches_;
  gl::ObjectCache<SeenView>* views_;
  Pose pose_;
  std::optional<MovedApart> apart_;
  FramePlan plan_;
  const ViewPlan* view_ = nullptr;  // that is drawn
  std::shared_ptr<SeenView> seen_;
  std::string view_key_;  // empty: not kept
  Receivers receivers_;
  gl::Texture frame_;
  gl::Texture unshadowed_;  // the frame without occluders, for a shadow catcher
  FrameSamples samples_;
  std::optional<FogView> fog_;
  std::map<const LightPlan*, std::vector<LightLayer>> held_layers_;  // what later views need
  std::map<OutputKind, Image> images_;
  LightGrid grid_;  // of the soft shadow map
  uint64_t umbra_ = 0, penumbra_ = 0, lit_ = 0;
  double predicted_sum_ = 0;  // of shadowed pixels of lights whose method tells its error
  uint64_t predicted_count_ = 0;
  Image visibility_and_share_;                          // of the last light
  gl::ObjectCache<const RayScene>::Pointer ray_scene_;  // of the certificate
  std::vector<CertifiedPixel> certified_;
  uint32_t certified_sides_ = 0;
  double certify_ms_ = 0;  // stands in the passes alone: it is no stage of the picture
  RenderReport report_;
};

absl::StatusOr<MethodFacts> MethodFactsOf(const FlatScene& scene, const RenderRequest& request) {
  ASSIGN_OR_RETURN(const Pose pose, BuildPose(scene, request.scene_index, request.node_overrides));
  return FactsForMethod(scene, pose, request, ReceiverCount(request));
}

}  // namespace

RenderReport DescribePlan(const FramePlan& plan, const RenderRequest& request, const RegisteredMethod& method) {
  RenderReport report;
  report.method = method.name;
  report.options = method.method->DescribeOptions(request.method);
  report.reason = request.method_reason;
  report.error.predicted = request.predicted_error;
  if (!plan.draws_gbuffer) report.passes.push_back(SkippedPass("gbuffer", plan.gbuffer_reason));
  if (!plan.needs_shading) report.passes.push_back(SkippedPass("shade", "no FRAME is asked"));
  if (!plan.needs_textures) {
    report.passes.push_back(SkippedPass("textures", "no FRAME, NORMAL or ALBEDO is asked, and nothing is masked"));
  }
  if (!plan.needs_object_ids) {
    report.passes.push_back(SkippedPass("object_ids", "no OBJECT_ID and no shadow catcher is asked"));
  }
  return report;
}

absl::Status CheckOutputs(const RenderRequest& request, const RegisteredMethod& method) {
  const auto found = std::find(request.outputs.begin(), request.outputs.end(), OutputKind::kPenumbraWidth);
  if (found == request.outputs.end() || method.method->KnowsBlockers()) {
    return absl::OkStatus();
  }
  std::string knowing;
  for (const RegisteredMethod& other : MethodRegistry()) {
    if (other.method->KnowsBlockers()) knowing += (knowing.empty() ? "" : ", ") + other.name;
  }
  return absl::UnimplementedError("outputs[" + std::to_string(found - request.outputs.begin()) +
                                  "].kind: PENUMBRA_WIDTH is not known to " + method.name + "; of methods it is to " +
                                  knowing);
}

absl::StatusOr<RenderResult> DrawFrame(const DrawContext& draw, const LtcTextures& ltc, const std::string& scene_name,
                                       const FlatScene& scene, const RenderRequest& request,
                                       const ImageDecoder& decoder, SceneOnContext& on_context, LightCaches& caches,
                                       gl::ObjectCache<SeenView>& views) {
  RenderRequest asked = request;
  const Stopwatch since_dequeue;
  while (true) {
    Frame frame(draw, ltc, scene_name, scene, asked, decoder, &caches, &views);
    if (absl::Status drawn = frame.Draw(on_context); !drawn.ok()) {
      if (!absl::IsResourceExhausted(drawn) || !asked.is_auto) return drawn;
      ASSIGN_OR_RETURN(const MethodFacts facts, MethodFactsOf(scene, asked));
      const double max_error = request.budget.max_error.value_or(kDefaultMaxError);
      asked.method_reason += "; ray in its place: " + std::string(drawn.message());
      if (!MakeSmaller(facts, max_error, &asked)) return drawn;
      continue;
    }
    RenderResult result = frame.TakeResult();
    const std::string breach = FindBreach(result.report.error, request.budget);
    if (breach.empty()) return result;
    ASSIGN_OR_RETURN(const MethodFacts facts, MethodFactsOf(scene, asked));
    if (!request.is_auto || !MakeMoreExact(facts, *request.budget.max_error, &asked.method)) {
      return absl::FailedPreconditionError("budget.max_error: " + breach + ", by " + result.report.method);
    }
    if (request.budget.max_latency_ms) {
      const double cpu_ms = PredictCost(facts, asked.method).TotalMs();
      const double again_ms = PredictWallMs(facts, cpu_ms, request.budget.machine.slowness);
      if (since_dequeue.Milliseconds() + again_ms > *request.budget.max_latency_ms) {
        return absl::FailedPreconditionError("budget.max_error: " + breach + ", by " + result.report.method +
                                             ", and budget.max_latency leaves no time for better");
      }
    }
    asked.method_reason += "; " + result.report.method + " drawn again at half the error: " + breach;
  }
}

}  // namespace halfshade
