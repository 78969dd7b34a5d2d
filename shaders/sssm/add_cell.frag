// One cell of the light joins the sum: the share of it above the receiver's plane, and what of that is hidden.
#include "common/receiver.glsl"
#include "common/horizon.glsl"

layout(location = 0) out vec2 hidden_and_share;
layout(location = 1) out vec2 blockers_seen;

uniform sampler2D hidden;
uniform sampler2D blockers;
uniform vec2 half_edges;

void main() {
  Receiver receiver = FetchReceiver(gl_FragCoord.xy);
  float share = receiver.position.z > 0.0 ? ShareAbovePlane(half_edges, receiver.normal, receiver.offset) : 0.0;
  blockers_seen = texelFetch(blockers, ivec2(gl_FragCoord.xy), 0).rg;
  hidden_and_share = vec2(texelFetch(hidden, ivec2(gl_FragCoord.xy), 0).r * share, share);
}
