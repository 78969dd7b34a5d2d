// Windows in the map from a light's centre: where blockers are looked for, and the range of depths that a window holds.
//
// An occluder at inverse depth w hides part of the light from a receiver at w_r only where it is within
// half_edges (w - w_r) of it, in slopes: eq. 1 of Buades et al. 2015, divided by the receiver's depth.

layout(std430, binding = 1) readonly buffer Pyramid {
  vec2 ranges[];  // smallest and largest depth (w z_near) of squares of 4, 8, 16, ... texels, level after level
};
const int kMaxLevels = 12;
uniform vec4 levels[kMaxLevels];  // x: first range of the level, y: squares a side
uniform int level_count;
uniform float map_size;
uniform vec2 first_center;  // of the map's first texel, in slopes
uniform vec2 slope_per_texel;
uniform float z_near;
uniform vec2 half_edges;  // of the light; of a Gaussian one, where it ends

vec2 ToTexel(vec2 slope) { return (slope - first_center) / slope_per_texel + 0.5; }

// Smallest and largest depth of all texels that a fetch within `half_window` of `slope` may read: one more on each side.
vec2 DepthRange(vec2 slope, vec2 half_window) {
  vec2 first = floor(ToTexel(slope - half_window)) - 2.0;
  vec2 last = floor(ToTexel(slope + half_window)) + 2.0;
  if (any(lessThan(last, vec2(0.0))) || any(greaterThan(first, vec2(map_size - 1.0)))) return vec2(0.0);  // beyond the map
  ivec2 low = ivec2(clamp(first, vec2(0.0), vec2(map_size - 1.0))) / 4;
  ivec2 high = ivec2(clamp(last, vec2(0.0), vec2(map_size - 1.0))) / 4;
  int span = max(high.x - low.x, high.y - low.y);
  int level = span <= 1 ? 0 : findMSB(span - 1) + 1;  // where at most two squares a side hold the window
  level = min(level, level_count - 1);
  low >>= level;
  high >>= level;
  int begin = int(levels[level].x);
  int side = int(levels[level].y);
  vec2 range = ranges[begin + low.y * side + low.x];
  vec2 other = ranges[begin + low.y * side + high.x];
  range = vec2(min(range.x, other.x), max(range.y, other.y));
  other = ranges[begin + high.y * side + low.x];
  range = vec2(min(range.x, other.x), max(range.y, other.y));
  other = ranges[begin + high.y * side + high.x];
  return vec2(min(range.x, other.x), max(range.y, other.y));
}

struct BlockerWindow {
  float reach;       // w of the nearest occluder in it, less the receiver's; 0 where none is nearer
  vec2 half_window;  // half_edges * reach, in slopes
  vec2 depths;       // smallest and largest in it
};

// First as if the nearest occluder of the whole map stood over the receiver, then with the nearest in that window.
BlockerWindow FindWindow(vec2 slope, float receiver_w) {
  float nearest = ranges[int(levels[level_count - 1].x)].y / z_near;
  BlockerWindow window;
  for (int i = 0; i < 2; ++i) {
    window.half_window = half_edges * max(nearest - receiver_w, 0.0);
    window.depths = DepthRange(slope, window.half_window);
    nearest = window.depths.y / z_near;
  }
  window.reach = max(nearest - receiver_w, 0.0);
  window.half_window = half_edges * window.reach;
  return window;
}
