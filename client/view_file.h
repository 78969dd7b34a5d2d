// View files: a camera, one or several light rectangles and a ground plane, kept apart from the request.
//
// {"scene": path, "camera": {eye, target, up, fovy_deg}, "light": {center, u, v, normal, width, height} or "lights":
// [...],
//  "ground": {y, size, add}}; vectors are arrays of three numbers, u and v unit axes, lengths in scene units. Other
//  keys
// are notes.
#pragma once

#include <absl/status/statusor.h>

#include <string>

#include "halfshade/v1/render.pb.h"

namespace halfshade {

// Replaces camera, lights and ground of `request` by those that the view states, and its scene by the view's.
// edge_u = u * width and edge_v = v * height, negated where cross(u, v) = -normal; `direction` is set only where an
// edge is 0. `scene` is relative to the folder above the view file's. Errors: NOT_FOUND without the file;
// INVALID_ARGUMENT naming the key.
absl::Status ApplyViewFile(const std::string& path, v1::RenderRequest* request);

}  // namespace halfshade
