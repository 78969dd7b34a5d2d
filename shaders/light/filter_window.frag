// PCSS: hidden fraction of the light above the receiver's plane, from one map. The blockers that may hide part of the
// light are averaged in depth, and the map is filtered over the light's image at that depth.
#include "light/map_receiver.glsl"
#include "light/filter_rows.glsl"

layout(location = 0) out float hidden_fraction;
layout(location = 1) out vec2 blockers_seen;  // w of their average less the receiver's; 1: there are some

uniform sampler2D hidden_center;  // r: the light's centre is hidden; g: it stands above the plane. From maps of all sides

void main() {
  MapReceiver receiver = FetchMapReceiver(FetchReceiver(gl_FragCoord.xy));
  vec2 blockers = vec2(0.0);
  int rows = receiver.is_behind || receiver.leaves_map ? 0 : blocker_taps;
  for (int y = 0; y < rows; ++y) {
    blockers += SumBlockerRow(receiver, receiver.window.half_window.y * BlockerPlace(y, rows), rows);
  }
  float reach = max(blockers.y / blockers.x - receiver.w, 0.0);  // unused without blockers
  blockers_seen = blockers.y > 0.0 ? vec2(reach, 1.0) : vec2(0.0);
  vec2 hidden = vec2(0.0);
  rows = blockers.y > 0.0 ? filter_taps : 0;
  for (int y = 0; y < rows; ++y) hidden += SumFilterRow(receiver, reach, FilterPlace(y, rows), 0.0, rows);
  vec2 center = texelFetch(hidden_center, ivec2(gl_FragCoord.xy), 0).rg;
  hidden_fraction = receiver.is_behind    ? 0.0
                    : receiver.leaves_map ? (center.g > 0.0 ? center.r : 1.0)
                    : hidden.y > 0.0      ? hidden.x / hidden.y
                                          : 0.0;
}
