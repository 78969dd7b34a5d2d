// The files of a scene, read for an upload: the .glb or .gltf (or an .obj, converted) and what its buffers and images
// name. Only regular files inside SCENE's folder are read: links are resolved first, and a device, a pipe, a folder or
// a file elsewhere is the scene's fault, as is one that is absent.
#pragma once

#include <absl/status/statusor.h>

#include <memory>
#include <string>
#include <vector>

#include "halfshade/v1/render.pb.h"

namespace halfshade {

struct SceneFile {
  std::string uri;  // relative, percent-decoded; the root has none
  std::string bytes;
  std::string digest;  // hex SHA-256
};

struct SceneFiles {
  std::string name;  // "scenes/<hex>", by content
  SceneFile root;
  std::vector<SceneFile> files;  // each URI once, ordered by its bytes
};

// Errors: NOT_FOUND where `path` itself cannot be read; INVALID_ARGUMENT with the JSON pointer of the URI at fault
// ("/buffers/0/uri: ../../etc/passwd: outside the scene's folder"), or of an .obj that cannot be read as one.
// A root whose JSON cannot be read names no files: the server will say what is wrong with it.
absl::StatusOr<SceneFiles> ReadSceneFiles(const std::string& path);

// Where the request's scene is a file: its files, and the request gets the scene's name. Null where it is a name
// already.
absl::StatusOr<std::unique_ptr<SceneFiles>> TakeSceneFiles(v1::RenderRequest* request);

}  // namespace halfshade
