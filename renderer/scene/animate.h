// Where the nodes of an animated scene stand at one moment, and how far its morph targets go. Pure; any thread.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "renderer/request.h"
#include "renderer/scene/flat_scene.h"

namespace halfshade {

// A moment of one of the scene's animations.
struct Moment {
  uint32_t animation = 0;  // in range
  double time_s = 0;       // before the first key and after the last one, these hold
};

struct Motion {
  std::vector<NodeOverride> overrides;  // local matrices of animated nodes, by node
  std::vector<float> morph_weights;     // as FlatScene::morph_weights
};

// STEP, LINEAR (rotations along the shorter arc, at constant speed) and CUBICSPLINE of glTF 2.0, appendix C.
Motion Animate(const FlatScene& scene, const Moment& moment);

// Both: where `asked` (a request's changes) has a node's local matrix, that one counts.
std::vector<NodeOverride> Combine(const std::vector<NodeOverride>& animated, const std::vector<NodeOverride>& asked);

}  // namespace halfshade
