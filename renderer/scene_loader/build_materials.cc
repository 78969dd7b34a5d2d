#include "renderer/scene_loader/build_materials.h"

#include <cmath>
#include <string>
#include <utility>

#include "renderer/scene_loader/decode_image.h"
#include "renderer/scene_loader/tinygltf.h"

namespace halfshade {
namespace {

std::string Pointer(const char* array, size_t index) { return std::string("/") + array + "/" + std::to_string(index); }

Wrap ToWrap(int mode) {
  return mode == TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE     ? Wrap::kClampToEdge
         : mode == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT ? Wrap::kMirroredRepeat
                                                         : Wrap::kRepeat;
}

// By the first bytes.
std::string NameOfFormat(const std::string& bytes) {
  if (bytes.starts_with("\xabKTX 20\xbb")) return "a KTX2 image";
  if (bytes.starts_with("RIFF") && bytes.substr(0, 12).ends_with("WEBP")) return "a WebP image";
  if (bytes.starts_with("DDS ")) return "a DDS image";
  return "an unknown image";
}

// KHR_texture_transform: translation * rotation * scale, as its specification multiplies them.
glm::dmat3 TextureTransform(const Json& extension) {
  const auto pair = [&](const char* key, double absent) {
    if (!extension.contains(key)) return glm::dvec2(absent);
    return glm::dvec2(extension[key][0].get<double>(), extension[key][1].get<double>());
  };
  const glm::dvec2 offset = pair("offset", 0), scale = pair("scale", 1);
  const double angle = extension.value("rotation", 0.0), c = std::cos(angle), s = std::sin(angle);
  return {{c * scale.x, -s * scale.x, 0}, {s * scale.y, c * scale.y, 0}, {offset.x, offset.y, 1}};
}

// glTF leaves an absent filter (-1) to us: linear, with mips.
bool MinifiesToNearest(int filter) {
  return filter == TINYGLTF_TEXTURE_FILTER_NEAREST || filter == TINYGLTF_TEXTURE_FILTER_NEAREST_MIPMAP_NEAREST ||
         filter == TINYGLTF_TEXTURE_FILTER_NEAREST_MIPMAP_LINEAR;
}

MipFilter ToMipFilter(int filter) {
  switch (filter) {
    case TINYGLTF_TEXTURE_FILTER_NEAREST:
    case TINYGLTF_TEXTURE_FILTER_LINEAR:
      return MipFilter::kNone;
    case TINYGLTF_TEXTURE_FILTER_NEAREST_MIPMAP_NEAREST:
    case TINYGLTF_TEXTURE_FILTER_LINEAR_MIPMAP_NEAREST:
      return MipFilter::kNearest;
    default:
      return MipFilter::kLinear;
  }
}

class MaterialBuilder {
 public:
  MaterialBuilder(const GltfData& data, const SceneLoadLimits& limits, Gltf* gltf, FlatScene* scene)
      : model_(*data.model), limits_(limits), gltf_(*gltf), scene_(*scene) {}

  std::vector<TexcoordSources> Build() {
    BuildImages();
    BuildTextures();
    for (size_t i = 0; i < model_.materials.size(); ++i) BuildMaterial(model_.materials[i], Pointer("materials", i));
    scene_.materials.emplace_back();  // glTF's default
    texcoords_.emplace_back();
    return std::move(texcoords_);
  }

 private:
  // Images that we cannot read are left out: their textures' materials keep their factor alone.
  void BuildImages() {
    for (size_t i = 0; i < gltf_.images.size(); ++i) {
      EncodedImage image{Pointer("images", i), std::string(gltf_.images[i])};
      const ImageHeader header = ReadImageHeader(image.bytes);
      image.width = header.width;
      image.height = header.height;
      image_of_gltf_.push_back(-1);
      if (header.format == ImageFormat::kUnknown) {
        gltf_.warnings.Add(image.name, NameOfFormat(image.bytes) + ", not a PNG or a JPEG; its textures are left out");
      } else if (!header.IsWithin(limits_.max_texture_pixels)) {
        gltf_.warnings.Add(image.name, std::to_string(header.width) + " x " + std::to_string(header.height) +
                                           " pixels are over the limit; its textures are left out");
      } else {
        image_of_gltf_.back() = int32_t(scene_.images.size());
        scene_.images.push_back(std::move(image));
      }
    }
  }

  void BuildTextures() {
    for (const tinygltf::Texture& source : model_.textures) {
      const int32_t image = source.source < 0 ? -1 : image_of_gltf_[size_t(source.source)];
      const Place place(gltf_.textures[texture_of_gltf_.size()], Pointer("textures", texture_of_gltf_.size()));
      for (const char* name : {"KHR_texture_basisu", "EXT_texture_webp"}) {
        if (!place.HasExtension(name)) continue;
        gltf_.warnings.Add(place.Extension(name).pointer(),
                           image < 0 ? "is not read, and there is no other image; the texture is left out"
                                     : "is not read; the texture's other image is drawn");
      }
      texture_of_gltf_.push_back(-1);
      if (image < 0) continue;
      texture_of_gltf_.back() = int32_t(scene_.textures.size());
      Texture texture;
      texture.image = uint32_t(image);
      if (source.sampler >= 0) {
        const tinygltf::Sampler& sampler = model_.samplers[size_t(source.sampler)];
        texture.wrap_s = ToWrap(sampler.wrapS);
        texture.wrap_t = ToWrap(sampler.wrapT);
        texture.magnifies_to_nearest = sampler.magFilter == TINYGLTF_TEXTURE_FILTER_NEAREST;
        texture.minifies_to_nearest = MinifiesToNearest(sampler.minFilter);
        texture.mip_filter = ToMipFilter(sampler.minFilter);
      }
      scene_.textures.push_back(texture);
    }
  }

