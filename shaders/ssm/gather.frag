// How much of one sub-light each receiver does not see: the twin of renderer/shadow/ssm/gather.cc, which explains it and
// is held to it by a test. Adds (share above the receiver's plane) (hidden fraction, 1); blending sums over sub-lights.
#include "common/receiver.glsl"
#include "ssm/cut_cell.glsl"

layout(location = 0) out vec2 hidden_and_share;

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

// x: hidden share of the window, y: its moment of depths ahead.
vec2 SumNearTexels(View view, ivec4 box, float end_place, float at_ahead) {
  Map map = TableOf();
  int stride = max(1, (box.w - box.y + kMostRows - 1) / kMostRows);
  vec2 steepest = kSteepest * slope_per_texel;
  vec2 sum = vec2(0.0);
  for (int y = max(box.y, 1); y < min(box.w, map_size - 1); y += stride) {
    for (int x = max(box.x, 1); x < min(box.z, map_size - 1); ++x) {
      float shown = Depth(x, y);
      vec2 from = vec2(float(x), float(y)) + 0.5 - view.place;
      float away_x = Depth(from.x > 0.0 ? x + 1 : x - 1, y);
      float away_y = Depth(x, from.y > 0.0 ? y + 1 : y - 1);
      vec2 fall = min(max(vec2(away_x, away_y) - shown, 0.0), shown * steepest);
      float depth = shown - dot(fall, min(abs(from), kCarriedTexels));
      float ahead = depth - view.depth;
      float place = (shown - map.first_depth) * map.slabs_per_depth;
      bool is_near = ahead > 0.0 && place < end_place;
      float above = (shown - view.depth) * view.up + dot(from, view.b) - view.least - shown * view.slack;
      float weight = clamp(above * view.per_ramp, 0.0, 1.0);
      float window = at_ahead > 0.0 ? at_ahead : ahead;
      vec2 half_width = max(view.half_width * window, vec2(kLeastHalfWindow));
      vec2 middle = view.middle * window;
      vec2 low = from - 0.5;
      vec2 cover = max(min(low + 1.0, middle + half_width) - max(low, middle - half_width), 0.0);
      float share = is_near ? cover.x * cover.y * weight / (half_width.x * half_width.y) : 0.0;
      sum += vec2(share, share * ahead);
    }
  }
  return 0.25 * float(stride) * sum;
}

int LastSlabUpTo(Map map, float depth) {
  return depth < map.first_depth ? -1 : int(min((depth - map.first_depth) * map.slabs_per_depth, float(slabs - 1)));
}

float SlabStart(Map map, int slab) { return map.first_depth + float(slab) * map.slab_depth; }

float HiddenFraction(View view) {
  Map map = TableOf();
  if (map.nearest_depth == 0.0) return 0.0;
  int near_slab = LastSlabUpTo(map, view.near_depth);
  ivec4 box = ivec4(0);
  float nearest = 0.0;
  int top_slab = slabs - 1;
  for (int round = 0; round <= slabs; ++round) {
    nearest = min(map.nearest_depth, SlabStart(map, top_slab + 1));
    if (nearest <= view.depth) return 0.0;
    box = InPatches(Reach(view, nearest));
    if (IsEmpty(box) || BoxSum(box, 0) == 0u) return 0.0;
    int next = top_slab;
    while (BoxSum(box, next) == 0u) --next;
    if (next == top_slab) break;
    top_slab = next;
  }
  uint area_beyond = near_slab + 1 < slabs ? BoxSum(box, near_slab + 1) : 0u;
  if (area_beyond == uint(kFullPatch) * uint(box.z - box.x) * uint(box.w - box.y)) return 1.0;

  vec2 sum = vec2(0.0);
  for (int slab = near_slab + 1; slab <= top_slab; ++slab) {
    uint area = BoxSum(box, slab) - (slab + 1 < slabs ? BoxSum(box, slab + 1) : 0u);
    if (area == 0u) continue;
    float place = float(BoxSum(box, slabs + slab)) / (kPlaces * float(area));
    float ahead = SlabStart(map, slab) + place * map.slab_depth - view.depth;
    float share = CoveredShare(view, ahead, slab, false);
    sum += vec2(share, share * ahead);
  }
  bool is_last = near_slab + 1 >= slabs;
  float near_end = is_last ? kInfinity : float(near_slab + 1);
  vec2 near = vec2(0.0);
  if (near_slab >= 0 && BoxSum(box, 0) > area_beyond) {
    near = SumNearTexels(view, Reach(view, is_last ? nearest : min(nearest, SlabStart(map, near_slab + 1))), near_end, 0.0);
  }
  sum += near;
  if (!(sum.x > 0.0)) return 0.0;
  float ahead = sum.y / sum.x;
  float seen = 1.0;
  if (area_beyond > 0u) seen -= CoveredShare(view, ahead, near_slab + 1, true);
  if (near.x > 0.0) seen -= SumNearTexels(view, Reach(view, view.depth + ahead), near_end, ahead).x;
  return seen > 16.0 * kUlp ? sum.x / (sum.x + seen) : 1.0;
}

bool LeavesMap(Receiver receiver) {
  float w = 1.0 / receiver.position.z;
  vec2 slope = abs((receiver.position.xy - light_point) * w);
  vec2 reach = slope + half_edges * max(tables[0].w / z_near - w, 0.0) + 2.0 * slope_per_texel;
  return max(reach.x, reach.y) > side_slope;
}

void main() {
  Receiver receiver = FetchReceiver(gl_FragCoord.xy);
  hidden_and_share = vec2(0.0);
  if (!receiver.is_receiving || receiver.position.z <= 0.0) return;
  LitPart part = CutCell(half_edges, receiver.normal.xy, dot(receiver.normal.xy, light_point) - receiver.offset);
  if (part.share <= 0.0) return;
  float hidden = 0.0;
  if (side_slope > 0.0 && LeavesMap(receiver)) {
    hidden = texelFetch(hidden_point, ivec2(gl_FragCoord.xy), 0).r;
  } else {
    for (layer = 0; layer < layer_count; ++layer) hidden = max(hidden, HiddenFraction(MakeView(part, receiver)));
  }
  hidden_and_share = part.share * vec2(hidden, 1.0);
}
