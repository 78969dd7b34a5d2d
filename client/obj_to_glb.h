// OBJ at the client becomes GLB: the wire knows glTF alone.
#pragma once

#include <absl/status/statusor.h>

#include <string>

namespace halfshade {

// Triangulated, one mesh per shape and material, diffuse colours of .mtl files in the OBJ's own folder. Grey without a
// material. INVALID_ARGUMENT with tinyobjloader's word for a broken file, or for one without triangles.
absl::StatusOr<std::string> ObjToGlb(const std::string& path);

}  // namespace halfshade
