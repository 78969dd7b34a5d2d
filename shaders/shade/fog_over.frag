// The fog between eye and scene: what it scatters toward the eye, over what it lets through.
layout(location = 0) out vec4 color;

uniform sampler2D points;     // fog_points.frag; a: opacity
uniform sampler2D scattered;  // fog_light.frag, all steps and lights
uniform vec3 ambient;         // exposed, times albedo: the same from everywhere

// Steps of the pixels in any block of 4 x 4 lie at sixteen different shares of their views (fog_points.frag): together they
// are sixteen times as many steps. Of the neighbours those count whose view is about as deep in the fog.
const float kLike = 0.05;

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  ivec2 last = textureSize(points, 0) - 1;
  float opacity = texelFetch(points, pixel, 0).a;
  vec4 sum = vec4(0.0);
  for (int y = -1; y <= 2; ++y) {
    for (int x = -1; x <= 2; ++x) {
      ivec2 other = clamp(pixel + ivec2(x, y), ivec2(0), last);
      float other_opacity = texelFetch(points, other, 0).a;
      bool is_like = abs(other_opacity - opacity) <= kLike * opacity;
      sum += is_like ? vec4(texelFetch(scattered, other, 0).rgb, other_opacity) : vec4(0.0);
    }
  }
  vec3 light = sum.a > 0.0 ? sum.rgb * (opacity / sum.a) : vec3(0.0);
  color = vec4(light + ambient * opacity, 1.0 - opacity);  // alpha: what is kept of what is behind
}
