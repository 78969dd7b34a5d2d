// A scene's geometry and textures in the buffers of one GL context. Lives on that context's thread.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <memory>
#include <vector>

#include "renderer/gl/draw_context.h"
#include "renderer/gl/handles.h"
#include "renderer/gl/texture.h"
#include "renderer/renderer.h"
#include "renderer/scene/flat_scene.h"

namespace halfshade {

class SceneOnContext {
 public:
  // Uploads positions, indices and the plane of every triangle. Normals, texture coordinates and textures follow when a
  // request shades (NeedMaterials).
  static absl::StatusOr<std::unique_ptr<SceneOnContext>> Create(const DrawContext& draw, const FlatScene& scene);

  // Uploads what shading needs and has not been uploaded yet: decodes only the textures of the scene's own materials.
  // Errors of the decoder (INVALID_ARGUMENT with the image's JSON pointer) come back as they are.
  absl::Status NeedMaterials(const DrawContext& draw, const FlatScene& scene, const ImageDecoder& decoder);

  // Attributes: 0 position (relative to the mesh's origin), and after NeedMaterials 1 normal, 2 texture coordinate.
  const gl::VertexArray& vertex_array() const { return vertex_array_; }
  // vec4 per triangle in the order of FlatScene::indices / 3: unit normal, offset from the mesh's origin along it.
  const gl::Buffer& triangle_planes() const { return triangle_planes_; }
  // Null where the material has none. Valid after NeedMaterials.
  const gl::Texture* base_color_texture(uint32_t material) const;

  uint64_t SizeBytes() const;  // grows with NeedMaterials

 private:
  SceneOnContext() = default;
  gl::VertexArray vertex_array_;
  gl::Buffer positions_, indices_, triangle_planes_, normals_, texcoords_;
  std::vector<gl::Texture> textures_;         // one per FlatScene::textures, empty where not used
  std::vector<int32_t> texture_of_material_;  // -1: none
  bool has_materials_ = false;
  uint64_t geometry_bytes_ = 0, attribute_bytes_ = 0;
};

}  // namespace halfshade
