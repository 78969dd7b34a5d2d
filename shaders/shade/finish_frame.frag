// The last pass of a sample: the ground as a shadow catcher, the tone curve, the sample's weight.
#include "shade/tone_map.glsl"

layout(location = 0) out vec4 color;

uniform sampler2D frame;       // exposed; alpha: coverage
uniform sampler2D unshadowed;  // the same without any occluder; read for a catcher alone
uniform sampler2D object_ids;  // likewise
uniform bool has_catcher;
uniform float ground_id;
uniform int tone_map;
uniform float weight;

// What of the light arrives is S = frame, what would without occluders U = unshadowed. Over a picture P the result must
// be P S/U: alpha takes the channel that lost most, and where others lost less, their colour comes from the ground.
vec4 CatchShadow(vec3 arrives, vec3 full) {
  vec3 ratio = mix(vec3(1.0), min(arrives / max(full, 1e-37), 1.0), greaterThan(full, vec3(0.0)));
  float kept = min(ratio.r, min(ratio.g, ratio.b));
  return vec4(max(arrives - kept * full, 0.0), 1.0 - kept);
}

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  vec4 sampled = texelFetch(frame, pixel, 0);
  if (has_catcher) {
    bool is_ground = texelFetch(object_ids, pixel, 0).r == ground_id;
    if (is_ground) sampled = CatchShadow(sampled.rgb, texelFetch(unshadowed, pixel, 0).rgb);
    sampled.rgb = sampled.a > 0.0 ? sampled.rgb : vec3(0.0);  // no background
  }
  color = weight * vec4(ToneMap(tone_map, sampled.rgb), sampled.a);
}
