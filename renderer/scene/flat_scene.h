// The one form of a scene: plain checked arrays, made by renderer/scene_loader, read by everything else.
//
// Right-handed, y up, metres (glTF's world). A FlatScene is valid by construction: every index below is in range, every
// float finite, the node graph a forest. Nothing here owns threads, files or GL objects; it may be copied and
// serialised, and is shared read-only.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <limits>
#include <string>
#include <vector>

#include "renderer/scene/motion_data.h"

namespace halfshade {

// Axis-aligned box. Empty until the first Add (min > max).
template <typename Vec>
struct Box {
  using Scalar = typename Vec::value_type;
  Vec min = Vec(std::numeric_limits<Scalar>::infinity());
  Vec max = Vec(-std::numeric_limits<Scalar>::infinity());
  void Add(const Vec& point) {
    min = glm::min(min, point);
    max = glm::max(max, point);
  }
  bool IsEmpty() const { return !(min.x <= max.x); }
  Vec Center() const { return (min + max) * Scalar(0.5); }
  Vec Extent() const { return IsEmpty() ? Vec(0) : max - min; }
};
using Box3f = Box<glm::vec3>;
using Box3d = Box<glm::dvec3>;

// A run of consecutive triangles of one mesh: the unit of culling and of cutting long GL submissions.
struct Cluster {
  static constexpr uint32_t kMaxTriangles = 256;
  uint32_t first_triangle = 0;  // within the mesh
  uint32_t triangle_count = 0;  // 1..kMaxTriangles
  Box3f bounds;                 // relative to the mesh's origin
};

// One glTF primitive: indexed triangles with one material.
// Positions are stored relative to `origin`, so that geometry far from its node's origin keeps its precision:
// object position = origin + position.
struct Mesh {
  glm::dvec3 origin{0};
  uint32_t first_vertex = 0;  // into FlatScene::positions, normals, texcoords
  uint32_t vertex_count = 0;
  uint32_t first_index = 0;  // into FlatScene::indices; each index is < vertex_count (relative to first_vertex)
  uint32_t index_count = 0;  // a multiple of 3; degenerate triangles are already dropped
  uint32_t first_cluster = 0;
  uint32_t cluster_count = 0;
  uint32_t material = 0;
  Box3f bounds;  // relative to origin; measured, never the file's min/max
  uint32_t TriangleCount() const { return index_count / 3; }
};

struct Node {
  std::string name;
  int32_t parent = -1;        // -1: a root; a parent may stand after its child
  glm::dmat4 local{1};        // column-major; TRS already multiplied
  uint32_t first_mesh = 0;    // the glTF mesh's primitives are consecutive in FlatScene::meshes
  uint32_t mesh_count = 0;    // 0: no mesh
  int32_t camera = -1;        // into FlatScene::cameras
  int32_t skin = -1;          // into FlatScene::skins: its meshes stand in world space (pose.h)
  uint32_t first_place = 0;   // its meshes stand at each of these FlatScene::places; none: at the node once
  uint32_t place_count = 0;   // none where there is a skin
  uint32_t first_weight = 0;  // of morph targets, into FlatScene::morph_weights
  uint32_t weight_count = 0;
};

struct SceneRoots {
  std::string name;
  std::vector<uint32_t> roots;  // nodes
};

enum class AlphaMode : uint8_t { kOpaque, kMask, kBlend };
// The camera draws BLEND where its alpha is at least this, and nothing of it elsewhere; of light it hides alpha's share
// (blend.h).
inline constexpr float kBlendCutoff = 0.5f;

// A texture as a material reads it.
struct MaterialTexture {
  int32_t texture = -1;  // into FlatScene::textures; -1: none
  uint8_t texcoord = 0;  // 0 or 1: FlatScene::texcoords or texcoords1
};

// glTF's metallic-roughness. A factor multiplies its texture; colours are linear, colour textures hold sRGB.
struct Material {
  std::string name;
  glm::vec4 base_color{1};
  MaterialTexture base_color_texture;
  float metallic = 1;
  float roughness = 1;
  MaterialTexture metallic_roughness_texture;  // green: roughness, blue: metallic
  MaterialTexture normal_texture;              // tangent frame, +y up the image
  float normal_scale = 1;
  MaterialTexture occlusion_texture;  // red; for light that comes from everywhere, not for lights
  float occlusion_strength = 1;
  glm::vec3 emissive{0};
  MaterialTexture emissive_texture;
  AlphaMode alpha_mode = AlphaMode::kOpaque;
  float alpha_cutoff = 0.5f;  // of kMask; for the camera, and kBlendCutoff, of kBlend
  bool is_double_sided = false;
};

enum class Wrap : uint8_t { kRepeat, kClampToEdge, kMirroredRepeat };
enum class MipFilter : uint8_t { kNone, kNearest, kLinear };

struct Texture {
  uint32_t image = 0;
  Wrap wrap_s = Wrap::kRepeat;
  Wrap wrap_t = Wrap::kRepeat;
  bool magnifies_to_nearest = false;
  bool minifies_to_nearest = false;  // within a mip level
  MipFilter mip_filter = MipFilter::kLinear;
};

// Still encoded (PNG or JPEG): decoded only for a request that needs it. The header is already checked.
struct EncodedImage {
  std::string name;
  std::string bytes;
  uint32_t width = 0;
  uint32_t height = 0;
};

struct SceneCamera {
  std::string name;
  bool is_orthographic = false;
  double fovy_rad = 0;        // perspective
  double ortho_height_m = 0;  // orthographic: 2 ymag
  double near_m = 0;
  double far_m = 0;  // 0: infinite
};

// kTested: alpha differs over the mesh and is compared where it is drawn.
enum class MaskCoverage : uint8_t { kFull, kTested, kNothing };

struct FlatScene {
  // Per vertex, parallel arrays. A normal is unit, or (0,0,0) where the file has none: then the geometric normal
  // shades, as glTF asks.
  std::vector<glm::vec3> positions;
  std::vector<glm::vec3> normals;
  std::vector<glm::vec2> texcoords;  // TEXCOORD_0, (0,0) where absent
  // Empty where no mesh has, and its material asks for, any.
  std::vector<glm::vec2> texcoords1;  // TEXCOORD_1, (0,0) where absent
  std::vector<glm::vec4> tangents;    // xyz unit, w the sign of the bitangent cross(normal, xyz) w; zeros where absent
  std::vector<glm::vec4> colors;      // COLOR_0, linear, in [0,1]; ones where absent
  std::vector<uint32_t> indices;

