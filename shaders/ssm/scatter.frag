// The fraction of the light that one patch hides from one receiver (Atty et al. 2006, 4.2): the part of the receiver's
// window that the patch covers, axis by axis. Blended additively.
layout(location = 0) out float hidden;

uniform sampler2D receivers;  // w, 0: none
uniform vec2 window_low;
uniform float slope_per_texel;
uniform vec2 light_point;
uniform vec2 half_edges;
uniform vec2 first_edge;
uniform vec2 slope_per_patch;

flat in vec4 micro_patch;

// A point light's window has no width: this many patches take its place.
const float kLeastHalfWindow = 1e-3;

void main() {
  float w = texelFetch(receivers, ivec2(gl_FragCoord.xy), 0).r;
  float ahead = micro_patch.z - w;
  vec2 slope = window_low + gl_FragCoord.xy * slope_per_texel - light_point * w;
  vec2 from_patch = (slope - first_edge) / slope_per_patch - micro_patch.xy;
  vec2 half_window = max(half_edges * ahead / slope_per_patch, vec2(kLeastHalfWindow));
  vec2 cover = max(min(vec2(1.0), from_patch + half_window) - max(vec2(0.0), from_patch - half_window), 0.0);
  vec2 part = cover / (2.0 * half_window);
  hidden = w > 0.0 && ahead > 0.0 ? micro_patch.w * part.x * part.y : 0.0;
}
