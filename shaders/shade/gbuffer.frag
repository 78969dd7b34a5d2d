// The receiver plane of the triangle seen through each pixel (shaders/common/receiver.glsl), and what shading needs.
layout(std430, binding = 0) readonly buffer Triangles {
  vec4 planes[];  // mesh frame: unit normal, offset from the mesh's origin
};

flat in mat3x4 camera_from_mesh_transposed;  // world axes, origin at the eye
// Inverse transpose; w of its columns: of the vertices, 2 for what does not receive (common/receiver.glsl) and else 1,
// object id.
flat in mat3x4 normal_from_mesh;
uniform int first_triangle;
uniform bool is_orthographic;
uniform vec3 forward;

layout(location = 0) out vec4 receiver_plane;
layout(location = 7) out float out_object_id;  // dropped where no output needs it

#if defined(HAS_MATERIAL) || defined(HAS_MASK)
in vec4 texcoords;
in vec4 vertex_color;
uniform vec4 base_color;
uniform int second_texcoord;  // a bit per texture that reads TEXCOORD_1

vec2 Texcoord(int bit) { return (second_texcoord & bit) != 0 ? texcoords.zw : texcoords.xy; }
#endif
#ifdef HAS_MASK
#include "common/mask.glsl"
uniform float alpha_cutoff;
#endif
#ifdef HAS_MATERIAL
in vec3 shading_normal;
uniform float metallic;
uniform float roughness;
uniform vec3 emissive;
layout(location = 1) out vec4 out_normal;      // a: roughness
layout(location = 2) out vec4 out_base_color;  // a: metallic
layout(location = 3) out vec4 out_emission;    // a: occlusion of ambient light
#endif
#ifdef HAS_BASE_COLOR_TEXTURE
uniform sampler2D base_color_texture;
#endif
#ifdef HAS_MAPS
#include "shade/normal_map.glsl"
uniform sampler2D metallic_roughness_texture;
uniform sampler2D occlusion_texture;
uniform sampler2D emissive_texture;
uniform float occlusion_strength;
#endif

void main() {
  vec4 plane = planes[first_triangle + gl_PrimitiveID];
  vec3 normal = normalize(mat3(normal_from_mesh) * plane.xyz);
  vec3 point = transpose(camera_from_mesh_transposed) * vec4(plane.xyz * plane.w, 1.0);
  float offset = dot(normal, point);
  bool is_turned_away = is_orthographic ? dot(normal, forward) > 0.0 : offset > 0.0;
  if (is_turned_away) {
    normal = -normal;
    offset = -offset;
  }
  receiver_plane = vec4(normal, offset) * normal_from_mesh[1].w;
  out_object_id = normal_from_mesh[2].w;
#ifdef HAS_MATERIAL
  // glTF: without a normal the geometric one shades; seen from behind, the normal turns round.
  float len = length(shading_normal);
  vec3 smooth_normal = len > 0.0 ? shading_normal / len : gl_FrontFacing ? normal : -normal;
  // White comes out of the interpolation an ulp below 1, which drivers that truncate halves would make 2^-11 of it.
  vec4 color = base_color * vertex_color * (1.0 + 4.0 * 1.1920929e-7);
  vec3 emitted = emissive;
  float metal = metallic;
  float rough = roughness;
  float occlusion = 1.0;
#ifdef HAS_BASE_COLOR_TEXTURE
  color *= texture(base_color_texture, Texcoord(1));
#endif
#ifdef HAS_MAPS
  vec4 metal_and_rough = texture(metallic_roughness_texture, Texcoord(2));
  metal *= metal_and_rough.b;
  rough *= metal_and_rough.g;
  smooth_normal = MapNormal(smooth_normal, Texcoord(4));
  occlusion = mix(1.0, texture(occlusion_texture, Texcoord(8)).r, occlusion_strength);
  emitted *= texture(emissive_texture, Texcoord(16)).rgb;
#endif
  out_normal = vec4(gl_FrontFacing ? smooth_normal : -smooth_normal, rough);
  out_base_color = vec4(color.rgb, metal);
  out_emission = vec4(emitted, occlusion);
#endif
#ifdef HAS_MASK
  // Last: what follows a discard has no derivatives.
  if (IsMaskedAway(Texcoord(1), base_color.a * vertex_color.a, alpha_cutoff)) discard;
#endif
}
