// How many of a batch of light samples a receiver cannot see: one depth map per sample, nearest texel.
//
// A texel hides its sample from the receiver only if it is nearer than the receiver and above the receiver's tangent
// plane, evaluated at the texel's centre: geometry, not a tuned bias. What is added to the plane is 4 ulps of w, a thousandth
// of w's change over a texel (rasterisers place w that well), and the plane's own error in floats. A sample at or below the tangent plane is hidden.
#include "common/receiver.glsl"

layout(location = 0) out float hidden_samples;

const int kMaxBatch = 64;
uniform sampler2DArray maps;
uniform int sample_count;
uniform vec4 samples[kMaxBatch];  // xyz: the light's point in the map's axes; w: layer, or -1 where no occluder is
uniform vec4 windows[kMaxBatch];  // u0, v0, texels per slope along u and v
uniform float z_near;
uniform float map_size;
uniform mat3 map_from_light;
uniform int side;                 // 0: front; 1, 2: +-x; 3, 4: +-y
uniform float front_slope;        // the front map's directions are |x|, |y| <= front_slope z

// Every direction into the half space belongs to exactly one side.
bool IsInSector(vec3 q, int map_side) {
  if (map_side == 0) return max(abs(q.x), abs(q.y)) <= front_slope * q.z;
  // Side maps: x across, y the light's z, z the viewing direction.
  return q.z > front_slope * q.y && (map_side <= 2 ? abs(q.x) <= q.z : abs(q.x) < q.z);
}

void main() {
  Receiver receiver = FetchReceiver(gl_FragCoord.xy);
  vec3 position = map_from_light * receiver.position;
  vec3 normal = map_from_light * receiver.normal;
  float hidden = 0.0;
  for (int i = 0; i < sample_count; ++i) {
    vec3 s = samples[i].xyz;
    vec3 q = position - s;
    float offset = receiver.offset - dot(normal, s);  // normal . (x - s) = offset on the tangent plane
    bool is_above_horizon = offset < 0.0;
    vec4 window = windows[i];
    vec2 texel = (q.xy / q.z - window.xy) * window.zw;
    bool is_inside = IsInSector(q, side) && all(greaterThanEqual(texel, vec2(0.0))) &&
                     all(lessThan(texel, vec2(map_size))) && samples[i].w >= 0.0;
    vec2 cell = clamp(floor(texel), vec2(0.0), vec2(map_size - 1.0));
    float occluder_w = texelFetch(maps, ivec3(ivec2(cell), int(max(samples[i].w, 0.0))), 0).r / z_near;
    vec2 center = window.xy + (cell + 0.5) / window.zw;
    float plane_w = (dot(normal.xy, center) + normal.z) / offset;
    float plane_w_per_texel = dot(abs(normal.xy), 1.0 / window.zw) / abs(offset);
    float tolerance = 4.0 * 1.1920929e-7 * occluder_w + 1e-3 * plane_w_per_texel +
                      abs(plane_w * receiver.error / offset);
    bool is_occluded = is_inside && occluder_w > 1.0 / q.z && occluder_w > plane_w + tolerance;
    bool counts_horizon = side == 0;  // once a sample
    hidden += is_above_horizon ? float(is_occluded) : float(counts_horizon);
  }
  hidden_samples = receiver.is_drawn ? hidden : 0.0;
}
