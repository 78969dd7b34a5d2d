// What one depth map shows around a point of it, and whether that stands above a receiver's plane: the bias rule of every
// map (renderer/light/README.md).

const float kUlp = 1.1920929e-7;
const float kSteepest = 8.0;  // slopes against the light's plane that are carried on; steeper ones are silhouettes

// Depths are w z_near.
struct MapTexel {
  vec2 cell;
  float depth;       // at the texel's centre
  float depth_here;  // the surface carried by its slope to the point asked for, where it falls off toward it
};

// `texel`: in texels from the map's corner.
MapTexel FetchMapTexel(sampler2DArray maps, float layer, float map_size, vec2 slope_per_texel, vec2 texel) {
  MapTexel result;
  result.cell = clamp(floor(texel), 0.0, map_size - 1.0);
  vec2 from_center = texel - 0.5 - result.cell;
  // One gather at the corner that the texel shares with its neighbours away from the point.
  bvec2 is_before = lessThan(from_center, vec2(0.0));
  vec4 quad = textureGather(maps, vec3((result.cell + vec2(is_before)) / map_size, layer));
  vec2 own_row = is_before.y ? quad.wz : quad.xy;
  vec2 other_row = is_before.y ? quad.xy : quad.wz;
  result.depth = is_before.x ? own_row.x : own_row.y;
  vec2 away = is_before.x ? vec2(own_row.y, other_row.x) : vec2(own_row.x, other_row.y);
  vec2 fall = min(away - result.depth, kSteepest * result.depth * slope_per_texel);
  result.depth_here = result.depth - dot(max(fall, 0.0), abs(from_center));
  return result;
}

// Over 0 where something of inverse depth w in the direction (u, v) stands above the plane that a point of the light is
// `height` above (below: negative), by more than 4 ulps and the plane's own error; in units of (normal . (u, v, 1)).
float HeightAbovePlane(float w, vec2 direction, float height, float error, vec3 normal) {
  return w * (height - 4.0 * kUlp * abs(height) - error) + dot(normal.xy, direction) + normal.z;
}
