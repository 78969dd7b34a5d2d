// How many of a batch of light samples a receiver cannot see: one depth map per sample, nearest texel.
//
// A texel hides its sample from the receiver only if what it shows is nearer than the receiver and above the receiver's
// tangent plane. Geometry, not a tuned bias:
// - Above: at the texel's centre, by more than 4 ulps of w, a thousandth of w's change over a texel (rasterisers place w
//   that well) and the plane's own error in floats.
// - Nearer: where the receiver stands in the texel, not at its centre. The surface is carried there by its slope, known
//   from the neighbours away from the receiver, where it falls off toward the receiver: else every slightly concave crease
//   would shadow itself in texels whose centre lies beyond it.
// Only samples above the tangent plane count.
#include "common/receiver.glsl"
#include "light/map_texel.glsl"

layout(location = 0) out vec2 hidden_and_all;  // of the samples above the receiver's plane

const int kMaxBatch = 64;

uniform sampler2DArray maps;
uniform int sample_count;
uniform vec4 samples[kMaxBatch];  // xy: the light's point; zw: centre of the map's first texel, in slopes
uniform vec2 slope_per_texel;
uniform float z_near;
uniform float map_size;
#ifdef SHARES_HALF_SPACE
// Five maps a sample share the half space in front of it: every direction belongs to exactly one.
uniform mat3 map_from_light;
uniform int side;           // 0: front; 1, 2: +-x; 3, 4: +-y
uniform float front_slope;  // the front map's directions are |x|, |y| <= front_slope z

bool IsInSector(vec3 q) {
  if (side == 0) return max(abs(q.x), abs(q.y)) <= front_slope * q.z;
  // Side maps: x across, y the light's z, z the viewing direction.
  return q.z > front_slope * q.y && (side <= 2 ? abs(q.x) <= q.z : abs(q.x) < q.z);
}
#endif

void main() {
  Receiver receiver = FetchReceiver(gl_FragCoord.xy);
#ifdef SHARES_HALF_SPACE
  vec3 position = map_from_light * receiver.position;
  vec3 normal = map_from_light * receiver.normal;
#else
  vec3 position = receiver.position;
  vec3 normal = receiver.normal;
  float receiver_w = 1.0 / position.z;
#endif
  vec2 texels_per_slope = 1.0 / slope_per_texel;
  float slack = 1e-3 * dot(abs(normal.xy), slope_per_texel);
  vec2 counts = vec2(0.0);
  for (int i = 0; i < sample_count; ++i) {
    vec4 light_sample = samples[i];
#ifdef SHARES_HALF_SPACE
    vec3 s = map_from_light * vec3(light_sample.xy, 0.0);
    vec3 q = position - s;
    float receiver_w = 1.0 / q.z;
    bool is_in_map = IsInSector(q);
    bool counts_sample = side == 0;  // once, whatever the number of maps
#else
    // One map holds every occluder inside a border of empty texels: what lies outside is clamped to it.
    vec3 s = vec3(light_sample.xy, 0.0);
    vec3 q = position - s;
    const bool is_in_map = true;
    const bool counts_sample = true;
#endif
    vec2 texel = (q.xy * receiver_w - light_sample.zw) * texels_per_slope + 0.5;
    MapTexel shown = FetchMapTexel(maps, float(i), map_size, slope_per_texel, texel);
    bool is_nearer = shown.depth_here > z_near * receiver_w;
    // normal . (x - s) = -height on the tangent plane.
    float height = dot(normal, s) - receiver.offset;
    float above = HeightAbovePlane(shown.depth / z_near, light_sample.zw + shown.cell * slope_per_texel, height,
                                   receiver.error, normal);
    bool is_occluded = is_in_map && is_nearer && above > slack;
    counts += height > 0.0 ? vec2(is_occluded, counts_sample) : vec2(0.0);
  }
  hidden_and_all = receiver.is_drawn ? counts : vec2(0.0, 1.0);
}
