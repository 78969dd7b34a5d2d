// Rows of the blocker search and of the filter in the map from a light's centre (Fernando 2005; windows of Buades et
// al. 2015, eq. 1). A window is blocker_taps or filter_taps rows of as many taps; `taps` 0: none is looked at, so that
// llvmpipe can pass a row over. A row that stands for a band of the map has its taps spread over the band's height.

uniform sampler2DArray maps;
uniform int blocker_taps;
uniform int filter_taps;
uniform bool is_gaussian;

const float kBelow = 1e-6;

// From edge to edge, in [-1,1]: what only just hides a part of the light is found too.
float BlockerPlace(int tap, int taps) { return 2.0 * float(tap) / float(max(taps - 1, 1)) - float(taps > 1); }

// Middles of as many strips of [-1,1].
float FilterPlace(int tap, int taps) { return (2.0 * float(tap) + 1.0) / float(taps) - 1.0; }

// A Gaussian's window ends at two deviations, and is as much wider than the light that, cut there, it spreads as far as
// the rectangle does (center_map.cc).
float FilterWeight(float place) { return is_gaussian ? exp(-2.0 * place * place) : 1.0; }

// In [-1/2, 1/2], evenly whatever part of the row is looked at: multiples of the golden ratio. A mirrored row's are
// mirrored.
float PlaceInBand(int tap, int taps) { return fract(0.618034 * (float(tap) - 0.5 * float(taps - 1)) + 0.5) - 0.5; }

MapTexel FetchAt(vec2 slope) { return FetchMapTexel(maps, 0.0, map_size, slope_per_texel, ToTexel(slope)); }

bool Hides(MapTexel shown, MapReceiver receiver) {
  vec2 center = first_center + shown.cell * slope_per_texel;
  return shown.depth_here > z_near * receiver.w &&
         HeightAbovePlane(shown.depth / z_near, center, receiver.height, receiver.error, receiver.normal) >
             receiver.slack;
}

// Sums of the depths z and counts of the blockers that may hide part of the light, `offset_v` off the receiver's row, a
// column for each third of the way from the receiver to the nearest blocker, in w.
mat3x2 SumBlockerThirds(MapReceiver receiver, float offset_v, int taps) {
  vec2 thirds = z_near * (receiver.w + vec2(1.0, 2.0) / 3.0 * receiver.window.reach);
  mat3x2 sums = mat3x2(0.0);
  for (int x = 0; x < taps; ++x) {
    vec2 offset = vec2(receiver.window.half_window.x * BlockerPlace(x, taps), offset_v);
    MapTexel shown = FetchAt(receiver.slope + offset);
    vec2 hides_within = half_edges * (shown.depth_here / z_near - receiver.w);
    bool is_blocker = Hides(shown, receiver) && all(lessThanEqual(abs(offset), hides_within));
    vec2 blocker = is_blocker ? vec2(z_near / shown.depth, 1.0) : vec2(0.0);
    bool is_first = shown.depth < thirds.x, is_last = shown.depth >= thirds.y;
    sums += mat3x2(is_first ? blocker : vec2(0.0), is_first || is_last ? vec2(0.0) : blocker, is_last ? blocker : vec2(0.0));
  }
  return sums;
}

vec2 SumBlockerRow(MapReceiver receiver, float offset_v, int taps) {
  mat3x2 sums = SumBlockerThirds(receiver, offset_v, taps);
  return sums[0] + sums[1] + sums[2];
}

// Weights of the hidden taps and of all, over the light's image at inverse depth w + reach. A tap stands for a point of
// the light. Those below the receiver's plane decide only where there are no others.
vec2 SumFilterRow(MapReceiver receiver, float reach, float place_v, float band, int taps) {
  vec2 sums = vec2(0.0);
  float row_weight = FilterWeight(place_v);
  for (int x = 0; x < taps; ++x) {
    vec2 on_light = half_edges * vec2(FilterPlace(x, taps), place_v);
    float weight = row_weight * FilterWeight(FilterPlace(x, taps));
    weight *= receiver.height + dot(receiver.normal.xy, on_light) > 0.0 ? 1.0 : kBelow;
    vec2 offset = reach * on_light + vec2(0.0, band * PlaceInBand(x, taps));
    bool is_hidden = Hides(FetchAt(receiver.slope + offset), receiver);
    sums += vec2(is_hidden ? weight : 0.0, weight);
  }
  return sums;
}
