// OBJ at the client becomes GLB: the wire knows glTF alone.
#pragma once

#include <absl/status/statusor.h>

#include <string>

namespace halfshade {

// Triangulated, one mesh per shape and material, diffuse colours of .mtl files. Grey without a material; textures are
// not read. Nothing is opened but `path` and regular files inside its folder. INVALID_ARGUMENT, the message starting
// with `path`: tinyobjloader's word for a broken file, a face that names what the file lacks, a coordinate that is not
// finite, no triangles, an mtllib outside the folder, or more than a GLB holds.
absl::StatusOr<std::string> ObjToGlb(const std::string& path);

}  // namespace halfshade
