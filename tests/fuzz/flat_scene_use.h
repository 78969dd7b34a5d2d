// What everything does with a scene that was let in: if any of it can go wrong, the check before it is not enough.
#pragma once

#include <cstdlib>
#include <string>
#include <utility>

#include "renderer/scene/animate.h"
#include "renderer/scene/check_flat_scene.h"
#include "renderer/scene/deform.h"
#include "renderer/scene/flat_form.h"
#include "renderer/scene/pose.h"

namespace halfshade {

inline void Require(bool holds) {
  if (!holds) std::abort();
}

inline void UseScene(const FlatScene& scene) {
  for (uint32_t i = 0; i < scene.scenes.size() && i < 4; ++i) Require(BuildPose(scene, i).ok());
  for (uint32_t i = 0; i < scene.animations.size() && i < 4; ++i) {
    for (const double time_s : {0.0, 0.5 * scene.animations[i].duration_s, scene.animations[i].duration_s}) {
      const Motion motion = Animate(scene, {i, time_s});
      FlatScene copy = scene;
      // It may reach too far, by itself or where its node carries it. Where it does not, it is as valid as it was.
      if (!Deform(motion.overrides, motion.morph_weights, &copy).ok()) continue;
      bool is_within_reach = true;
      for (uint32_t s = 0; s < copy.scenes.size(); ++s) {
        const absl::Status posed = BuildPose(copy, s).status();
        Require(posed.ok() || absl::IsInvalidArgument(posed));
        is_within_reach = is_within_reach && posed.ok();
      }
      const absl::Status checked = CheckFlatScene(copy);
      // Bending changes no node, but what a node in no scene then reaches no pose tells.
      const bool is_of_node = checked.message().find("nodes[") != std::string::npos;
      Require(!is_within_reach || checked.ok() || is_of_node);
    }
  }
}

// Of a scene that our own loader made.
inline void UseLoadedScene(const FlatScene& scene) {
  Require(CheckFlatScene(scene).ok());
  const std::string bytes = FlatSceneBytes(scene);
  const auto read = ReadFlatScene(bytes);
  Require(read.ok() && FlatSceneBytes(*read) == bytes);
  UseScene(scene);
}

}  // namespace halfshade
