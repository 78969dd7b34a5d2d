// The door from the wire: proto messages to plain checked values. Every limit and every message about a request lives
// here. Pure; no GL, no threads. Messages name the field, the value and the bound: "lights[0].edge_u: not finite".
#pragma once

#include <absl/status/statusor.h>

#include <string>
#include <vector>

#include "halfshade/v1/render.pb.h"
#include "renderer/request.h"
#include "renderer/scene/animate.h"
#include "renderer/scene/flat_scene.h"
#include "renderer/scene/pose.h"
#include "server/limits.h"
#include "server/output_format.h"

namespace halfshade {

// The changes that a request makes to nodes and its moment of an animation together. INVALID_ARGUMENT for what the
// scene has not.
absl::StatusOr<Motion> ResolveMotion(const v1::RenderRequest& request, const FlatScene& scene);

struct ValidatedRender {
  RenderRequest request;              // outputs as asked, in order
  std::vector<float> morph_weights;   // of the scene, as it is bent (scene_catalog.h: LoadPosed)
  std::vector<OutputFormat> formats;  // of request.outputs
  uint64_t reply_bytes = 0;           // images as the encoder gets them
};

// What can be told without the scene: run before queueing. INVALID_ARGUMENT; UNIMPLEMENTED naming a field that this
// version lacks; FAILED_PRECONDITION for a result over limits.render_reply_bytes.
absl::Status CheckRenderFields(const v1::RenderRequest& request, const Limits& limits);

// All of it: CheckRenderFields, then what needs the scene, bent as the request asks (camera index, scene index,
// automatic camera, light and planes). `machine`: of the contexts.
absl::StatusOr<ValidatedRender> ValidateRender(const v1::RenderRequest& request, const FlatScene& scene,
                                               const Limits& limits, const Machine& machine = {});

struct ValidatedQuery {
  RenderRequest request;  // camera, size and outputs mean nothing
  QueryPoints points;
};

// The same for points. What a query does not look at (camera, size, samples, outputs, shading, ground) refuses nothing.
// FAILED_PRECONDITION where the reply would pass limits.render_reply_bytes.
absl::Status CheckQueryFields(const v1::QueryVisibilityRequest& query, const Limits& limits);
absl::StatusOr<ValidatedQuery> ValidateQuery(const v1::QueryVisibilityRequest& query, const FlatScene& scene,
                                             const Limits& limits, const Machine& machine = {});

// Names a result: SHA-256 of the scene's name, every resolved value, the version and GL_RENDERER.
std::string ContentKey(const std::string& scene_name, const ValidatedRender& render, const std::string& version,
                       const std::string& gl_renderer);

}  // namespace halfshade
