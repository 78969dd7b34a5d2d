// What a PDSM says of receivers: hidden samples of the light, of those above the receiver's plane.
//
// A surface is not to hide light from itself. Depth is affine on a plane, so every ray is asked where the plane meets it,
// and, since a map shows a surface's depth at the centres of its texels, the change of depth over half a texel
// nearer to the light: no texel of the plane itself, in the map of any sample above it, is over that. Nor are neighbours
// in a crease, which may rise on from the plane by twice a texel's half width.
// Samples below the plane are counted exactly, of cells their parts below it; what hides them is taken to be the receiver's own
// solid.
#include "common/receiver.glsl"
#include "common/horizon.glsl"
#include "pdsm/attenuation.glsl"

layout(location = 0) out vec2 hidden_and_all;

layout(std430, binding = 1) readonly buffer Points { vec2 points_ls[]; };  // of the samples

uniform sampler2D side_hidden;  // hidden samples in directions beyond the PDSM's rays
uniform bool has_sides;
uniform vec2 slope_per_texel;   // of the maps
uniform vec2 half_edges;
uniform int filter_width;
uniform bool are_cells;         // each sample stands for its part of the light (soft_events.h)
#ifndef HAS_VOLUME
uniform int point_count;
#endif

const float kUlp = 1.1920929e-7;
const float kCreaseSlope = 1.0;

void main() {
  Receiver receiver = FetchReceiver(gl_FragCoord.xy);
  vec3 normal = receiver.normal;
  float w = 1.0 / receiver.position.z;
  vec2 place = (receiver.position.xy * w - first_center) / slope_per_ray;
  float depth = z_near * w;
  // Of a point without a plane, and of one seen edge-on: the point's own depth.
  bool has_plane = normal != vec3(0.0) && abs(receiver.offset) > receiver.error;
  vec2 depth_per_slope = has_plane ? z_near * normal.xy / receiver.offset : vec2(0.0);
  float texel_change = dot(abs(depth_per_slope), slope_per_texel);
  float crease = kCreaseSlope * 0.5 * depth * (slope_per_texel.x + slope_per_texel.y);
  float own = 0.501 * texel_change + crease + depth * (4.0 * kUlp + receiver.error / abs(receiver.offset));
  // Where the light's centre is below the plane, what is above the plane lies beyond it on a ray.
  bool is_center_above = receiver.offset < 0.0;
  float asked = depth + (has_plane ? is_center_above ? own : -own : 0.0);
  // Heights of the light above the plane vary by so much around the centre's.
  float reach = dot(abs(normal.xy), half_edges);
  float own_rise = !has_plane ? 1.0 : !is_center_above ? -1.0
                   : reach < -receiver.offset ? receiver.offset / (receiver.offset + reach) : 1e30;
  bool is_in_front = receiver.is_receiving && receiver.position.z > 0.0;
  float hidden = is_in_front ? FilteredAttenuation(place, asked, depth_per_slope * slope_per_ray, own_rise, filter_width) : 0.0;
  float share = ShareAbovePlane(half_edges, normal, receiver.offset);
  // Cells of the light are hidden in parts by the receiver's own solid, samples as a whole.
  float below = are_cells ? (1.0 - share) * float(point_count) : 0.0;
  // Loops without a round are skipped on every kind of GL.
  int counted = !are_cells && share > 0.0 && share < 1.0 && (hidden > 0.0 || has_sides) ? point_count : 0;
  for (int i = 0; i < counted; ++i) {
    below += float(dot(normal.xy, points_ls[i]) - receiver.offset <= 0.0);
  }
  float hidden_samples = max(hidden * float(point_count) - below, 0.0);
  if (has_sides) hidden_samples += texelFetch(side_hidden, ivec2(gl_FragCoord.xy), 0).r;
  hidden_and_all = is_in_front ? vec2(hidden_samples, float(point_count) - below) : vec2(0.0, 1.0);
}
