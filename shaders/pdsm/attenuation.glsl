// Attenuation functions of a PDSM (renderer/shadow/pdsm/attenuation.h): the hidden fraction of a light at a depth of a ray.
// depth = z_near / z. St-Amour et al. 2005, 4.1: there textures of indices and data, here buffers of the same.

uniform int pdsm_size;        // rays a side
uniform vec2 first_center;    // slopes of the first ray
uniform vec2 slope_per_ray;
uniform float z_near;

#ifdef HAS_VOLUME
// At depths from 0 to 1 (slice_builder.h: SliceSpacing): hidden samples, and those of them hidden from beyond the next slice.
uniform usampler2DArray volume;
uniform int slices;
uniform int slices_behind;     // spaced by squares from 0 to
uniform float occluders_from;  // here; the rest evenly to 1
uniform int point_count;

// A line from the slice nearer to the light to the farther one. own_rise: how much faster than depth along a ray the depth
// of the receiver's plane may change in a sample's map, at most (1: no plane). Over one slice, what hides more at the
// farther slice may be that plane, and is left out. Below 0: of the plane's two sides the farther one is asked for, and
// the farther slice tells it.
float AttenuationOfRay(ivec2 ray, float depth, float own_rise) {
  float among = clamp((depth - occluders_from) / (1.0 - occluders_from), 0.0, 1.0);
  float behind = 1.0 - sqrt(1.0 - clamp(depth / occluders_from, 0.0, 1.0));
  float place = among * float(slices - 1 - slices_behind) + behind * float(slices_behind);
  int below = min(int(place), slices - 2);
  float along = place - float(below);
  float near = float(texelFetch(volume, ivec3(ray, below + 1), 0).r);
  float change = float(texelFetch(volume, ivec3(ray, below), 0).g) - near;
  if (along * own_rise > 1.0) change = min(change, 0.0);
  float hidden = own_rise < 0.0 ? float(texelFetch(volume, ivec3(ray, below), 0).r) : near + change * (1.0 - along);
  return depth < 1.0 ? hidden / float(point_count) : 0.0;
}
#else
layout(std430, binding = 2) readonly buffer FirstVertices { uint first_vertex[]; };
layout(std430, binding = 3) readonly buffer Vertices { vec2 vertices[]; };  // depth, value; from the light outward

float AttenuationOfRay(ivec2 ray, float depth, float own_rise) {
  uint index = uint(ray.y * pdsm_size + ray.x);
  uint begin = first_vertex[index];
  uint end = first_vertex[index + 1u];
  // The first vertex at or beyond the depth.
  uint low = begin, high = end;
  while (low < high) {
    uint middle = (low + high) >> 1u;
    if (vertices[middle].x > depth) {
      low = middle + 1u;
    } else {
      high = middle;
    }
  }
  if (low == begin) return 0.0;
  vec2 before = vertices[low - 1u];
  if (low == end) return before.y;
  vec2 next = vertices[low];
  return mix(before.y, next.y, (before.x - depth) / (before.x - next.x));
}
#endif

// The mean over the box of filter_width texels around a place (in rays from the first one's centre); 0: the nearest ray.
// The depth asked at a ray is `depth` at the place plus depth_per_ray times the way to the ray.
float FilteredAttenuation(vec2 place, float depth, vec2 depth_per_ray, float own_rise, int filter_width) {
  float half_width = 0.5 * float(filter_width);
  vec2 low = filter_width == 0 ? place : place - half_width;
  ivec2 first = ivec2(floor(low + 0.5));
  float sum = 0.0, weights = 0.0;
  // Where no ray is near, no work: loops without a round are skipped on every kind of GL.
  bool is_near = all(greaterThanEqual(first, ivec2(-filter_width))) && all(lessThan(first, ivec2(pdsm_size)));
  int end = is_near ? filter_width : -1;
  for (int y = 0; y <= end; ++y) {
    for (int x = 0; x <= filter_width; ++x) {
      ivec2 ray = first + ivec2(x, y);
      // How much of the ray's texel the box covers.
      vec2 covered = min(vec2(ray) + 0.5, place + half_width) - max(vec2(ray) - 0.5, place - half_width);
      float weight = filter_width == 0 ? 1.0 : max(covered.x, 0.0) * max(covered.y, 0.0);
      bool is_inside = all(greaterThanEqual(ray, ivec2(0))) && all(lessThan(ray, ivec2(pdsm_size)));
      float ray_depth = max(depth + dot(depth_per_ray, vec2(ray) - place), 0.0);
      float value = AttenuationOfRay(clamp(ray, ivec2(0), ivec2(pdsm_size - 1)), ray_depth, own_rise);
      sum += is_inside ? weight * value : 0.0;
      weights += weight;
    }
  }
  return weights > 0.0 ? sum / weights : 0.0;
}
