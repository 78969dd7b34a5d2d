// A scene's geometry and textures in the buffers of one GL context. Lives on that context's thread.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "renderer/gl/draw_context.h"
#include "renderer/gl/handles.h"
#include "renderer/gl/texture.h"
#include "renderer/renderer.h"
#include "renderer/scene/flat_scene.h"

namespace halfshade {

// An image on the context and how to read it. Shared, so that what is kept for a light may outlive the scene.
struct SampledTexture {
  std::shared_ptr<const gl::Texture> texels;  // null: none
  std::shared_ptr<const gl::Sampler> sampler;
  explicit operator bool() const { return texels != nullptr; }
  void Bind(int unit) const;
};

// What the material of a mesh reads; empty where it has none.
struct MaterialTextures {
  SampledTexture base_color;  // sRGB, with mips
  SampledTexture metallic_roughness, normal, occlusion;
  SampledTexture emissive;  // sRGB
  SampledTexture mask;      // alpha of the base colour in red, the finest level alone
};

class SceneOnContext {
 public:
  // Uploads positions, indices and the plane of every triangle. Normals, texture coordinates and textures follow when a
  // request needs them.
  static absl::StatusOr<std::unique_ptr<SceneOnContext>> Create(const DrawContext& draw, const FlatScene& scene);

  // Uploads what has not been uploaded yet: what decides where MASK materials are (their base colours alone are
  // decoded) and, with_materials, what shading reads (the images of all materials that some mesh has).
  // Errors of the decoder (INVALID_ARGUMENT with the image's JSON pointer) come back as they are.
  absl::Status NeedTextures(const DrawContext& draw, const FlatScene& scene, const ImageDecoder& decoder,
                            bool with_materials);

  // Attributes: 0 position (relative to the mesh's origin); after NeedTextures 2 texture coordinate, 3 the second one,
  // 5 colour; with_materials 1 normal and 4 tangent too. What the scene has none of is as SetAbsentAttributes says.
  const gl::VertexArray& vertex_array() const { return vertex_array_; }
  // vec4 per triangle in the order of FlatScene::indices / 3: unit normal, offset from the mesh's origin along it.
  const gl::Buffer& triangle_planes() const { return triangle_planes_; }
  // After NeedTextures.
  const MaterialTextures& textures(uint32_t material) const { return textures_[material]; }
  uint64_t decoded_images() const { return decoded_images_; }

  uint64_t SizeBytes() const { return size_bytes_; }  // grows with NeedTextures

 private:
  // How the texels of an image are kept.
  enum class Use : uint8_t { kSrgb, kLinear, kAlpha };
  struct Wanted {
    MaterialTexture source;
    Use use;
    SampledTexture* target;
  };
  SceneOnContext() = default;
  template <typename T>
  absl::Status AddAttribute(const DrawContext& draw, unsigned index, const std::vector<T>& values);
  absl::Status Upload(const DrawContext& draw, const FlatScene& scene, const ImageDecoder& decoder,
                      const std::vector<Wanted>& wanted);
  absl::StatusOr<gl::Texture> MakeTexture(const DrawContext& draw, const Rgba8Image& image, Use use);

  gl::VertexArray vertex_array_;
  gl::Buffer positions_, indices_, triangle_planes_;
  std::vector<gl::Buffer> attributes_;
  std::vector<MaterialTextures> textures_;  // one per FlatScene::materials
  std::map<std::pair<uint32_t, Use>, std::shared_ptr<const gl::Texture>> images_;
  std::vector<std::shared_ptr<const gl::Sampler>> samplers_;  // one per FlatScene::textures, made when needed
  bool has_masks_ = false, has_materials_ = false;
  uint64_t decoded_images_ = 0;
  uint64_t size_bytes_ = 0;
};

// For every vertex array without buffers of its own for attributes 1 to 5: no normal, no tangent, white.
void SetAbsentAttributes(const gl::Context& context);

}  // namespace halfshade
