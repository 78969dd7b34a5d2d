#include "renderer/query.h"

#include <algorithm>

#include "renderer/light/cpu_receivers.h"
#include "renderer/light/receivers.h"
#include "renderer/light_layers.h"
#include "renderer/passes.h"
#include "renderer/shadow/finish_visibility.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

Box3d Bounds(const QueryPoints& points) {
  Box3d bounds;
  for (const glm::vec3& point : points.points_ws) bounds.Add(glm::dvec3(point));
  return bounds;
}

// Mean of the errors that methods tell of shadowed points.
struct PredictedError {
  double sum = 0;
  uint64_t count = 0;
  void Add(const std::vector<float>& visibility, const std::vector<float>& errors, const CpuReceivers& receivers,
           const AreaLight& side) {
    for (size_t i = 0; i < errors.size(); ++i) {
      const CpuReceiver receiver = receivers.At(i);
      if (!receiver.is_receiving || visibility[i] >= 1 - kPenumbraMargin) continue;
      const double share = CutAtPlane(side, receivers, receiver).share;
      if (share <= 0) continue;
      sum += share * errors[i];
      ++count;
    }
  }
};

// v of one side of a light for one layer's occluders, one a receiver.
absl::StatusOr<std::vector<float>> ResolveLayer(const DrawContext& draw, const LightLayer& layer,
                                                const Receivers& receivers, const AreaLight& side, RenderReport& report,
                                                PredictedError* predicted) {
  ASSIGN_OR_RETURN(const OcclusionSum sum,
                   layer.method->ResolveOcclusion(draw, *layer.data, receivers, *layer.options));
  report.passes.back().count += layer.data->MapsRedrawn() + sum.count;
  if (!sum.note.empty()) report.passes.back().reason = sum.note;
  ReportChosen(sum.chosen_options, report);
  if (std::holds_alternative<std::vector<float>>(sum.sums)) {
    std::vector<float> visibility = FinishVisibilityOnCpu(&sum, *receivers.on_cpu, side);
    predicted->Add(visibility, sum.errors, *receivers.on_cpu, side);
    return visibility;
  }
  ASSIGN_OR_RETURN(const gl::Texture finished, FinishVisibility(draw, &sum, receivers, side));
  Image pairs(receivers.width, receivers.height, 2);
  RETURN_IF_ERROR(finished.ReadFloats(pairs.data(), pairs.size()));
  std::vector<float> visibility(receivers.on_cpu->size());
  for (size_t i = 0; i < visibility.size(); ++i) visibility[i] = pairs.data()[2 * i];
  return visibility;
}

// v for all layers' occluders, as ResolveSide has it.
absl::StatusOr<std::vector<float>> Resolve(const DrawContext& draw, const std::vector<LightLayer>& layers,
                                           const Receivers& receivers, const AreaLight& side, RenderReport& report,
                                           PredictedError* predicted) {
  if (layers.empty()) return FinishVisibilityOnCpu(nullptr, *receivers.on_cpu, side);
  ASSIGN_OR_RETURN(std::vector<float> seen, ResolveLayer(draw, layers[0], receivers, side, report, predicted));
  if (layers.size() == 1) return seen;
  const std::vector<float> shares = FinishVisibilityOnCpu(nullptr, *receivers.on_cpu, side);
  for (size_t i = 1; i < layers.size(); ++i) {
    ASSIGN_OR_RETURN(const std::vector<float> others,
                     ResolveLayer(draw, layers[i], receivers, side, report, predicted));
    for (size_t point = 0; point < seen.size(); ++point) {
      if (shares[point] > 0) seen[point] *= std::min(1.0f, others[point] / shares[point]);
    }
  }
  return seen;
}

}  // namespace

absl::StatusOr<QueryResult> QueryLights(const DrawContext& draw, const std::string& scene_name, const FlatScene& scene,
                                        const RenderRequest& request, const QueryPoints& points,
                                        SceneOnContext* on_context, const ImageDecoder& decoder, LightCaches& caches) {
  ASSIGN_OR_RETURN(const Pose pose, BuildPose(scene, request.scene_index, request.node_overrides));
  const RegisteredMethod& method = FindMethod(request.method);
  ASSIGN_OR_RETURN(const std::optional<MovedApart> moved_apart, SetMovedApart(scene, pose, request));
  const MovedApart* const apart = moved_apart ? &*moved_apart : nullptr;
  const std::vector<LightPlan> lights = PlanQuery(scene, pose, request, Bounds(points));
  QueryResult result;
  RenderReport& report = result.report;
  report.method = method.name;
  report.options = method.method->DescribeOptions(request.method);
  report.reason = request.method_reason;

  const CpuReceivers on_cpu = MakePointReceivers(points.points_ws, points.normals_ws);
  Receivers receivers = {nullptr, on_cpu.camera, on_cpu.width, on_cpu.height};
  receivers.on_cpu = &on_cpu;
  const LightSource source = {scene_name, scene, pose, request, method, on_context, decoder, CountComputed(lights)};
  if (source.computed_lights > 0 && on_context != nullptr && HasMaskedCaster(scene, pose)) {
    RETURN_IF_ERROR(TimedPass(draw, report, "textures", &report.upload_ms, [&] {
      return on_context->NeedTextures(draw, scene, decoder, /*with_materials=*/false);
    }));
  }
  ReceiverTextures textures;
  if (source.computed_lights > 0 && NeedReceiverTextures(draw, request, apart)) {
    RETURN_IF_ERROR(TimedPass(draw, report, "receivers", &report.upload_ms, [&]() -> absl::Status {
      ASSIGN_OR_RETURN(textures, UploadReceivers(*draw.context, on_cpu));
      return absl::OkStatus();
    }));
    receivers.planes = &textures.planes;
    receivers.points = &textures.points;
  }

  const size_t count = points.points_ws.size();
  PredictedError predicted;
  result.visibility.resize(count * request.lights.size());
  for (const LightPlan& plan : lights) {
    const std::string name = LightName(plan);
    std::vector<LightLayer> layers;
    if (plan.outcome == LightOutcome::kCompute) {
      ASSIGN_OR_RETURN(layers, PrepareLayers(draw, source, apart, plan.light, name + "light_data", caches, report));
    } else {
      report.passes.push_back(SkippedPass(name + method.name, plan.reason));
    }
    if (plan.outcome == LightOutcome::kSkipped) continue;
    std::vector<float> seen;
    RETURN_IF_ERROR(TimedPass(draw, report, name + "resolve", &report.resolve_ms, [&]() -> absl::Status {
      ASSIGN_OR_RETURN(seen, Resolve(draw, layers, receivers, plan.light, report, &predicted));
      return absl::OkStatus();
    }));
    for (size_t i = 0; i < count; ++i) {
      if (!(seen[i] >= 0 && seen[i] <= 1)) {
        return absl::InternalError(method.name + ": visibility " + std::to_string(seen[i]) + " at point " +
                                   std::to_string(i));
      }
      float& v = result.visibility[i * request.lights.size() + plan.index];
      v = std::max(v, seen[i]);  // of both sides, one is 0
    }
  }
  if (predicted.count > 0) report.error.predicted = predicted.sum / double(predicted.count);
  return result;
}

}  // namespace halfshade
