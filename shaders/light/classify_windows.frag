// What the pyramid proves of each receiver.
#include "light/map_receiver.glsl"

layout(location = 0) out float proof;

void main() { proof = Prove(FetchMapReceiver(FetchReceiver(gl_FragCoord.xy))); }
