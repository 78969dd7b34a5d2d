#include "renderer/renderer.h"

#include <glad/gl.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "renderer/gl/draw_context.h"
#include "renderer/gl/object_cache.h"
#include "renderer/light/cpu_receivers.h"
#include "renderer/light/light_data.h"
#include "renderer/light/occluders_on_context.h"
#include "renderer/plan/frame_plan.h"
#include "renderer/scene/pose.h"
#include "renderer/scene/ray_scene.h"
#include "renderer/scene/scene_on_context.h"
#include "renderer/shade/gbuffer.h"
#include "renderer/shade/shade.h"
#include "renderer/shadow/finish_visibility.h"
#include "renderer/shadow/shadow_method.h"
#include "renderer/status.h"
#include "renderer/warm_up.h"

namespace halfshade {
namespace {

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

using LightDataCache = gl::ObjectCache<LightData>;
using RaySceneCache = gl::ObjectCache<const RayScene>;

// One frame on its way through the house.
class Frame {
 public:
  Frame(const DrawContext& draw, const std::string& scene_name, const FlatScene& scene, const RenderRequest& request,
        LightDataCache* light_data, RaySceneCache* ray_scenes)
      : draw_(draw),
        scene_name_(scene_name),
        scene_(scene),
        request_(request),
        method_(FindMethod(request.method)),
        needs_(method_.method->Needs(request.method, {})),
        light_data_(light_data),
        ray_scenes_(ray_scenes) {}

  absl::Status Draw(SceneOnContext& on_context, const ImageDecoder& decoder) {
    ASSIGN_OR_RETURN(pose_, BuildPose(scene_, request_.scene_index, request_.node_overrides));
    plan_ = PlanFrame(scene_, pose_, request_);
    DescribePlan();
    if (plan_.needs_shading) {
      RETURN_IF_ERROR(
          Timed("materials", &report_.upload_ms, [&] { return on_context.NeedMaterials(draw_, scene_, decoder); }));
    }
    RETURN_IF_ERROR(Timed("gbuffer", &report_.shade_ms, [&]() -> absl::Status {
      ASSIGN_OR_RETURN(gbuffer_, DrawGBuffer(draw_, scene_, on_context, plan_.draws_gbuffer ? pose_ : Pose{}, request_,
                                             plan_.needs_shading));
      report_.passes.back().count = gbuffer_.triangles_drawn;
      return absl::OkStatus();
    }));
    receivers_ = {&gbuffer_.planes, request_.camera, request_.width, request_.height};
    if (needs_.cpu_receivers && ComputedLights() > 0) {
      RETURN_IF_ERROR(Timed("readback_receivers", &report_.readback_ms, [&]() -> absl::Status {
        ASSIGN_OR_RETURN(cpu_receivers_, ReadBackReceivers(receivers_));
        receivers_.on_cpu = &cpu_receivers_;
        return absl::OkStatus();
      }));
    }
    if (plan_.needs_shading) {
      RETURN_IF_ERROR(Timed("ambient", &report_.shade_ms, [&]() -> absl::Status {
        ASSIGN_OR_RETURN(frame_, StartFrame(draw_, gbuffer_, request_));
        return absl::OkStatus();
      }));
    }
    for (const LightPlan& plan : plan_.lights) RETURN_IF_ERROR(DrawLight(plan));
    FinishShares();
    return absl::OkStatus();
  }

