// Looks a receiver up in a soft shadow map (renderer/shadow/ssm/projected_map.h).
#include "common/receiver.glsl"

layout(location = 0) out float hidden;

uniform sampler2D texels;  // hidden fraction, w; 0 0: no receiver
uniform vec2 window_low;
uniform float slope_per_texel;
uniform bool casts;

// A texel shows the receiver's surface if its w is that of the receiver's plane there, give or take this part of it and
// a texel's change.
const float kSameSurface = 1e-3;

void main() {
  Receiver receiver = FetchReceiver(gl_FragCoord.xy);
  hidden = 0.0;
  if (!receiver.is_receiving || receiver.position.z <= 0.0) return;
  float w = 1.0 / receiver.position.z;
  vec2 slope = receiver.position.xy * w;
  ivec2 size = textureSize(texels, 0);
  vec2 place = (slope - window_low) / slope_per_texel;
  if (any(lessThan(place, vec2(0.0))) || any(greaterThan(place, vec2(size)))) return;
  vec2 first = floor(place - 0.5);
  vec2 part = place - 0.5 - first;
  // w of the receiver's plane, per slope. Without a plane, or with one seen edge-on: as if it faced the light.
  bool has_plane = abs(receiver.offset) > receiver.error && receiver.offset > -1e29;
  vec2 change = has_plane ? receiver.normal.xy / receiver.offset * slope_per_texel : vec2(0.0);
  float slack = kSameSurface * w + abs(change.x) + abs(change.y);
  vec2 own = vec2(0.0);    // sums of weights and of hidden fractions, of texels of the receiver's surface
  vec2 other = vec2(0.0);  // of others that are nearer to the light
  for (int i = 0; i < 4; ++i) {
    vec2 corner = vec2(float(i & 1), float(i >> 1));
    vec2 texel = texelFetch(texels, clamp(ivec2(first + corner), ivec2(0), size - 1), 0).rg;
    vec2 weights = mix(1.0 - part, part, corner);
    float weight = texel.g > 0.0 ? weights.x * weights.y : 0.0;
    float ahead = texel.g - (w + dot(change, first + corner + 0.5 - place));
    if (abs(ahead) <= slack) {
      own += weight * vec2(1.0, texel.r);
    } else if (ahead > 0.0) {
      other += weight * vec2(1.0, casts ? 1.0 : texel.r);
    }
  }
  if (own.x > 0.0) {
    hidden = own.y / own.x;
  } else if (other.x > 0.0) {
    hidden = other.y / other.x;
  }
}
