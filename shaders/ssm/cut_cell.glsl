// What a receiver's plane leaves of a cell of a light, as a rectangle: the twin of renderer/light/sub_lights.h.
struct LitPart {
  float share;
  vec2 middle;
  vec2 half_edges;
};

LitPart CutLine(float half_edge, float slope, float height, vec2 axis) {
  float low = slope > 0.0 ? clamp(-height / slope, -half_edge, half_edge) : -half_edge;
  float high = slope < 0.0 ? clamp(-height / slope, -half_edge, half_edge) : half_edge;
  if (slope == 0.0 && height <= 0.0) high = low;
  float share = half_edge > 0.0 ? (high - low) / (2.0 * half_edge) : float(height > 0.0);
  return LitPart(share, axis * 0.5 * (low + high), axis * 0.5 * (high - low));
}

LitPart CutCell(vec2 half_edges, vec2 normal, float height) {
  vec2 slope = normal * half_edges;
  float reach = abs(slope.x) + abs(slope.y);
  if (height >= reach && height > 0.0) return LitPart(1.0, vec2(0.0), half_edges);
  if (height <= -reach) return LitPart(0.0, vec2(0.0), vec2(0.0));
  if (half_edges.y == 0.0) return CutLine(half_edges.x, normal.x, height, vec2(1.0, 0.0));
  if (half_edges.x == 0.0) return CutLine(half_edges.y, normal.y, height, vec2(0.0, 1.0));
  const vec2 corners[5] = vec2[5](vec2(-1.0, -1.0), vec2(1.0, -1.0), vec2(1.0, 1.0), vec2(-1.0, 1.0), vec2(-1.0, -1.0));
  vec2 polygon[6];
  int count = 0;
  for (int i = 0; i < 4; ++i) {
    vec2 a = corners[i];
    vec2 b = corners[i + 1];
    float height_a = height + dot(slope, a);
    float height_b = height + dot(slope, b);
    if (height_a > 0.0) polygon[count++] = a;
    if ((height_a > 0.0) != (height_b > 0.0)) polygon[count++] = mix(a, b, height_a / (height_a - height_b));
  }
  float area = 0.0;
  vec2 first = vec2(0.0);
  vec2 second = vec2(0.0);
  for (int i = 1; i + 1 < count; ++i) {
    vec2 a = polygon[0];
    vec2 b = polygon[i];
    vec2 c = polygon[i + 1];
    float twice = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
    area += 0.5 * twice;
    first += (a + b + c) * (twice / 6.0);
    second += (a * a + b * b + c * c + a * b + b * c + c * a) * (twice / 12.0);
  }
  if (!(area > 0.0)) return LitPart(0.0, vec2(0.0), vec2(0.0));
  vec2 middle = first / area;
  vec2 variance = max(second / area - middle * middle, vec2(0.0));
  return LitPart(0.25 * area, middle * half_edges, sqrt(3.0 * variance) * half_edges);
}