  // The texture info at owner[key], if there is one. Sets of coordinates get their place in `sources`: the file's first
  // two as they are where that does for all of the material, else two as they come.
  MaterialTexture BuildMaterialTexture(const Place& owner, const char* key, bool keeps_sets, TexcoordSources* sources) {
    MaterialTexture result;
    if (!owner.Has(key)) return result;
    const Place info = owner.Member(key);
    result.texture = texture_of_gltf_[info.json()["index"].get<size_t>()];
    if (result.texture < 0) gltf_.warnings.Add(info.pointer(), "has no image that can be read; left out");
    const TexcoordSource source = SourceOf(info);
    if (keeps_sets) {
      result.texcoord = uint8_t(source.set);
      (*sources)[result.texcoord] = source;
      return result;
    }
    for (uint8_t i = 0; i < 2; ++i) {
      if (!(*sources)[i].is_used) (*sources)[i] = source;
      if ((*sources)[i] == source) {
        result.texcoord = i;
        return result;
      }
    }
    gltf_.warnings.Add(info.pointer(), "a third way to read texture coordinates; drawn with the material's first one");
    return result;
  }

  static TexcoordSource SourceOf(const Place& info) {
    TexcoordSource source;
    source.is_used = true;
    source.set = info.json().value("texCoord", 0);
    if (!info.HasExtension("KHR_texture_transform")) return source;
    const Json& extension = info.Extension("KHR_texture_transform").json();
    source.set = extension.value("texCoord", source.set);
    source.transform = TextureTransform(extension);
    return source;
  }

  static bool KeepsSets(const Place& material, const Place& pbr) {
    const auto keeps = [](const Place& owner, const char* key) {
      if (!owner.Has(key)) return true;
      const TexcoordSource source = SourceOf(owner.Member(key));
      return source.set <= 1 && source.transform == glm::dmat3(1);
    };
    return keeps(pbr, "baseColorTexture") && keeps(pbr, "metallicRoughnessTexture") &&
           keeps(material, "normalTexture") && keeps(material, "occlusionTexture") &&
           keeps(material, "emissiveTexture");
  }

  void BuildMaterial(const tinygltf::Material& source, const std::string& pointer) {
    static const Json& nothing = *new Json(Json::object());
    const tinygltf::PbrMetallicRoughness& pbr = source.pbrMetallicRoughness;
    const Place place(gltf_.materials[scene_.materials.size()], pointer);
    const Place pbr_place =
        place.Has("pbrMetallicRoughness") ? place.Member("pbrMetallicRoughness") : Place(nothing, "");
    const bool keeps_sets = KeepsSets(place, pbr_place);
    TexcoordSources sources;
    const auto texture = [&](const Place& owner, const char* key) {
      return BuildMaterialTexture(owner, key, keeps_sets, &sources);
    };
    Material material;
    material.name = source.name;
    for (int i = 0; i < 4; ++i) material.base_color[i] = float(pbr.baseColorFactor[size_t(i)]);
    material.base_color_texture = texture(pbr_place, "baseColorTexture");
    material.metallic = float(pbr.metallicFactor);
    material.roughness = float(pbr.roughnessFactor);
    material.metallic_roughness_texture = texture(pbr_place, "metallicRoughnessTexture");
    material.normal_texture = texture(place, "normalTexture");
    material.normal_scale = float(source.normalTexture.scale);
    material.occlusion_texture = texture(place, "occlusionTexture");
    material.occlusion_strength = float(source.occlusionTexture.strength);
    double strength = 1;
    if (place.HasExtension("KHR_materials_emissive_strength")) {
      strength = place.Extension("KHR_materials_emissive_strength").json().value("emissiveStrength", 1.0);
    }
    for (int i = 0; i < 3; ++i) material.emissive[i] = float(source.emissiveFactor[size_t(i)] * strength);
    material.emissive_texture = texture(place, "emissiveTexture");
    material.alpha_mode = source.alphaMode == "MASK"    ? AlphaMode::kMask
                          : source.alphaMode == "BLEND" ? AlphaMode::kBlend
                                                        : AlphaMode::kOpaque;
    material.alpha_cutoff = material.alpha_mode == AlphaMode::kBlend ? kBlendCutoff : float(source.alphaCutoff);
    material.is_double_sided = source.doubleSided;
    if (place.HasExtension("KHR_materials_unlit")) MakeUnlit(&material);
    scene_.materials.push_back(material);
    sources[0].is_used = true;
    texcoords_.push_back(sources);
  }

  // It gives off its base colour, and reflects nothing: a metal of black.
  static void MakeUnlit(Material* material) {
    material->emissive = glm::vec3(material->base_color);
    material->emissive_texture = material->base_color_texture;
    material->base_color = glm::vec4(0, 0, 0, material->base_color.a);
    material->metallic = 1;
    material->roughness = 1;
    material->metallic_roughness_texture = material->normal_texture = material->occlusion_texture = {};
  }

  const tinygltf::Model& model_;
  const SceneLoadLimits& limits_;
  Gltf& gltf_;
  FlatScene& scene_;
  std::vector<int32_t> image_of_gltf_, texture_of_gltf_;  // -1: left out
  std::vector<TexcoordSources> texcoords_;                // by material
};

}  // namespace

std::vector<TexcoordSources> BuildMaterials(const GltfData& data, const SceneLoadLimits& limits, Gltf* gltf,
                                            FlatScene* scene) {
  return MaterialBuilder(data, limits, gltf, scene).Build();
}

}  // namespace halfshade
