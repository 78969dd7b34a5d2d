// What the pyramid proves, and rows that need no look at the map: those of lit receivers, and blurred ones of dark.
#include "light/map_receiver.glsl"
#include "sssm/rows.glsl"

layout(location = 0) out float proof;
layout(location = 1) out vec4 blocker_row;
layout(location = 2) out vec4 blurred_row;
layout(location = 3) out vec2 blockers;  // none: what is proven is no penumbra

void main() {
  Receiver receiver = FetchReceiver(gl_FragCoord.xy);
  MapReceiver map_receiver = FetchMapReceiver(receiver);
  blockers = vec2(0.0);
  proof = Prove(map_receiver);
  float place = SeesWholeLight(map_receiver) ? PlaceOnRay(receiver) : kNowhere;
  blocker_row = vec4(place, map_receiver.w, 0.0, 0.0);
  blurred_row = vec4(place, map_receiver.w, proof, proof > 0.0 ? kProvenDark : kProvenLit);
}
