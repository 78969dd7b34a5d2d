// One point of the fog a pixel, at which light is asked for: where a share of what the fog takes from the view lies nearer
// than it. Relative to the eye, world axes; a: how much of the view the fog takes, in all.
#include "common/receiver.glsl"
#include "shade/fog.glsl"

layout(location = 0) out vec4 point_and_opacity;

uniform float eye_height;  // over the fog's ground
uniform float step_index;
uniform float step_count;
uniform float background_m;  // how far the view goes on where nothing is drawn

// Steps of neighbouring pixels lie at other shares, all sixteen of a block of 4 x 4: an ordered dither.
float OffsetAt(ivec2 pixel) {
  ivec2 low = pixel & 1, high = (pixel >> 1) & 1;
  int order = 4 * (2 * (low.x ^ low.y) + low.y) + 2 * (high.x ^ high.y) + high.y;
  return (float(order) + 0.5) / 16.0;
}

void main() {
  vec4 plane = texelFetch(planes, ivec2(gl_FragCoord.xy), 0);
  bool is_drawn = plane != vec4(0.0);
  vec2 ndc = vec2(gl_FragCoord.x * ndc_from_pixel.x - 1.0, 1.0 - gl_FragCoord.y * ndc_from_pixel.y);
  vec3 across = ray_from_ndc[0] * ndc.x + ray_from_ndc[1] * ndc.y;
  vec3 origin = is_orthographic ? across : vec3(0.0);
  vec3 ray = is_orthographic ? ray_from_ndc[2] : across + ray_from_ndc[2];
  float size = length(ray);
  // A plane and its normal may both be doubled (does not receive): the ratio is the same.
  float along = (plane.w - dot(plane.xyz, origin)) / dot(plane.xyz, ray) * size;
  float view_m = is_drawn ? max(along, 0.0) : background_m;
  vec3 direction = ray / size;
  float extinction = ExtinctionAt(eye_height + origin.y);
  float opacity = Opacity(OpticalDepth(extinction, direction.y, view_m));
  float share = (step_index + OffsetAt(ivec2(gl_FragCoord.xy))) / step_count;
  float taken = share * opacity;
  float depth = taken < 1e-3 ? taken * (1.0 + 0.5 * taken) : -log(max(1.0 - taken, 1e-30));
  float length_m = extinction > 0.0 ? min(LengthOf(depth, extinction, direction.y), view_m) : 0.0;
  point_and_opacity = vec4(origin + direction * length_m, opacity);
}
