// Share of a light (rectangle, line or point: half edges >= 0, in its own frame) above the plane n.x = offset.
// Exact: the area under a line of the unit square, as in volume-of-fluid methods. Total: never divides by zero.
float ShareAbovePlane(vec2 half_edges, vec3 normal, float offset) {
  vec2 reach = abs(normal.xy) * half_edges;  // how far the height above the plane varies along each edge
  float spread = reach.x + reach.y;
  float height = -offset;                    // of the centre
  if (height >= spread) return height > 0.0 ? 1.0 : 0.0;
  if (height <= -spread) return 0.0;
  float small = min(reach.x, reach.y) / spread;
  float large = max(reach.x, reach.y) / spread;
  float level = (spread - abs(height)) / (2.0 * spread);  // in [0, 1/2]: the smaller part
  float part = level < small ? level * level / (2.0 * small * large) : (level - 0.5 * small) / large;
  return height > 0.0 ? 1.0 - part : part;
}
