// The door of every shadow method: a sum becomes a visibility in [0,1], and the horizon is applied.
// v = share of the light above the receiver's plane, times what the method sees of that part; behind the light v = 0.
// What does not receive has v = 1 everywhere.
#include "common/receiver.glsl"
#include "common/horizon.glsl"

layout(location = 1) out float penumbra_width;  // metres
layout(location = 0) out vec2 visibility_and_share;  // share: of the light above the horizon; -1 where nothing receives

uniform sampler2D hidden_sums;
uniform float full_sum;        // the sum that hides all of the part above; 0: it stands beside each sum
uniform bool has_sums;         // false: nothing occludes
uniform sampler2D blockers;    // r: sum of their w less the receiver's, g: of weights; where widths are asked for
uniform bool has_blockers;
uniform sampler2D others;      // r: visibility for other occluders, of the same share
uniform bool has_others;
uniform vec2 half_edges;

const float kMargin = 1.0 / 512.0;  // nearer to 0 or 1 is umbra or light

void main() {
  Receiver receiver = FetchReceiver(gl_FragCoord.xy);
  vec2 sum = has_sums ? texelFetch(hidden_sums, ivec2(gl_FragCoord.xy), 0).rg : vec2(0.0, 1.0);
  float full = has_sums && full_sum > 0.0 ? full_sum : sum.g;
  float hidden = full > 0.0 ? sum.r / full : 1.0;
  float share = receiver.position.z > 0.0 ? ShareAbovePlane(half_edges, receiver.normal, receiver.offset) : 0.0;
  float visibility = share * clamp(1.0 - hidden, 0.0, 1.0);
  float seen_by_others = has_others && share > 0.0 ? texelFetch(others, ivec2(gl_FragCoord.xy), 0).r / share : 1.0;
  visibility *= min(seen_by_others, 1.0);
  visibility_and_share = receiver.is_receiving ? vec2(visibility, share) : vec2(1.0, -1.0);
  // Eq. 1 of Buades et al. 2015, w_light (z_receiver - z_average) / z_average, over the longer edge.
  vec2 seen = has_blockers ? texelFetch(blockers, ivec2(gl_FragCoord.xy), 0).rg : vec2(0.0);
  bool is_penumbra = receiver.is_receiving && share > 0.0 && hidden > kMargin && hidden < 1.0 - kMargin && seen.g > 0.0;
  penumbra_width = is_penumbra ? 2.0 * max(half_edges.x, half_edges.y) * receiver.position.z * seen.r / seen.g : 0.0;
}
