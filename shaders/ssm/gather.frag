// How much of one sub-light each receiver does not see: the twin of renderer/shadow/ssm/gather.cc, which explains it and
// is held to it by a test. Adds (share above the receiver's plane) (hidden fraction, 1); blending sums over sub-lights.
#include "common/receiver.glsl"
#include "ssm/cut_cell.glsl"
#include "ssm/window.glsl"

layout(location = 0) out vec2 hidden_and_share;

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
