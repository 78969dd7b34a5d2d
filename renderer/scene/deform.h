// Skins and morph targets applied: the scene as it is bent at one moment. Pure; any thread; in double.
#pragma once

#include <absl/status/statusor.h>

#include <vector>

#include "renderer/request.h"
#include "renderer/scene/flat_scene.h"

namespace halfshade {

// Writes positions, normals, tangents, triangles, bounds and clusters of every FlatScene::deformed mesh: targets first,
// by `morph_weights` (as many as FlatScene::morph_weights), then joints where the overrides put them. Weights of joints
// are taken in proportion. Skinned meshes then stand in world space, the others in their nodes'. Triangles without area
// are left out, so a mesh may come to have none. INVALID_ARGUMENT where a vertex ends over kMaxCoordinateM (pose.h)
// away.
absl::Status Deform(const std::vector<NodeOverride>& overrides, const std::vector<float>& morph_weights,
                    FlatScene* scene);

// Of every node, whether moving it moves a joint: the joints and their ancestors.
std::vector<bool> BendingNodes(const FlatScene& scene);

// Frees what only Deform reads.
void ForgetBinding(FlatScene* scene);

}  // namespace halfshade
