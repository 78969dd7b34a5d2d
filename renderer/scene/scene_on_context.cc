#include "renderer/scene/scene_on_context.h"

#include <glad/gl.h>

#include <algorithm>

#include "renderer/gl/turn.h"
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

GLenum MinFilter(const Texture& texture) {
  const bool is_nearest = texture.minifies_to_nearest;
  switch (texture.mip_filter) {
    case MipFilter::kNone:
      return is_nearest ? GL_NEAREST : GL_LINEAR;
    case MipFilter::kNearest:
      return is_nearest ? GL_NEAREST_MIPMAP_NEAREST : GL_LINEAR_MIPMAP_NEAREST;
    case MipFilter::kLinear:
      break;
  }
  return is_nearest ? GL_NEAREST_MIPMAP_LINEAR : GL_LINEAR_MIPMAP_LINEAR;
}

std::shared_ptr<const gl::Sampler> MakeSampler(const gl::Context& context, const Texture& texture) {
  auto sampler = std::make_shared<const gl::Sampler>(gl::Sampler::Create(context));
  const auto set = [&](GLenum name, GLenum value) {
    context.gl().SamplerParameteri(sampler->id(), name, GLint(value));
  };
  set(GL_TEXTURE_WRAP_S, WrapMode(texture.wrap_s));
  set(GL_TEXTURE_WRAP_T, WrapMode(texture.wrap_t));
  set(GL_TEXTURE_MIN_FILTER, MinFilter(texture));
  set(GL_TEXTURE_MAG_FILTER, texture.magnifies_to_nearest ? GL_NEAREST : GL_LINEAR);
  return sampler;
}

std::vector<uint8_t> AlphaOf(const Rgba8Image& image) {
  std::vector<uint8_t> alpha(image.texels.size() / 4);
  for (size_t i = 0; i < alpha.size(); ++i) alpha[i] = image.texels[4 * i + 3];
  return alpha;
}

}  // namespace

void SampledTexture::Bind(int unit) const {
  texels->Bind(unit);
  texels->gl().BindSampler(GLuint(unit), sampler->id());
}

void SetAbsentAttributes(const gl::Context& context) {
  const GladGLContext& gl = context.gl();
  gl.VertexAttrib3f(1, 0, 0, 0);
  gl.VertexAttrib2f(2, 0, 0);
  gl.VertexAttrib2f(3, 0, 0);
  gl.VertexAttrib4f(4, 0, 0, 0, 0);
  gl.VertexAttrib4f(5, 1, 1, 1, 1);
}

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
  result->size_bytes_ = scene.positions.size() * sizeof(glm::vec3) + scene.indices.size() * sizeof(uint32_t) +
                        scene.indices.size() / 3 * sizeof(glm::vec4);
  RETURN_IF_ERROR(context.Check("scene/upload"));
  return result;
}

template <typename T>
absl::Status SceneOnContext::AddAttribute(const DrawContext& draw, unsigned index, const std::vector<T>& values) {
  if (values.empty()) return absl::OkStatus();
  ASSIGN_OR_RETURN(gl::Buffer buffer, gl::Buffer::Create(*draw.context, values));
  vertex_array_.SetFloats(index, T::length(), buffer.id());
  attributes_.push_back(std::move(buffer));
  size_bytes_ += values.size() * sizeof(T);
  return absl::OkStatus();
}

absl::StatusOr<gl::Texture> SceneOnContext::MakeTexture(const DrawContext& draw, const Rgba8Image& image, Use use) {
  const gl::Context& context = *draw.context;
  const GladGLContext& gl = context.gl();
  gl.PixelStorei(GL_UNPACK_ALIGNMENT, 1);
  if (use == Use::kAlpha) {
    ASSIGN_OR_RETURN(gl::Texture texture, gl::Texture::Create2D(context, GL_R8, image.width, image.height));
    gl.TextureSubImage2D(texture.id(), 0, 0, 0, image.width, image.height, GL_RED, GL_UNSIGNED_BYTE,
                         AlphaOf(image).data());
    return texture;
  }
  ASSIGN_OR_RETURN(gl::Texture texture,
                   gl::Texture::Create2DWithMips(context, use == Use::kSrgb ? GL_SRGB8_ALPHA8 : GL_RGBA8, image.width,
                                                 image.height));
  gl.TextureSubImage2D(texture.id(), 0, 0, 0, image.width, image.height, GL_RGBA, GL_UNSIGNED_BYTE,
                       image.texels.data());
  gl.GenerateTextureMipmap(texture.id());
  return texture;
}

