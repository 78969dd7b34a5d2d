// The material seen through a pixel, as the G-buffer keeps it, and how it divides what it reflects.
#include "common/ltc.glsl"

uniform sampler2D normals;      // world axes; a: roughness
uniform sampler2D base_colors;  // a: metallic

struct Surface {
  vec3 normal;
  float roughness;
  vec3 base_color;
  float metallic;
  vec3 f0;  // reflected along the normal: 4 % of dielectrics, the base colour of metals
};

Surface FetchSurface(ivec2 pixel) {
  vec4 normal = texelFetch(normals, pixel, 0);
  vec4 color = texelFetch(base_colors, pixel, 0);
  return Surface(normal.xyz, normal.w, color.rgb, color.a, mix(vec3(0.04), color.rgb, color.a));
}

// Lambert, for the light that the specular of this view leaves: no surface reflects more than it gets.
vec3 DiffuseAlbedo(Surface surface, vec3 specular_albedo) {
  return surface.base_color * (1.0 - surface.metallic) * (1.0 - specular_albedo);
}
