// Adds one light to the frame: visibility times unshadowed diffuse light.
#include "common/receiver.glsl"
#include "common/form_factor.glsl"

layout(location = 0) out vec4 color;

uniform sampler2D normals;
uniform sampler2D base_colors;
uniform sampler2D visibility;
uniform vec2 half_edges;
uniform int shape;          // 0 rectangle, 1 line, 2 point
uniform vec3 emitted;       // radiance or intensity, exposed

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  Receiver receiver = FetchReceiver(gl_FragCoord.xy);
  vec3 normal = light_from_camera * texelFetch(normals, pixel, 0).xyz;
  float irradiance = 0.0;
  if (shape == 0) irradiance = RectangleIrradiance(half_edges, receiver.position, normal);
  if (shape == 1) irradiance = LineIrradiance(vec3(half_edges, 0.0), receiver.position, normal);
  if (shape == 2) irradiance = PointIrradiance(vec3(0.0), receiver.position, normal);
  float lit = texelFetch(visibility, pixel, 0).r * irradiance / kPi;
  bool is_drawn = receiver.is_drawn && receiver.position.z > 0.0;
  color = is_drawn ? vec4(texelFetch(base_colors, pixel, 0).rgb * emitted * lit, 0.0) : vec4(0.0);
}
