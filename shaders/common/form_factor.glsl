// Irradiance from a light of unit radiance (rectangle) or unit intensity (line, point), cosine of the receiver included.
// Light frame; position and unit normal of the receiver. Exact for diffuse surfaces.

const float kPi = 3.14159265358979;

// Vector from an edge's contribution: angle between a and b times the unit normal of their plane, dotted with n.
float EdgeIrradiance(vec3 a, vec3 b, vec3 n) {
  vec3 across = cross(a, b);
  float sine = length(across);
  float cosine = dot(a, b);
  float angle_over_sine = sine > 1e-6 * abs(cosine) ? atan(sine, cosine) / sine : 1.0 / max(cosine, 1e-30);
  return dot(across, n) * angle_over_sine;
}

// Lambert's formula for the rectangle, clipped to the receiver's horizon. The clipped polygon of a convex one has at most
// one closing edge along the horizon, from where the outline dives to where it rises again.
float RectangleIrradiance(vec2 half_edges, vec3 position, vec3 n) {
  vec3 corners[4] = vec3[4](vec3(-half_edges.x, -half_edges.y, 0.0) - position, vec3(half_edges.x, -half_edges.y, 0.0) - position,
                            vec3(half_edges.x, half_edges.y, 0.0) - position, vec3(-half_edges.x, half_edges.y, 0.0) - position);
  float sum = 0.0;
  vec3 dive = vec3(0.0);
  vec3 rise = vec3(0.0);
  for (int i = 0; i < 4; ++i) {
    vec3 a = corners[i];
    vec3 b = corners[(i + 1) & 3];
    float height_a = dot(a, n);
    float height_b = dot(b, n);
    if (height_a <= 0.0 && height_b <= 0.0) continue;
    vec3 cut = mix(a, b, clamp(height_a / (height_a - height_b), 0.0, 1.0));
    if (height_b < 0.0) {
      b = cut;
      dive = cut;
    } else if (height_a < 0.0) {
      a = cut;
      rise = cut;
    }
    sum += EdgeIrradiance(normalize(a), normalize(b), n);
  }
  if (dive != vec3(0.0) && rise != vec3(0.0)) sum += EdgeIrradiance(normalize(dive), normalize(rise), n);
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
