// Irradiance from a light of unit radiance (rectangle) or unit intensity (line, point), cosine of the receiver included.
// Light frame; position and unit normal of the receiver. Exact for diffuse surfaces.

const float kPi = 3.14159265358979;

// One edge's part of a polygon's cosine integral, by Lambert's formula: from a to a + edge, seen from the origin by a
// surface of normal n. The edge is a difference of points of the light, exact for small lights, and vectors are not
// normalised: so a sum over edges loses 1 / angle in precision, not 1 / angle^2.
float EdgeIrradiance(vec3 a, vec3 edge, vec3 n) {
  vec3 across = cross(a, edge);
  float size = length(across);
  float angle = atan(size, dot(a, a + edge));
  return size > 0.0 ? dot(across, n) * (angle / size) : 0.0;
}

// Walking round a convex polygon of the light's plane (z = 0) and keeping what stands above a plane: it dives below at
// most once, and rises at most once.
struct Clip {
  vec3 above;     // height of p over the plane: above . p + height
  float height;
  vec2 dive, rise;
  bool is_cut;
};

Clip MakeClip(vec3 position, vec3 n) { return Clip(n, -dot(position, n), vec2(0.0), vec2(0.0), false); }

// Shortens the edge from a to b to its part above the plane; false if there is none.
bool ClipEdge(inout Clip clip, inout vec2 a, inout vec2 b) {
  float height_a = dot(clip.above.xy, a) + clip.height;
  float height_b = dot(clip.above.xy, b) + clip.height;
  bool has_a = height_a > 0.0;
  bool has_b = height_b > 0.0;
  if (has_a != has_b) {
    vec2 cut = mix(a, b, clamp(height_a / (height_a - height_b), 0.0, 1.0));
    clip.is_cut = true;
    if (has_a) {
      b = cut;
      clip.dive = cut;
    } else {
      a = cut;
      clip.rise = cut;
    }
  }
  return has_a || has_b;
}

// Positions are scaled to about 1, so that no power of a length leaves the range of floats.
float UnitScale(vec2 half_edges, vec3 position) { return 1.0 / (length(position) + half_edges.x + half_edges.y); }

const vec2 kCornerSigns[5] = vec2[5](vec2(-1.0, -1.0), vec2(1.0, -1.0), vec2(1.0, 1.0), vec2(-1.0, 1.0), vec2(-1.0, -1.0));

// Lambert's formula for the rectangle, clipped to the receiver's horizon.
float RectangleIrradiance(vec2 half_edges, vec3 position, vec3 n) {
  float scale = UnitScale(half_edges, position);
  position *= scale;
  half_edges *= scale;
  Clip horizon = MakeClip(position, n);
  float sum = 0.0;
  for (int i = 0; i < 4; ++i) {
    vec2 a = kCornerSigns[i] * half_edges;
    vec2 b = kCornerSigns[i + 1] * half_edges;
    if (ClipEdge(horizon, a, b)) sum += EdgeIrradiance(vec3(a, 0.0) - position, vec3(b - a, 0.0), n);
  }
  if (horizon.is_cut) {
    sum += EdgeIrradiance(vec3(horizon.dive, 0.0) - position, vec3(horizon.rise - horizon.dive, 0.0), n);
  }
  return 0.5 * abs(sum);
}

// A point of unit intensity along the light's normal, falling with the cosine.
float PointIrradiance(vec3 light_point, vec3 position, vec3 n) {
  vec3 to_light = light_point - position;
  float distance2 = dot(to_light, to_light);
  return max(dot(to_light, n), 0.0) * max(-to_light.z, 0.0) / (distance2 * distance2);
}

// A line of unit intensity, spread evenly over its length: the integral of PointIrradiance by 8-point Gauss-Legendre,
// cut at the receiver's horizon.
float LineIrradiance(vec3 half_edge, vec3 position, vec3 n) {
  const float node[4] = float[4](0.1834346424956498, 0.5255324099163290, 0.7966664774136267, 0.9602898564975363);
  const float weight[4] = float[4](0.3626837833783620, 0.3137066458778873, 0.2223810344533745, 0.1012285362903763);
  float low = -1.0;
  float high = 1.0;
  float height = -dot(position, n);
  float slope = dot(half_edge, n);
  if (slope > 0.0) low = clamp(-height / slope, -1.0, 1.0);
  if (slope < 0.0) high = clamp(-height / slope, -1.0, 1.0);
  float sum = 0.0;
  float mid = 0.5 * (low + high);
  float reach = 0.5 * (high - low);
  for (int i = 0; i < 4; ++i) {
    sum += weight[i] * (PointIrradiance(half_edge * (mid - reach * node[i]), position, n) +
                        PointIrradiance(half_edge * (mid + reach * node[i]), position, n));
  }
  return 0.5 * reach * sum;
}
