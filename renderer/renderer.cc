#include "renderer/renderer.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "renderer/frame.h"
#include "renderer/gl/draw_context.h"
#include "renderer/gl/object_cache.h"
#include "renderer/gl/turn.h"
#include "renderer/light/light_data.h"
#include "renderer/passes.h"
#include "renderer/plan/frame_plan.h"
#include "renderer/prepare_light.h"
#include "renderer/query.h"
#include "renderer/scene/pose.h"
#include "renderer/scene/scene_on_context.h"
#include "renderer/shade/shade.h"
#include "renderer/shadow/shadow_method.h"
#include "renderer/status.h"
#include "renderer/warm_up.h"

namespace halfshade {
namespace {

class ContextRenderer : public Renderer {
 public:
  ContextRenderer(gl::Context* context, LtcTextures ltc, ImageDecoder decoder, const ContextMemory& memory)
      : context_(context),
        programs_(context),
        ltc_(std::move(ltc)),
        decoder_(std::move(decoder)),
        scenes_(memory.scene_bytes),
        lights_{gl::ObjectCache<LightData>(memory.light_data_bytes),
                gl::ObjectCache<const RayScene>(memory.ray_scene_bytes),
                gl::ObjectCache<const SceneData>(memory.scene_data_bytes), nullptr},
        light_store_(memory.light_store),
        views_(memory.view_bytes) {}
  ~ContextRenderer() override { last_turn_.emplace(*context_); }

  // From here on requests come from outside: their textures are decoded, and light data is stored.
  void Open(ImageDecoder decoder) {
    decoder_ = std::move(decoder);
    lights_.store = light_store_;
  }

  absl::StatusOr<RenderResult> Render(const std::string& scene_name, const FlatScene& scene,
                                      const RenderRequest& request, const StopCheck& stop) override {
    const gl::Turn turn(*context_);
    auto result = Draw(scene_name, scene, request, stop);
    TrimCaches();
    return result;
  }

  absl::StatusOr<QueryResult> QueryVisibility(const std::string& scene_name, const FlatScene& scene,
                                              const RenderRequest& request, const QueryPoints& points,
                                              const StopCheck& stop) override {
    const gl::Turn turn(*context_);
    gl::Pacer pacer(*context_, stop);
    const DrawContext draw = {context_, &programs_, &pacer};
    gl::ObjectCache<SceneOnContext>::Pointer on_context;
    const ShadowMethod& method = *FindMethod(request.method).method;
    if (method.Needs(request.method, FactsOf(draw)).maps > 0) {
      on_context = scenes_.Find(SceneKey(scene_name));
      if (on_context == nullptr) {
        ASSIGN_OR_RETURN(on_context, SceneOnContext::Create(draw, scene));
      }
    }
    auto result = QueryLights(draw, scene_name, scene, request, points, on_context.get(), decoder_, lights_);
    if (on_context != nullptr) scenes_.Keep(SceneKey(scene_name), std::move(on_context));  // it may have grown
    TrimCaches();
    return result;
  }

  void ForgetScene(const std::string& scene_name) override {
    const gl::Turn turn(*context_);
    scenes_.Forget(SceneKey(scene_name));
    views_.Forget(LightDataPrefix(scene_name));
    lights_.light_data.Forget(LightDataPrefix(scene_name));
    lights_.ray_scenes.Forget(LightDataPrefix(scene_name));
    lights_.scene_data.Forget(LightDataPrefix(scene_name));
  }

  absl::Status CheckCanary() override {
    const gl::Turn turn(*context_);
    ASSIGN_OR_RETURN(Image image, DrawCanary(*this));
    if (canary_.size() == 0) canary_ = image;
    if (std::equal(canary_.data(), canary_.data() + canary_.size(), image.data(), image.data() + image.size())) {
      return absl::OkStatus();
    }
    return absl::InternalError("the context draws another picture than at its start");
  }

  std::vector<CacheReport> Caches() const override {
    return {CacheOf("scene_on_context", scenes_), CacheOf("light_data", lights_.light_data), CacheOf("view", views_),
            CacheOf("ray_scene", lights_.ray_scenes), CacheOf("scene_data", lights_.scene_data)};
  }

  void ForgetEverything() {
    scenes_.Clear();
    views_.Clear();
    lights_.light_data.Clear();
    lights_.ray_scenes.Clear();
    lights_.scene_data.Clear();
  }

 private:
  // Nothing is in use any more.
  void TrimCaches() {
    scenes_.Trim();
    views_.Trim();
    lights_.light_data.Trim();
    lights_.ray_scenes.Trim();
    lights_.scene_data.Trim();
  }

  template <typename Cache>
  static CacheReport CacheOf(const char* name, const Cache& cache) {
    return {name, cache.hits(), cache.misses(), cache.bytes()};
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
    auto result = DrawFrame(draw, ltc_, scene_name, scene, request, decoder_, *on_context, lights_, views_);
    scenes_.Keep(SceneKey(scene_name), on_context);  // it may have grown
    RETURN_IF_ERROR(result.status());
    result->report.upload_ms += upload_ms;
    result->report.caches.push_back({.name = "scene_on_context",
                                     .hits = uint64_t(!is_new),
                                     .misses = uint64_t(is_new),
                                     .bytes = on_context->SizeBytes()});
    return result;
  }

  std::optional<gl::Turn> last_turn_;  // while all that follows is freed
  gl::Context* context_;
  gl::ProgramCache programs_;
  LtcTextures ltc_;
  ImageDecoder decoder_;
  gl::ObjectCache<SceneOnContext> scenes_;
  LightCaches lights_;
  LightStore* light_store_;
  gl::ObjectCache<SeenView> views_;
  Image canary_;  // as it was drawn first
};

}  // namespace

absl::StatusOr<RenderReport> PlanRender(const FlatScene& scene, const RenderRequest& request) {
  ASSIGN_OR_RETURN(const Pose pose, BuildPose(scene, request.scene_index, request.node_overrides));
  const FramePlan plan = PlanFrame(scene, pose, request);
  const RegisteredMethod& method = FindMethod(request.method);
  RETURN_IF_ERROR(CheckOutputs(request, method));
  RenderReport report = DescribePlan(plan, request, method);
  for (const LightPlan& light : plan.lights) {
    if (light.outcome == LightOutcome::kCompute) continue;
    report.passes.push_back(SkippedPass(LightName(light) + method.name, light.reason));
  }
  return report;
}

absl::StatusOr<QueryResult> Renderer::QueryVisibility(const std::string&, const FlatScene&, const RenderRequest&,
                                                      const QueryPoints&, const StopCheck&) {
  return absl::UnimplementedError("this renderer answers no queries");
}

absl::StatusOr<std::unique_ptr<Renderer>> Renderer::Create(gl::Context* context, ImageDecoder decoder,
                                                           const ContextMemory& memory) {
  const gl::Turn turn(*context);
  ASSIGN_OR_RETURN(LtcTextures ltc, LtcTextures::Create(*context));
  auto renderer = std::make_unique<ContextRenderer>(context, std::move(ltc), WarmUpTexel, memory);
  RETURN_IF_ERROR(WarmUp(*renderer));
  RETURN_IF_ERROR(renderer->CheckCanary());
  renderer->ForgetEverything();
  renderer->Open(std::move(decoder));
  return renderer;
}

}  // namespace halfshade
