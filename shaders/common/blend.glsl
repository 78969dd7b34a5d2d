// glTF's alphaMode BLEND for light: the twin of renderer/scene/blend.h, which says what it is.
const float kBlendCells = 4096.0;

uvec3 HashWords(uvec3 v) {
  v = v * 1664525u + 1013904223u;
  v.x += v.y * v.z;
  v.y += v.z * v.x;
  v.z += v.x * v.y;
  v ^= v >> 16u;
  v.x += v.y * v.z;
  v.y += v.z * v.x;
  v.z += v.x * v.y;
  return v;
}

// Of the cell of a place.
float BlendThreshold(vec3 place) {
  uvec3 cell = uvec3(clamp(place, 0.0, 2.0 * kBlendCells));
  return (float(HashWords(cell).x >> 9u) + 0.5) * (1.0 / 8388608.0);
}
