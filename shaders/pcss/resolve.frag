// PCSS: hidden fraction of the light above the receiver's plane, from one map. The blockers that may hide part of the light are averaged in depth, and
// the map is filtered over the light's image at that depth (Fernando 2005; windows of Buades et al. 2015, eq. 1).
#include "common/receiver.glsl"
#include "light/map_texel.glsl"
#include "pcss/windows.glsl"

layout(location = 0) out float hidden_fraction;

uniform sampler2DArray maps;
uniform int blocker_taps;
uniform int filter_taps;
uniform bool is_gaussian;
uniform float front_slope;        // 0: no occluder reaches beyond the map; else where the side maps begin
uniform sampler2D hidden_center;  // r: the light's centre is hidden; g: it stands above the plane. From maps of all sides

const float kBelow = 1e-6;

void main() {
  Receiver receiver = FetchReceiver(gl_FragCoord.xy);
  float receiver_w = 1.0 / receiver.position.z;
  vec2 slope = receiver.position.xy * receiver_w;
  vec3 normal = receiver.normal;
  float height = -receiver.offset;  // of the light's centre above the receiver's plane
  float slack = 1e-3 * dot(abs(normal.xy), slope_per_texel);
  BlockerWindow window = FindWindow(slope, receiver_w);
  vec2 reach = abs(slope) + window.half_window + 2.0 * slope_per_texel;
  bool leaves_map = front_slope > 0.0 && max(reach.x, reach.y) > front_slope;
  bool is_resolved = receiver.is_receiving && receiver.position.z > 0.0 && !leaves_map;

  float z_sum = 0.0;
  float blockers = 0.0;
  int taps = is_resolved ? blocker_taps : 0;
  for (int y = 0; y < taps; ++y) {
    for (int x = 0; x < taps; ++x) {
      // From edge to edge: what only just hides a part of the light is found too.
      vec2 offset = window.half_window * (2.0 * vec2(x, y) / float(max(blocker_taps - 1, 1)) - float(blocker_taps > 1));
      MapTexel shown = FetchMapTexel(maps, 0.0, map_size, slope_per_texel, ToTexel(slope + offset));
      float w = shown.depth / z_near;
      vec2 hides_within = half_edges * (shown.depth_here / z_near - receiver_w);
      float above = HeightAbovePlane(w, first_center + shown.cell * slope_per_texel, height, receiver.error, normal);
      bool is_blocker = shown.depth_here > z_near * receiver_w && above > slack &&
                        all(lessThanEqual(abs(offset), hides_within));
      z_sum += is_blocker ? 1.0 / w : 0.0;
      blockers += float(is_blocker);
    }
  }

  vec2 half_filter = half_edges * max(blockers / z_sum - receiver_w, 0.0);  // unused without blockers
  float hidden = 0.0;
  float total = 0.0;
  taps = blockers > 0.0 ? filter_taps : 0;
  for (int y = 0; y < taps; ++y) {
    for (int x = 0; x < taps; ++x) {
      vec2 place = (2.0 * vec2(x, y) + 1.0) / float(filter_taps) - 1.0;
      MapTexel shown = FetchMapTexel(maps, 0.0, map_size, slope_per_texel, ToTexel(slope + half_filter * place));
      float above = HeightAbovePlane(shown.depth / z_near, first_center + shown.cell * slope_per_texel, height,
                                     receiver.error, normal);
      // Of a rectangle as wide as the window the deviation is width / sqrt(12).
      float weight = is_gaussian ? exp(-1.5 * dot(place, place)) : 1.0;
      // A tap stands for a point of the light. Those below the plane decide only where there are no others.
      weight *= height + dot(normal.xy, half_edges * place) > 0.0 ? 1.0 : kBelow;
      hidden += shown.depth_here > z_near * receiver_w && above > slack ? weight : 0.0;
      total += weight;
    }
  }
  vec2 center = texelFetch(hidden_center, ivec2(gl_FragCoord.xy), 0).rg;
  hidden_fraction = !receiver.is_receiving || receiver.position.z <= 0.0 ? 0.0
                    : leaves_map                                         ? (center.g > 0.0 ? center.r : 1.0)
                    : total > 0.0                                        ? hidden / total
                                                                         : 0.0;
}
