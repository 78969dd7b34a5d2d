// A receiver as the filters of the map from a light's centre see it, and what the pyramid proves of it.
#include "common/receiver.glsl"
#include "light/map_texel.glsl"
#include "light/windows.glsl"

uniform float front_slope;  // 0: no occluder reaches beyond the map; else where the side maps begin

struct MapReceiver {
  vec2 slope;
  float w;
  vec3 normal;
  float height;  // of the light's centre above the receiver's plane
  float error;
  float slack;   // how far above the plane a texel must stand to hide anything
  BlockerWindow window;
  bool is_behind;   // the light, or it receives nothing
  bool leaves_map;  // the window reaches where occluders stand that the map does not hold
};

MapReceiver FetchMapReceiver(Receiver receiver) {
  MapReceiver result;
  result.w = 1.0 / receiver.position.z;
  result.slope = receiver.position.xy * result.w;
  result.normal = receiver.normal;
  result.height = -receiver.offset;
  result.error = receiver.error;
  result.slack = 1e-3 * dot(abs(receiver.normal.xy), slope_per_texel);
  result.window = FindWindow(result.slope, result.w);
  vec2 reach = abs(result.slope) + result.window.half_window + 2.0 * slope_per_texel;
  result.is_behind = !receiver.is_receiving || receiver.position.z <= 0.0;
  result.leaves_map = front_slope > 0.0 && max(reach.x, reach.y) > front_slope;
  return result;
}

// Without a look at a texel: 0, nothing in the window is nearer; 1, everything in it is nearer and above the plane;
// -1, unknown. Where it proves something, filtering gives the same value.
float Prove(MapReceiver receiver) {
  vec2 margin = receiver.window.half_window + 2.0 * slope_per_texel;
  vec2 depths = receiver.window.depths;
  bool is_lit = depths.y <= z_near * receiver.w;
  // A surface is carried over less than the range; the plane is least above where the normal points least.
  float least_depth = 2.0 * depths.x - depths.y;
  vec2 w = depths / z_near;
  float above = min(HeightAbovePlane(w.x, receiver.slope, receiver.height, receiver.error, receiver.normal),
                    HeightAbovePlane(w.y, receiver.slope, receiver.height, receiver.error, receiver.normal)) -
                dot(abs(receiver.normal.xy), margin);
  bool is_dark = least_depth > z_near * receiver.w * (1.0 + 4.0 * kUlp) && above > receiver.slack + 8.0 * kUlp;
  return receiver.is_behind ? 0.0 : receiver.leaves_map ? -1.0 : is_lit ? 0.0 : is_dark ? 1.0 : -1.0;
}
