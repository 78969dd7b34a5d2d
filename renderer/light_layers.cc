#include "renderer/light_layers.h"

#include <algorithm>
#include <unordered_set>
#include <utility>

#include "renderer/shadow/finish_visibility.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

bool HasCaster(const Pose& pose) {
  return std::any_of(pose.instances.begin(), pose.instances.end(),
                     [](const Instance& instance) { return instance.casts; });
}

// Whether a node or one above it is among these.
bool IsBelow(const FlatScene& scene, uint32_t node, const std::unordered_set<uint32_t>& tops) {
  for (int32_t i = int32_t(node); i >= 0; i = scene.nodes[i].parent) {
    if (tops.contains(uint32_t(i))) return true;
  }
  return false;
}

}  // namespace

absl::StatusOr<std::optional<MovedApart>> SetMovedApart(const FlatScene& scene, const Pose& pose,
                                                        const RenderRequest& request) {
  std::unordered_set<uint32_t> moved;
  for (const NodeOverride& change : request.node_overrides) {
    if (change.local) moved.insert(change.node);
  }
  if (moved.empty() || !FindMethod(request.method).method->KeepsMovedApart()) return std::nullopt;
  MovedApart apart;
  apart.still_request = apart.moved_request = request;
  for (NodeOverride& change : apart.still_request.node_overrides) {
    if (!change.local) continue;
    change.local.reset();
    change.casts = false;
  }
  ASSIGN_OR_RETURN(apart.still, BuildPose(scene, request.scene_index, apart.still_request.node_overrides));
  apart.moved_request.method = SsmOptions{};
  apart.moved = pose;
  for (Instance& instance : apart.moved.instances) {
    instance.casts = instance.casts && IsBelow(scene, instance.node, moved);
  }
  return apart;
}

absl::StatusOr<std::vector<LightLayer>> PrepareLayers(const DrawContext& draw, const LightSource& source,
                                                      const MovedApart* apart, const AreaLight& side,
                                                      const std::string& pass, LightCaches& caches,
                                                      RenderReport& report) {
  std::vector<LightLayer> layers;
  const auto add = [&](const Pose& pose, const RenderRequest& request, const std::string& name) -> absl::Status {
    if (!HasCaster(pose)) return absl::OkStatus();
    LightSource of_layer = {source.scene_name,          source.scene,      pose,           request,
                            FindMethod(request.method), source.on_context, source.decoder, source.computed_lights};
    of_layer.is_of_moved = apart != nullptr && &pose == &apart->moved;
    ASSIGN_OR_RETURN(auto data, PrepareLight(draw, of_layer, side, name, caches, report));
    layers.push_back({of_layer.method.method, &request.method, std::move(data)});
    return absl::OkStatus();
  };
  if (apart == nullptr) {
    RETURN_IF_ERROR(add(source.pose, source.request, pass));
  } else {
    RETURN_IF_ERROR(add(apart->still, apart->still_request, pass));
    RETURN_IF_ERROR(add(apart->moved, apart->moved_request, pass + "/moved"));
  }
  return layers;
}

bool NeedCpuReceivers(const DrawContext& draw, const RenderRequest& request, const MovedApart* apart) {
  const auto need = [&](const MethodOptions& options) {
    return FindMethod(options).method->Needs(options, FactsOf(draw)).cpu_receivers;
  };
  return need(request.method) || (apart != nullptr && need(apart->moved_request.method));
}

bool NeedReceiverTextures(const DrawContext& draw, const RenderRequest& request, const MovedApart* apart) {
  const auto need = [&](const MethodOptions& options) {
    return !FindMethod(options).method->Needs(options, FactsOf(draw)).cpu_receivers;
  };
  return need(request.method) || (apart != nullptr && need(apart->moved_request.method));
}

absl::StatusOr<ResolvedSide> ResolveSide(const DrawContext& draw, const std::vector<LightLayer>& layers,
                                         const Receivers& receivers, const AreaLight& side) {
  ResolvedSide resolved;
  gl::Texture* const penumbra_width = receivers.wants_blockers ? &resolved.penumbra_width : nullptr;
  if (layers.empty()) {
    ASSIGN_OR_RETURN(resolved.visibility, FinishVisibility(draw, nullptr, receivers, side, penumbra_width));
    return resolved;
  }
  for (const LightLayer& layer : layers) {
    const bool is_first = &layer == &layers.front();
    ASSIGN_OR_RETURN(OcclusionSum sum, layer.method->ResolveOcclusion(draw, *layer.data, receivers, *layer.options));
    sum.count += layer.data->MapsRedrawn();
    ASSIGN_OR_RETURN(gl::Texture visibility,
                     FinishVisibility(draw, &sum, receivers, side, is_first ? penumbra_width : nullptr,
                                      is_first ? nullptr : &resolved.visibility));
    resolved.visibility = std::move(visibility);
    if (is_first) {
      resolved.occlusion = std::move(sum);
    } else {
      resolved.occlusion.count += sum.count;
    }
  }
  return resolved;
}

}  // namespace halfshade
