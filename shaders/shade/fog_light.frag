// Adds what the fog at one point of each pixel's view scatters of one light toward the eye.
#include "common/receiver.glsl"
#include "shade/fog.glsl"

layout(location = 0) out vec4 color;

uniform sampler2D visibility;
uniform vec2 half_edges;
uniform vec3 emitted;        // radiance of a rectangle, intensity of a line or point; exposed; times albedo / step_count
uniform float light_height;  // of the light's centre over the fog's ground
uniform vec3 up;             // in the light's frame

// Solid angle of a triangle with a corner at `a` and these unit vectors (Van Oosterom and Strackee 1983).
float SolidAngle(vec3 a, vec3 b, vec3 c) {
  return 2.0 * abs(atan(dot(a, cross(b, c)), 1.0 + dot(a, b) + dot(b, c) + dot(c, a)));
}

float PointFluence(vec3 from_light) {
  float squared = dot(from_light, from_light);
  return squared > 0.0 ? from_light.z / (squared * sqrt(squared)) : 0.0;
}

// Of unit radiance or intensity, over all directions.
float Fluence(vec3 position) {
#if defined(SHAPE_POINT)
  return PointFluence(position);
#elif defined(SHAPE_LINE)
  const int kParts = 8;
  float sum = 0.0;
  for (int i = 0; i < kParts; ++i) {
    float along = (2.0 * float(i) + 1.0) / float(kParts) - 1.0;
    sum += PointFluence(position - vec3(along * half_edges, 0.0));
  }
  return sum / float(kParts);
#else
  vec3 a = normalize(vec3(-half_edges.x, -half_edges.y, 0.0) - position);
  vec3 b = normalize(vec3(half_edges.x, -half_edges.y, 0.0) - position);
  vec3 c = normalize(vec3(half_edges.x, half_edges.y, 0.0) - position);
  vec3 d = normalize(vec3(-half_edges.x, half_edges.y, 0.0) - position);
  return SolidAngle(a, b, c) + SolidAngle(a, c, d);
#endif
}

void main() {
  Receiver receiver = FetchReceiver(gl_FragCoord.xy);
  vec3 position = receiver.position;
  float opacity = texelFetch(points, ivec2(gl_FragCoord.xy), 0).a;
  float visible = texelFetch(visibility, ivec2(gl_FragCoord.xy), 0).r;
  float way_m = length(position);
  float climb = way_m > 0.0 ? dot(position, up) / way_m : 0.0;
  float arrives = exp(-OpticalDepth(ExtinctionAt(light_height), climb, way_m));
  const float kIsotropic = 0.0795774715;  // 1 / (4 pi)
  float scattered = position.z > 0.0 ? kIsotropic * Fluence(position) * visible * arrives * opacity : 0.0;
  color = vec4(emitted * scattered, 0.0);
}
