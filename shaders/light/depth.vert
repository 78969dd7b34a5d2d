// Depth of occluders from one point of the light: stores d = z_near / z = w z_near (reversed, far plane at infinity).
layout(location = 0) in vec3 position_ls;
#ifdef HAS_MASK
layout(location = 1) in vec3 mask_vertex;  // texture coordinate, alpha
out vec3 texcoord_and_alpha;
#endif
#ifdef HAS_BLEND
layout(location = 2) in vec3 blend_place;  // renderer/scene/blend.h
out vec3 blend_place_here;
#endif

uniform mat3 map_from_light;    // axes of the map: a permutation, exact
uniform vec3 sample_position;   // the light's point, in the map's axes
uniform vec4 ndc_from_slope;    // ndc = slope * xy + zw
uniform float z_near;

void main() {
  vec3 p = map_from_light * position_ls - sample_position;
  gl_Position = vec4(p.xy * ndc_from_slope.xy + p.z * ndc_from_slope.zw, z_near, p.z);
#ifdef HAS_MASK
  texcoord_and_alpha = mask_vertex;
#endif
#ifdef HAS_BLEND
  blend_place_here = blend_place;
#endif
}
