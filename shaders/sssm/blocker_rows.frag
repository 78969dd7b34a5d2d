// Step 1: the blockers in the row of the map at each pixel.
#include "light/map_receiver.glsl"
#include "light/filter_rows.glsl"
#include "sssm/rows.glsl"

layout(location = 0) out vec4 blocker_row;
layout(location = 1) out vec4 nearer_blockers;

void main() {
  Receiver receiver = FetchReceiver(gl_FragCoord.xy);
  MapReceiver map_receiver = FetchMapReceiver(receiver);
  bool is_usable = SeesWholeLight(map_receiver);
  int taps = TapsFor(map_receiver.window.half_window.x / slope_per_texel.x, blocker_taps);
  mat3x2 blockers =
      SumBlockerThirds(map_receiver, 0.0, is_usable ? taps : 0) * (map_receiver.window.reach / float(taps));
  blocker_row = vec4(is_usable ? PlaceOnRay(receiver) : kNowhere, map_receiver.w, blockers[0]);
  nearer_blockers = vec4(blockers[1], blockers[2]);
}
