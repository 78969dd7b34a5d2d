// Step 3: hidden fraction of the light above the receiver's plane, from the blurred rows above and below. Where the
// plane cuts the light, rows have weights of their own and are taken from the map.
#include "light/map_receiver.glsl"
#include "light/filter_rows.glsl"
#include "sssm/rows.glsl"

layout(location = 0) out float hidden_fraction;
layout(location = 1) out vec2 blockers_seen;  // w of their average less the receiver's; 1: there are some

uniform sampler2D blurred_rows;
uniform sampler2D hidden_center;  // r: the light's centre is hidden; g: it stands above the plane. From maps of all sides
uniform float beta;

void main() {
  MapReceiver receiver = FetchMapReceiver(FetchReceiver(gl_FragCoord.xy));
  float reach = texelFetch(blurred_rows, ivec2(gl_FragCoord.xy), 0).w;
  blockers_seen = reach > 0.0 ? vec2(reach, 1.0) : vec2(0.0);
  RowLine line = FindRowLine(receiver, gl_FragCoord.xy);
  bool sees_whole = SeesWholeLight(receiver);
  vec2 half_filter = half_edges * reach;
  int taps = TapsFor(half_filter.x / slope_per_texel.x, filter_taps);
  int rows = TapsFor(half_filter.y / slope_per_texel.y, filter_taps);
  vec2 tolerance = max(slope_per_texel, half_filter / vec2(taps, rows));
  vec2 hidden = vec2(0.0);
  rows = receiver.is_behind || receiver.leaves_map || !(reach > 0.0) ? 0 : rows;
  for (int y = 0; y < rows; ++y) {
    float place = FilterPlace(y, rows);
    SharedRow row = FindRow(blurred_rows, line, receiver, half_filter.y * place, tolerance);
    bool is_shared = row.is_near && sees_whole && IsWithin(beta, row.w_asked, row.w, receiver.w);
    vec2 own = SumFilterRow(receiver, reach, place, 0.0, is_shared ? 0 : taps);
    float weight = FilterWeight(place);
    hidden += is_shared ? vec2(row.values.x, 1.0) * weight : sees_whole ? own * (weight / own.y) : own;
  }
  vec2 center = texelFetch(hidden_center, ivec2(gl_FragCoord.xy), 0).rg;
  hidden_fraction = receiver.is_behind    ? 0.0
                    : receiver.leaves_map ? (center.g > 0.0 ? center.r : 1.0)
                    : reach < 0.0         ? 1.0
                    : hidden.y > 0.0      ? hidden.x / hidden.y
                                          : 0.0;
}