absl::Status SceneOnContext::Upload(const DrawContext& draw, const FlatScene& scene, const ImageDecoder& decoder,
                                    const std::vector<Wanted>& wanted) {
  // Each image is decoded once, for all of its uses that are new.
  std::map<uint32_t, std::vector<Use>> uses;
  for (const Wanted& want : wanted) {
    const uint32_t image = scene.textures[size_t(want.source.texture)].image;
    const bool is_new = !images_.contains({image, want.use});
    std::vector<Use>& of_image = uses[image];
    if (is_new && std::find(of_image.begin(), of_image.end(), want.use) == of_image.end()) of_image.push_back(want.use);
  }
  for (const auto& [image, of_image] : uses) {
    if (of_image.empty()) continue;
    const auto decode = [&] {
      const gl::TurnPause pause;
      return decoder(scene.images[image]);
    };
    ASSIGN_OR_RETURN(const Rgba8Image texels, decode());
    ++decoded_images_;
    for (const Use use : of_image) {
      ASSIGN_OR_RETURN(gl::Texture texture, MakeTexture(draw, texels, use));
      size_bytes_ += texture.SizeBytes();
      images_[{image, use}] = std::make_shared<const gl::Texture>(std::move(texture));
    }
  }
  for (const Wanted& want : wanted) {
    const size_t texture = size_t(want.source.texture);
    if (samplers_[texture] == nullptr) samplers_[texture] = MakeSampler(*draw.context, scene.textures[texture]);
    *want.target = {images_[{scene.textures[texture].image, want.use}], samplers_[texture]};
  }
  return draw.context->Check("scene/textures");
}

absl::Status SceneOnContext::NeedTextures(const DrawContext& draw, const FlatScene& scene, const ImageDecoder& decoder,
                                          bool with_materials) {
  const bool is_all_here = with_materials ? has_materials_ : has_masks_;
  if (is_all_here || scene.indices.empty()) return absl::OkStatus();
  if (!has_masks_) {
    textures_.resize(scene.materials.size());
    samplers_.resize(scene.textures.size());
    RETURN_IF_ERROR(AddAttribute(draw, 2, scene.texcoords));
    RETURN_IF_ERROR(AddAttribute(draw, 3, scene.texcoords1));
    RETURN_IF_ERROR(AddAttribute(draw, 5, scene.colors));
  }
  std::vector<bool> has_mesh(scene.materials.size(), false), has_mask(scene.materials.size(), false);
  for (const Mesh& mesh : scene.meshes) {
    has_mesh[mesh.material] = true;
    if (scene.CoverageOf(mesh) == MaskCoverage::kTested) has_mask[mesh.material] = true;
  }
  std::vector<Wanted> wanted;
  const auto want = [&](const MaterialTexture& source, Use use, SampledTexture* target) {
    if (source.texture >= 0) wanted.push_back({source, use, target});
  };
  for (size_t i = 0; i < scene.materials.size(); ++i) {
    const Material& material = scene.materials[i];
    MaterialTextures& textures = textures_[i];
    if (has_mask[i]) want(material.base_color_texture, Use::kAlpha, &textures.mask);
    if (!has_mesh[i] || !with_materials) continue;
    want(material.base_color_texture, Use::kSrgb, &textures.base_color);
    want(material.metallic_roughness_texture, Use::kLinear, &textures.metallic_roughness);
    want(material.normal_texture, Use::kLinear, &textures.normal);
    want(material.occlusion_texture, Use::kLinear, &textures.occlusion);
    want(material.emissive_texture, Use::kSrgb, &textures.emissive);
  }
  RETURN_IF_ERROR(Upload(draw, scene, decoder, wanted));
  has_masks_ = true;
  if (!with_materials) return absl::OkStatus();
  RETURN_IF_ERROR(AddAttribute(draw, 1, scene.normals));
  RETURN_IF_ERROR(AddAttribute(draw, 4, scene.tangents));
  has_materials_ = true;
  return absl::OkStatus();
}

}  // namespace halfshade
