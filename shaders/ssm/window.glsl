// A receiver's view of a binned map, and what its tables hold of a window: the twin of renderer/shadow/ssm/window-inl.h.
// Reads receivers (common/receiver.glsl) and lit parts (ssm/cut_cell.glsl).

const float kUlp = 1.1920929e-7;
const float kLeastHalfWindow = 0.5;
const float kRampTexels = 0.25;
const int kMostRows = 48;
const float kCarriedTexels = 1.0;
const float kSteepest = 8.0;
const float kFullPatch = 256.0;
const float kPlaces = 16.0;
const float kInfinity = 1e30;

struct Map {
  float first_depth;
  float slab_depth;
  float slabs_per_depth;
  float nearest_depth;
};

layout(std430, binding = 2) readonly buffer NearestSums { uint nearest_sums[]; };
layout(std430, binding = 3) readonly buffer FurthestSums { uint furthest_sums[]; };
uniform sampler2D depths[2];
uniform vec4 tables[2];  // first_depth, slab_depth, slabs_per_depth, nearest_depth
uniform int layer_count;
uniform int table_size;  // patches a side
uniform int slabs;
uniform int entry;       // numbers a patch
uniform int texels_per_patch;
uniform int map_size;    // texels a side
uniform vec2 first_center;
uniform vec2 slope_per_texel;
uniform float z_near;
uniform vec2 light_point;
uniform vec2 half_edges;  // of the sub-light
uniform float side_slope;  // occluders beyond it are not in the maps; 0: all are
uniform sampler2D hidden_point;  // where side_slope: 1 where the point itself is hidden

int layer = 0;  // that is looked at

Map TableOf() { return Map(tables[layer].x, tables[layer].y, tables[layer].z, tables[layer].w); }
uint Sum(int x, int y, int i) {
  int at = (y * (table_size + 1) + x) * entry + i;
  return layer == 0 ? nearest_sums[at] : furthest_sums[at];
}
float Depth(int x, int y) {
  return layer == 0 ? texelFetch(depths[0], ivec2(x, y), 0).r : texelFetch(depths[1], ivec2(x, y), 0).r;
}
uint BoxSum(ivec4 box, int i) {
  return Sum(box.z, box.w, i) - Sum(box.z, box.y, i) - Sum(box.x, box.w, i) + Sum(box.x, box.y, i);
}

struct View {
  vec2 place;
  float depth;
  vec2 middle;
  vec2 half_width;
  float up, slack;
  vec2 b;
  float least, per_ramp;
  float near_depth;
};

View MakeView(LitPart part, Receiver receiver) {
  Map map = TableOf();
  View view;
  float w = 1.0 / receiver.position.z;
  view.place = ((receiver.position.xy - light_point) * w - first_center) / slope_per_texel + 0.5;
  view.depth = w * z_near;
  view.middle = part.middle / (z_near * slope_per_texel);
  view.half_width = part.half_edges / (z_near * slope_per_texel);
  vec3 normal = receiver.normal;
  float height = dot(normal.xy, light_point) - receiver.offset;
  view.up = height / z_near;
  view.slack = (4.0 * kUlp * abs(height) + receiver.error) / z_near;
  view.b = normal.xy * slope_per_texel;
  float change = abs(view.b.x) + abs(view.b.y);
  view.least = 1e-3 * change;
  view.per_ramp = 1.0 / (kRampTexels * change + 1e-30);
  float half_rise = dot(abs(normal.xy), part.half_edges);
  float lowest = height + dot(normal.xy, part.middle) - half_rise;
  float rise = 2.0 * float(texels_per_patch) * change * z_near + 2.0 * half_rise * map.slab_depth +
               receiver.error * view.depth;
  view.near_depth = view.depth * (1.0 + 8.0 * kUlp) + (rise > 0.0 ? rise / max(lowest, 1e-3 * rise) : 0.0);
  return view;
}

ivec4 Reach(View view, float depth) {
  float ahead = max(depth - view.depth, 0.0);
  vec2 below = min((view.middle - view.half_width) * ahead, vec2(0.0)) - kLeastHalfWindow;
  vec2 above = max((view.middle + view.half_width) * ahead, vec2(0.0)) + kLeastHalfWindow;
  vec2 size = vec2(float(map_size));
  return ivec4(ivec2(floor(clamp(view.place + below, vec2(0.0), size))),
               ivec2(ceil(clamp(view.place + above, vec2(0.0), size))));
}

bool IsEmpty(ivec4 box) { return box.z <= box.x || box.w <= box.y; }

ivec4 InPatches(ivec4 box) {
  return ivec4(box.xy / texels_per_patch, (box.zw + texels_per_patch - 1) / texels_per_patch);
}

uint Area(int x, int y, int slab, bool and_nearer) {
  uint nearer = !and_nearer && slab + 1 < slabs ? Sum(x, y, slab + 1) : 0u;
  return Sum(x, y, slab) - nearer;
}

void MakeCuts(float low, float high, out ivec4 at, out vec4 weight) {
  low = clamp(low, 0.0, float(table_size));
  high = clamp(high, 0.0, float(table_size));
  int first = min(int(low), table_size - 1);
  int last = min(int(high), table_size - 1);
  at = ivec4(first, first + 1, last, last + 1);
  weight = vec4(0.0, float(first) - low, 1.0 - (high - float(last)), high - float(last));
}

float CoveredShare(View view, float ahead, int slab, bool and_nearer) {
  vec2 middle = (view.place + view.middle * ahead) / float(texels_per_patch);
  vec2 half_width = max(view.half_width * ahead, vec2(kLeastHalfWindow)) / float(texels_per_patch);
  ivec4 x, y;
  vec4 x_weight, y_weight;
  MakeCuts(middle.x - half_width.x, middle.x + half_width.x, x, x_weight);
  MakeCuts(middle.y - half_width.y, middle.y + half_width.y, y, y_weight);
  uint top[4];
  for (int i = 0; i < 4; ++i) top[i] = Area(x[i], y.x, slab, and_nearer);
  float sum = 0.0;
  for (int j = 1; j < 4; ++j) {
    uint left = Area(x.x, y[j], slab, and_nearer);
    float row = 0.0;
    for (int i = 1; i < 4; ++i) {
      row += x_weight[i] * float(Area(x[i], y[j], slab, and_nearer) - left - top[i] + top[0]);
    }
    sum += y_weight[j] * row;
  }
  return sum / (4.0 * kFullPatch * half_width.x * half_width.y);
}
