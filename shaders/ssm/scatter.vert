// The penumbra extent of one patch, as a quad on the soft shadow map; no vertex buffer. Wide enough for the furthest
// receiver under it: the smallest w, from a pyramid, where the paper takes one depth for all.
layout(std430, binding = 2) readonly buffer Patches { vec4 patches[]; };  // column, row, w, covered share
layout(std430, binding = 3) readonly buffer Ranges { vec2 ranges[]; };    // smallest and largest w, level after level

uniform int map_size;  // texels a side of the soft shadow map
uniform vec2 window_low;
uniform float slope_per_texel;
uniform float least_w;  // of all receivers
uniform int base_side;
uniform vec2 light_point;
uniform vec2 half_edges;
uniform vec2 first_edge;  // of the first patch
uniform vec2 slope_per_patch;

flat out vec4 micro_patch;

const int kBaseTexels = 4;
const float kMargin = 1.0 / 64.0;  // GL snaps corners to parts of a texel
const vec2 kCorners[6] = vec2[6](vec2(0, 0), vec2(1, 0), vec2(1, 1), vec2(0, 0), vec2(1, 1), vec2(0, 1));

// Low and high corner in texels, of receivers from w on up to the patch's own.
vec4 Extent(vec4 p, float w) {
  vec2 reach = half_edges * (p.z - w);
  vec2 low_edge = first_edge + p.xy * slope_per_patch;
  vec2 low = low_edge + min(light_point * p.z, light_point * w - reach);
  vec2 high = low_edge + slope_per_patch + max(light_point * p.z, light_point * w + reach);
  vec4 extent = (vec4(low, high) - window_low.xyxy) / slope_per_texel + kMargin * vec4(-1.0, -1.0, 1.0, 1.0);
  return clamp(extent, 0.0, float(map_size));
}

bool IsEmpty(vec4 extent) { return any(lessThanEqual(extent.zw, extent.xy)); }

// Infinite where there is nobody.
float LeastUnder(vec4 extent) {
  ivec2 low = ivec2(extent.xy) / kBaseTexels;
  ivec2 high = (ivec2(ceil(extent.zw)) - 1) / kBaseTexels;
  int first = 0;
  int side = base_side;
  while (any(greaterThan(high - low, ivec2(1)))) {
    first += side * side;
    side = (side + 1) / 2;
    low /= 2;
    high /= 2;
  }
  float below = min(ranges[first + low.y * side + low.x].x, ranges[first + low.y * side + high.x].x);
  return min(below, min(ranges[first + high.y * side + low.x].x, ranges[first + high.y * side + high.x].x));
}

void main() {
  vec4 p = patches[gl_VertexID / 6];
  vec4 extent = Extent(p, least_w);
  float w = least_w;
  if (p.z > w && !IsEmpty(extent)) {
    w = LeastUnder(extent);
    if (w < p.z) extent = Extent(p, w);
  }
  bool is_seen = p.z > w && !IsEmpty(extent);
  micro_patch = p;
  vec2 corner = mix(extent.xy, extent.zw, kCorners[gl_VertexID % 6]);
  gl_Position = is_seen ? vec4(corner * (2.0 / float(map_size)) - 1.0, 0.0, 1.0) : vec4(2.0, 2.0, 0.0, 1.0);
}
