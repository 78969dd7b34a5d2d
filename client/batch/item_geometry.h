// Camera and lights of an item, as its line in the manifest has them: client/batch/README.md draws the axes. Pure.
#pragma once

#include <absl/status/statusor.h>

#include <nlohmann/json.hpp>

#include "halfshade/v1/render.pb.h"

namespace halfshade {

// {"camera": {"type": "perspective" | "orthographic", "cameraFromWorld": 16 numbers, "pixelFromCamera": 9 numbers},
//  "lights": [{"lightFromWorld": 16 numbers, "widthM", "heightM", "radiance": [r, g, b], "intensity": [r, g, b],
//              "twoSided"}]}
// Matrices are column-major. Camera axes: x right, y down, z along the view (DEPTH is z); light axes: x and y along the
// edges, z along the direction that it emits to, origin at its centre. Pixels count from the upper left corner of the
// picture, centres at halves. null: left to the server, which does not tell. INVALID_ARGUMENT, with the server's words,
// for what the server refuses.
absl::StatusOr<nlohmann::ordered_json> ItemGeometry(const v1::RenderRequest& request);

}  // namespace halfshade
