// What the pyramid proves of a receiver without looking at a texel: 0, nothing in its window is nearer; 1, everything in
// it is nearer and above its plane; -1, it must be resolved. Where it proves something, resolve.frag gives the same value.
#include "common/receiver.glsl"
#include "light/map_texel.glsl"
#include "pcss/windows.glsl"

layout(location = 0) out float proof;

uniform float front_slope;  // 0: no occluder reaches beyond the map

void main() {
  Receiver receiver = FetchReceiver(gl_FragCoord.xy);
  float receiver_w = 1.0 / receiver.position.z;
  vec2 slope = receiver.position.xy * receiver_w;
  BlockerWindow window = FindWindow(slope, receiver_w);
  vec2 reach = abs(slope) + window.half_window + 2.0 * slope_per_texel;
  bool leaves_map = front_slope > 0.0 && max(reach.x, reach.y) > front_slope;
  bool is_lit = window.depths.y <= z_near * receiver_w;
  // A surface is carried over less than the range; the plane is least above where the normal points least.
  float least_depth = 2.0 * window.depths.x - window.depths.y;
  float height = -receiver.offset;
  vec2 w = window.depths / z_near;
  float above = min(HeightAbovePlane(w.x, slope, height, receiver.error, receiver.normal),
                    HeightAbovePlane(w.y, slope, height, receiver.error, receiver.normal)) -
                dot(abs(receiver.normal.xy), window.half_window + 2.0 * slope_per_texel);
  float slack = 1e-3 * dot(abs(receiver.normal.xy), slope_per_texel);
  bool is_dark = least_depth > z_near * receiver_w * (1.0 + 4.0 * kUlp) && above > slack + 8.0 * kUlp;
  proof = !receiver.is_receiving || receiver.position.z <= 0.0 ? 0.0
          : leaves_map                                          ? -1.0
          : is_lit                                              ? 0.0
          : is_dark                                             ? 1.0
                                                                : -1.0;
}
