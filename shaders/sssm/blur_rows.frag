// Step 2: the blockers' average depth from the rows above and below, and the hidden fraction of the pixel's own row of
// the filter's window.
#include "light/map_receiver.glsl"
#include "light/filter_rows.glsl"
#include "sssm/rows.glsl"

layout(location = 0) out vec4 blurred_row;

uniform sampler2D proofs;
uniform sampler2D blocker_rows;
uniform sampler2D nearer_blocker_rows;
uniform float alpha;

const float kRounding = 1e-3;

// The sums, where their blockers as a whole are far enough from the receiver to hide part of the light from so far off.
// The outermost row is just as far off as the nearest occluder allows: it must not fail by the rounding of its average.
vec2 Hiding(vec2 sums, float offset, float receiver_w) {
  bool hides = abs(offset) * sums.x <= half_edges.y * (sums.y - receiver_w * sums.x) * (1.0 + kRounding);
  return hides ? sums : vec2(0.0);
}

void main() {
  Receiver receiver = FetchReceiver(gl_FragCoord.xy);
  MapReceiver map_receiver = FetchMapReceiver(receiver);
  float proof = texelFetch(proofs, ivec2(gl_FragCoord.xy), 0).r;
  bool is_filtered = !(map_receiver.is_behind || map_receiver.leaves_map) && proof < 0.0;
  bool sees_whole = SeesWholeLight(map_receiver);
  RowLine line = FindRowLine(map_receiver, gl_FragCoord.xy);
  vec2 half_window = map_receiver.window.half_window;
  vec2 window_texels = half_window / slope_per_texel;
  int taps = TapsFor(window_texels.x, blocker_taps);
  int rows = TapsFor(window_texels.y, blocker_taps);
  vec2 tolerance = max(slope_per_texel, half_window / vec2(taps, rows));
  vec2 blockers = vec2(0.0);
  rows = is_filtered ? rows : 0;
  for (int y = 0; y < rows; ++y) {
    float offset = half_window.y * BlockerPlace(y, rows);
    SharedRow row = FindRow(blocker_rows, line, map_receiver, offset, tolerance);
    bool is_shared = row.is_near && sees_whole && IsWithin(alpha, map_receiver.w, row.w, map_receiver.w);
    vec2 own = SumBlockerRow(map_receiver, offset, is_shared ? 0 : taps) / float(taps);
    vec4 nearer = textureLod(nearer_blocker_rows, row.place, 0.0);
    vec2 found = Hiding(row.values, offset, map_receiver.w) + Hiding(nearer.xy, offset, map_receiver.w) +
                 Hiding(nearer.zw, offset, map_receiver.w);
    blockers += is_shared ? found / map_receiver.window.reach : own;
  }
  float reach = max(blockers.y / blockers.x - map_receiver.w, 1e-30);  // over 0: there are blockers
  float band = BandHeight(receiver);
  vec2 half_filter = half_edges * reach;
  bool is_shared = sees_whole && (blockers.y == 0.0 || band <= kMostOfWindow * half_filter.y);
  taps = is_shared && blockers.y > 0.0 ? TapsFor(half_filter.x / slope_per_texel.x, filter_taps) : 0;
  vec2 hidden = SumFilterRow(map_receiver, reach, 0.0, band, taps);
  vec2 values = proof > 0.0          ? vec2(1.0, kProvenDark)
                : blockers.y > 0.0 ? vec2(hidden.x / max(hidden.y, 1e-30), reach)
                                   : vec2(0.0, kProvenLit);
  blurred_row = vec4(is_shared ? PlaceOnRay(receiver) : kNowhere, map_receiver.w, values);
}
