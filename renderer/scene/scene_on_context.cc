#include "renderer/scene/scene_on_context.h"

#include <glad/gl.h>

#include "renderer/status.h"

namespace halfshade {
namespace {

// Unit normal and offset of every triangle, from its mesh-relative corners, in double.
std::vector<glm::vec4> TrianglePlanes(const FlatScene& scene) {
  std::vector<glm::vec4> planes(scene.indices.size() / 3);
  for (const Mesh& mesh : scene.meshes) {
    for (uint32_t i = 0; i < mesh.index_count; i += 3) {
      const uint32_t* corner = &scene.indices[mesh.first_index + i];
      glm::dvec3 p[3];
      for (int k = 0; k < 3; ++k) p[k] = scene.positions[mesh.first_vertex + corner[k]];
      const glm::dvec3 normal = glm::normalize(glm::cross(p[1] - p[0], p[2] - p[0]));
      planes[(mesh.first_index + i) / 3] = glm::vec4(normal, glm::dot(normal, p[0]));
    }
  }
  return planes;
}

GLenum WrapMode(Wrap wrap) {
  switch (wrap) {
    case Wrap::kClampToEdge:
      return GL_CLAMP_TO_EDGE;
    case Wrap::kMirroredRepeat:
      return GL_MIRRORED_REPEAT;
    case Wrap::kRepeat:
      break;
  }
  return GL_REPEAT;
}

}  // namespace

absl::StatusOr<std::unique_ptr<SceneOnContext>> SceneOnContext::Create(const DrawContext& draw,
                                                                       const FlatScene& scene) {
  const gl::Context& context = *draw.context;
  auto result = std::unique_ptr<SceneOnContext>(new SceneOnContext);
  result->vertex_array_ = gl::VertexArray::Create(context);
  if (scene.indices.empty()) return result;
  ASSIGN_OR_RETURN(result->positions_, gl::Buffer::Create(context, scene.positions));
  ASSIGN_OR_RETURN(result->indices_, gl::Buffer::Create(context, scene.indices));
  ASSIGN_OR_RETURN(result->triangle_planes_, gl::Buffer::Create(context, TrianglePlanes(scene)));
  result->vertex_array_.SetFloats(0, 3, result->positions_.id());
  context.gl().VertexArrayElementBuffer(result->vertex_array_.id(), result->indices_.id());
  result->geometry_bytes_ = scene.positions.size() * sizeof(glm::vec3) + scene.indices.size() * sizeof(uint32_t) +
                            scene.indices.size() / 3 * sizeof(glm::vec4);
  RETURN_IF_ERROR(context.Check("scene/upload"));
  return result;
}

absl::Status SceneOnContext::NeedMaterials(const DrawContext& draw, const FlatScene& scene,
                                           const ImageDecoder& decoder) {
  if (has_materials_ || scene.indices.empty()) return absl::OkStatus();
  const gl::Context& context = *draw.context;
  const GladGLContext& gl = context.gl();
  ASSIGN_OR_RETURN(normals_, gl::Buffer::Create(context, scene.normals));
  ASSIGN_OR_RETURN(texcoords_, gl::Buffer::Create(context, scene.texcoords));
  vertex_array_.SetFloats(1, 3, normals_.id());
  vertex_array_.SetFloats(2, 2, texcoords_.id());
  attribute_bytes_ = scene.normals.size() * sizeof(glm::vec3) + scene.texcoords.size() * sizeof(glm::vec2);

  std::vector<bool> is_used(scene.textures.size(), false);
  texture_of_material_.assign(scene.materials.size(), -1);
  for (const Mesh& mesh : scene.meshes) {
    const int32_t texture = scene.materials[mesh.material].base_color_texture;
    texture_of_material_[mesh.material] = texture;
    if (texture >= 0) is_used[texture] = true;
  }
  textures_.resize(scene.textures.size());
  for (size_t i = 0; i < scene.textures.size(); ++i) {
    if (!is_used[i]) continue;
    const Texture& texture = scene.textures[i];
    ASSIGN_OR_RETURN(Rgba8Image image, decoder(scene.images[texture.image]));
    ASSIGN_OR_RETURN(textures_[i], gl::Texture::Create2DWithMips(context, GL_SRGB8_ALPHA8, image.width, image.height));
    const GLuint id = textures_[i].id();
    gl.TextureSubImage2D(id, 0, 0, 0, image.width, image.height, GL_RGBA, GL_UNSIGNED_BYTE, image.texels.data());
    gl.GenerateTextureMipmap(id);
    gl.TextureParameteri(id, GL_TEXTURE_WRAP_S, GLint(WrapMode(texture.wrap_s)));
    gl.TextureParameteri(id, GL_TEXTURE_WRAP_T, GLint(WrapMode(texture.wrap_t)));
    gl.TextureParameteri(id, GL_TEXTURE_MIN_FILTER, texture.is_nearest ? GL_NEAREST : GL_LINEAR_MIPMAP_LINEAR);
    gl.TextureParameteri(id, GL_TEXTURE_MAG_FILTER, texture.is_nearest ? GL_NEAREST : GL_LINEAR);
  }
  has_materials_ = true;
  return context.Check("scene/materials");
}

uint64_t SceneOnContext::SizeBytes() const {
  uint64_t bytes = geometry_bytes_ + attribute_bytes_;
  for (const gl::Texture& texture : textures_) bytes += texture.SizeBytes();
  return bytes;
}

const gl::Texture* SceneOnContext::base_color_texture(uint32_t material) const {
  const int32_t texture = texture_of_material_[material];
  return texture < 0 ? nullptr : &textures_[texture];
}

}  // namespace halfshade