  std::vector<Mesh> meshes;
  std::vector<Cluster> clusters;
  std::vector<Material> materials;  // the last one is glTF's default material
  std::vector<Texture> textures;
  std::vector<EncodedImage> images;
  std::vector<Node> nodes;
  std::vector<SceneCamera> cameras;
  std::vector<SceneRoots> scenes;
  uint32_t default_scene = 0;

  std::vector<InstancePlace> places;
  std::vector<float> morph_weights;  // at rest
  std::vector<Skin> skins;
  std::vector<uint32_t> skin_joints;       // nodes
  std::vector<glm::mat4> joint_from_mesh;  // inverse bind matrices
  std::vector<Deformed> deformed;          // the arrays above hold their rest pose
  std::vector<BindVertex> bind_vertices;
  std::vector<uint32_t> bind_indices;
  std::vector<Influence> influences;
  std::vector<MorphDelta> morph_deltas;
  std::vector<Animation> animations;
  std::vector<AnimationChannel> channels;
  std::vector<float> animation_times, animation_values;
  std::vector<Rest> rests;  // of animated nodes, by node

  std::vector<std::string> warnings;  // said for the user, each starts with a JSON pointer
  uint64_t degenerate_triangles_dropped = 0;

  // What alpha leaves of a mesh for light to meet: MASK by its cutoff, BLEND its share (blend.h).
  MaskCoverage CoverageOf(const Mesh& mesh) const;
  // And for the camera: both by their cutoff. Where this is kTested, CoverageOf is.
  MaskCoverage SeenCoverageOf(const Mesh& mesh) const;

  // The cluster `index` of a mesh, from its triangles as they stand.
  Cluster MakeCluster(const Mesh& mesh, uint32_t index) const;

  // Bytes of all arrays: what the scene cache counts.
  size_t SizeBytes() const;
};

}  // namespace halfshade
