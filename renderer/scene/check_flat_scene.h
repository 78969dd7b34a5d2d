// Whether a FlatScene keeps the promises of flat_scene.h: whatever reads it afterwards needs no checks of its own.
#pragma once

#include <absl/status/status.h>

#include "renderer/scene/flat_scene.h"

namespace halfshade {

// DATA_LOSS naming the array and the element. Every index and run is in range, also where Deform and Animate reach;
// meshes own their runs of vertices, indices and clusters; every float is finite, and no mesh, placed, reaches beyond
// kMaxCoordinateM; the node graph is a forest.
absl::Status CheckFlatScene(const FlatScene& scene);

}  // namespace halfshade