  // Of the first `count` receivers.
  absl::StatusOr<QueryResult> Query(const CpuReceivers& points, size_t count) {
    ASSIGN_OR_RETURN(pose_, BuildPose(scene_, request_.scene_index, request_.node_overrides));
    Box3d bounds_ws;
    for (size_t i = 0; i < count; ++i) bounds_ws.Add(points.At(i).position_ws);
    plan_.lights = PlanQuery(scene_, pose_, request_, bounds_ws);
    DescribeMethod();
    receivers_ = {nullptr, points.camera, points.width, points.height};
    receivers_.on_cpu = &points;
    ReceiverTextures textures;
    if (!needs_.cpu_receivers && ComputedLights() > 0) {
      RETURN_IF_ERROR(Timed("receivers", &report_.upload_ms, [&]() -> absl::Status {
        ASSIGN_OR_RETURN(textures, UploadReceivers(*draw_.context, points));
        return absl::OkStatus();
      }));
      receivers_.planes = &textures.planes;
      receivers_.points = &textures.points;
    }
    QueryResult result;
    result.visibility.resize(count * request_.lights.size());
    for (const LightPlan& plan : plan_.lights) RETURN_IF_ERROR(QueryLight(plan, points, result.visibility));
    result.report = std::move(report_);
    return result;
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
  void DescribeMethod() {
    report_.method = method_.name;
    report_.options = method_.method->DescribeOptions(request_.method);
    report_.reason = request_.method_reason;
  }

  void DescribePlan() {
    DescribeMethod();
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

  static std::string LightName(const LightPlan& plan) {
    return "light[" + std::to_string(plan.index) + (plan.is_back ? "]/back/" : "]/");
  }

  // One side of a light.
  absl::Status DrawLight(const LightPlan& plan) {
    const AreaLight& light = plan.light;
    const std::string name = LightName(plan);
    if (plan.outcome != LightOutcome::kCompute) Skip(name + method_.name, plan.reason);
    if (plan.outcome == LightOutcome::kSkipped) return absl::OkStatus();
    LightDataCache::Pointer data;
    OcclusionSum occlusion;
    const bool computes = plan.outcome == LightOutcome::kCompute;
    if (computes) {
      ASSIGN_OR_RETURN(data, NeedLightData(light, name + "light_data"));
    }
    gl::Texture visibility;
    RETURN_IF_ERROR(Timed(name + "resolve", &report_.resolve_ms, [&]() -> absl::Status {
      if (computes) {
        ASSIGN_OR_RETURN(occlusion, method_.method->ResolveOcclusion(draw_, *data, receivers_, request_.method));
        report_.passes.back().count = data->MapsRedrawn();
      }
      ASSIGN_OR_RETURN(visibility, FinishVisibility(draw_, computes ? &occlusion : nullptr, receivers_, light));
      return absl::OkStatus();
    }));
    RETURN_IF_ERROR(Timed(name + "readback", &report_.readback_ms,
                          [&] { return Collect(plan.index, visibility, computes ? &occlusion : nullptr); }));
    if (plan_.needs_shading) {
      RETURN_IF_ERROR(Timed(name + "shade", &report_.shade_ms, [&] {
        return AddLight(draw_, gbuffer_, receivers_, light, visibility, request_, frame_);
      }));
    }
    return absl::OkStatus();
  }

  // One side of a light, into visibility[point][light].
  absl::Status QueryLight(const LightPlan& plan, const CpuReceivers& points, std::vector<float>& visibility) {
    const std::string name = LightName(plan);
    const bool computes = plan.outcome == LightOutcome::kCompute;
    if (!computes) Skip(name + method_.name, plan.reason);
    if (plan.outcome == LightOutcome::kSkipped) return absl::OkStatus();
    LightDataCache::Pointer data;
    if (computes) {
      ASSIGN_OR_RETURN(data, NeedLightData(plan.light, name + "light_data"));
    }
    std::vector<float> seen;
    const auto resolve = [&]() -> absl::Status {
      OcclusionSum occlusion;
      if (computes) {
        ASSIGN_OR_RETURN(occlusion, method_.method->ResolveOcclusion(draw_, *data, receivers_, request_.method));
        report_.passes.back().count = data->MapsRedrawn();
      }
      const OcclusionSum* sum = computes ? &occlusion : nullptr;
      if (receivers_.points == nullptr || !computes) {
        seen = FinishVisibilityOnCpu(sum, points, plan.light);
        return absl::OkStatus();
      }
      ASSIGN_OR_RETURN(const gl::Texture finished, FinishVisibility(draw_, sum, receivers_, plan.light));
      Image pairs(points.width, points.height, 2);
      RETURN_IF_ERROR(ReadBack(finished, pairs));
      for (size_t i = 0; i < points.size(); ++i) seen.push_back(pairs.data()[2 * i]);
      return absl::OkStatus();
    };
    RETURN_IF_ERROR(Timed(name + "resolve", &report_.resolve_ms, resolve));
    const size_t lights = request_.lights.size();
    for (size_t i = 0; i < visibility.size() / lights; ++i) {
      if (!(seen[i] >= 0 && seen[i] <= 1)) {
        return absl::InternalError(method_.name + ": visibility " + std::to_string(seen[i]) + " at point " +
                                   std::to_string(i));
      }
      float& v = visibility[i * lights + plan.index];
      v = std::max(v, seen[i]);  // of both sides, one is 0
    }
    return absl::OkStatus();
  }

  // From the cache, or built and kept there.
  absl::StatusOr<LightDataCache::Pointer> NeedLightData(const AreaLight& light, const std::string& pass) {
    const std::string key =
        LightDataKey(scene_name_, request_, light, method_.name, method_.method->LightDataOptions(request_.method));
    LightDataCache::Pointer data;
    if (request_.cache == CacheMode::kUse) data = light_data_->Find(key);
    const bool is_hit = data != nullptr;
    if (is_hit) {
      Skip(pass, "cached");
    } else {
      RaySceneCache::Pointer ray_scene;
      if (needs_.ray_scene) {
        ASSIGN_OR_RETURN(ray_scene, NeedRayScene());
      }
      RETURN_IF_ERROR(Timed(pass, &report_.light_ms, [&]() -> absl::Status {
        LightInputs inputs;
        if (needs_.maps > 0) {
          ASSIGN_OR_RETURN(inputs.occluders,
                           OccludersOnContext::Create(draw_, BuildLightSpaceOccluders(scene_, pose_, light)));
        }
        inputs.ray_scene = ray_scene;
        inputs.light = light;
        inputs.seed = request_.seed;
        inputs.max_light_data_bytes = LightDataShare();
        ASSIGN_OR_RETURN(data, method_.method->BuildLightData(draw_, inputs, request_.method));
        report_.passes.back().count = data->MapsDrawn();
        return absl::OkStatus();
      }));
      light_data_->Keep(key, data);
    }
    if (const uint64_t redrawn = data->MapsRedrawn(); redrawn > 0) {
      std::string& reason = report_.passes.back().reason;
      reason += (reason.empty() ? "" : "; ") + std::to_string(redrawn) +
                " maps do not fit the light cache: drawn at every resolve";
    }
    report_.caches.push_back(
        {.name = pass, .hits = uint64_t(is_hit), .misses = uint64_t(!is_hit), .bytes = data->SizeBytes()});
    return data;
  }

  absl::StatusOr<RaySceneCache::Pointer> NeedRayScene() {
    const std::string key = CastersKey(scene_name_, request_);
    RaySceneCache::Pointer ray_scene = ray_scenes_->Find(key);
    const bool is_hit = ray_scene != nullptr;
    if (!is_hit) {
      RETURN_IF_ERROR(Timed("ray_scene", &report_.light_ms, [&]() -> absl::Status {
        ASSIGN_OR_RETURN(ray_scene, RayScene::Create(scene_, pose_));
        report_.passes.back().count = ray_scene->triangles().indices.size() / 3;
        return absl::OkStatus();
      }));
      ray_scenes_->Keep(key, ray_scene);
    }
    report_.caches.push_back(
        {.name = "ray_scene", .hits = uint64_t(is_hit), .misses = uint64_t(!is_hit), .bytes = ray_scene->SizeBytes()});
    return ray_scene;
  }

  // Each light of this request may take as much of the cache, so that the next request finds them all.
  uint64_t LightDataShare() const { return light_data_->max_bytes() / ComputedLights(); }

  uint64_t ComputedLights() const {
    return uint64_t(std::count_if(plan_.lights.begin(), plan_.lights.end(),
                                  [](const LightPlan& plan) { return plan.outcome == LightOutcome::kCompute; }));
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
      if (wants_image) {
        float& image_v = visibility_.data()[i * channels + light];
        image_v = std::max(image_v, v);  // of both sides, one is 0
      }
      if (share <= 0) continue;
      ++(v <= kPenumbraMargin ? umbra_ : v < 1 - kPenumbraMargin ? penumbra_ : lit_);
    }
    if (occlusion != nullptr) {
      std::vector<float> read_back;
      const auto* sums = std::get_if<std::vector<float>>(&occlusion->sums);
      if (sums == nullptr) {
        read_back.resize(pixels);
        RETURN_IF_ERROR(std::get<gl::Texture>(occlusion->sums).ReadFloats(read_back.data(), pixels));
        sums = &read_back;
      }
      const float largest = *std::max_element(sums->begin(), sums->end());
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
  const std::string& scene_name_;
  const FlatScene& scene_;
  const RenderRequest& request_;
  const RegisteredMethod& method_;
  const MethodNeeds needs_;
  LightDataCache* light_data_;
  RaySceneCache* ray_scenes_;
  CpuReceivers cpu_receivers_;
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
  ContextRenderer(gl::Context* context, ImageDecoder decoder, const ContextMemory& memory)
      : context_(context),
        programs_(context),
        decoder_(std::move(decoder)),
        scenes_(memory.scene_bytes),
        light_data_(memory.light_data_bytes),
        ray_scenes_(memory.ray_scene_bytes) {}

  absl::StatusOr<RenderResult> Render(const std::string& scene_name, const FlatScene& scene,
                                      const RenderRequest& request, const StopCheck& stop) override {
    auto result = Draw(scene_name, scene, request, stop);
    TrimCaches();
    return result;
  }

  absl::StatusOr<QueryResult> QueryVisibility(const std::string& scene_name, const FlatScene& scene,
                                              const RenderRequest& request, const QueryPoints& points,
                                              const StopCheck& stop) override {
    gl::Pacer pacer(*context_, stop);
    const DrawContext draw = {context_, &programs_, &pacer};
    auto result = Frame(draw, scene_name, scene, request, &light_data_, &ray_scenes_)
                      .Query(MakePointReceivers(points.points_ws, points.normals_ws), points.points_ws.size());
    TrimCaches();
    return result;
  }

  void ForgetScene(const std::string& scene_name) override {
    scenes_.Forget(SceneKey(scene_name));
    light_data_.Forget(LightDataPrefix(scene_name));
    ray_scenes_.Forget(LightDataPrefix(scene_name));
  }

  std::vector<CacheReport> Caches() const override {
    return {{"scene_on_context", scenes_.hits(), scenes_.misses(), scenes_.bytes()},
            {"light_data", light_data_.hits(), light_data_.misses(), light_data_.bytes()},
            {"ray_scene", ray_scenes_.hits(), ray_scenes_.misses(), ray_scenes_.bytes()}};
  }

  void ForgetEverything() {
    scenes_.Clear();
    light_data_.Clear();
    ray_scenes_.Clear();
  }

 private:
  // Nothing is in use any more.
  void TrimCaches() {
    scenes_.Trim();
    light_data_.Trim();
    ray_scenes_.Trim();
  }

  // The beginning of no other scene's.
  static std::string SceneKey(const std::string& scene_name) { return scene_name + "\n"; }

  absl::StatusOr<RenderResult> Draw(const std::string& scene_name, const FlatScene& scene, const RenderRequest& request,
                                    const StopCheck& stop) {
    gl::Pacer pacer(*context_, stop);
    const DrawContext draw = {context_, &programs_, &pacer};
    const Stopwatch stopwatch;
    auto on_context = scenes_.Find(SceneKey(scene_name));
    const bool is_new = on_context == nullptr;
    if (is_new) {
      ASSIGN_OR_RETURN(on_context, SceneOnContext::Create(draw, scene));
    }
    const double upload_ms = stopwatch.Milliseconds();
    Frame frame(draw, scene_name, scene, request, &light_data_, &ray_scenes_);
    const absl::Status status = frame.Draw(*on_context, decoder_);
    scenes_.Keep(SceneKey(scene_name), on_context);  // it may have grown
    RETURN_IF_ERROR(status);
    ASSIGN_OR_RETURN(RenderResult result, frame.TakeResult());
    result.report.upload_ms += upload_ms;
    result.report.caches.push_back({.name = "scene_on_context",
                                    .hits = uint64_t(!is_new),
                                    .misses = uint64_t(is_new),
                                    .bytes = on_context->SizeBytes()});
    return result;
  }

  gl::Context* context_;
  gl::ProgramCache programs_;
  ImageDecoder decoder_;
  gl::ObjectCache<SceneOnContext> scenes_;
  LightDataCache light_data_;
  RaySceneCache ray_scenes_;
};

}  // namespace

absl::StatusOr<QueryResult> Renderer::QueryVisibility(const std::string&, const FlatScene&, const RenderRequest&,
                                                      const QueryPoints&, const StopCheck&) {
  return absl::UnimplementedError("this renderer answers no queries");
}

absl::StatusOr<std::unique_ptr<Renderer>> Renderer::Create(gl::Context* context, ImageDecoder decoder,
                                                           const ContextMemory& memory) {
  auto renderer = std::make_unique<ContextRenderer>(context, std::move(decoder), memory);
  RETURN_IF_ERROR(WarmUp(*renderer));
  renderer->ForgetEverything();
  return renderer;
}

}  // namespace halfshade
