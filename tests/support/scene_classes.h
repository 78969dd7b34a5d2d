// The scene classes of the accuracy suite and the bench, each one kind of difficulty. World metres, y up, over a ground
// at y = 0; occluders are about a metre large. MakeScene (scene_makers.h) is the way in.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tests/support/scene_makers.h"

namespace halfshade {

// S1 a plate parallel to the light and the ground (closed form: closed_forms.h); S2 a floating smooth solid; S3 a
// turned box that stands on the ground: contact; S4 a tilted sheet; S5 thin clutter: 3000 leaves of two triangles; S6 a
// knobbly solid that shadows itself, 229 k triangles; S7 a heap of stones, a million triangles; S8 a pergola whose
// slats cut the light into sheets, in fog, over a ball that circles and a vane that turns (MadeScene::moving, fog).
std::vector<std::string> SceneClassNames();

// triangles: about so many, 0: the class's own number. Requires a name of SceneClassNames (asserted).
MadeScene MakeSceneClass(const std::string& name, uint32_t triangles, uint32_t seed);

}  // namespace halfshade
