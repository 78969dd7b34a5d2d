// What the pyramid proves of each receiver.
#include "light/map_receiver.glsl"

layout(location = 0) out float proof;
layout(location = 1) out vec2 blockers;  // none: what is proven is no penumbra

void main() {
  proof = Prove(FetchMapReceiver(FetchReceiver(gl_FragCoord.xy)));
  blockers = vec2(0.0);
}
