// Rows of the map that pixels share (Buades et al. 2015, 3.2 and 3.3): which pixel stands where another's row is, and
// whether its row will do.
//
// Row textures: x the pixel's place on its ray (1/distance along the camera's axis; the distance where orthographic):
// affine over the picture on every plane, so that between pixels it is exact; kNowhere: not to be used. y its w. Then
// what is shared: sums of the blockers' depth and count, weighed by the reach of the search (rows of wider windows have
// sparser taps), of the third of them that is closest to the receiver, the other two in a texture of their own; or the
// hidden fraction of a blurred row and the reach of the filter.
//
// A row is looked up where the receiver's tangent plane meets it, between four pixels. It will do if what stands there
// is within a texel of the row's place, or half the distance of taps or rows, and within the threshold of the depth
// asked for. Pixels across a depth discontinuity pull the place away and fail, as pixels off the picture do.

const float kNowhere = -1e30;
const float kProvenLit = 0.0;    // reach of the filter where nothing hides any of the light,
const float kProvenDark = -1.0;  // and where everything does

uniform mat3 ndc_from_light;    // directions: inverse of light_from_camera ray_from_ndc
uniform vec2 picture_size;      // pixels
uniform bool is_relative;       // thresholds: of the receiver's depth, or metres

float PlaceOnRay(Receiver receiver) {
  float along = (ndc_from_light * (receiver.position - eye_in_light)).z;
  return is_orthographic ? along : 1.0 / along;
}

// The light is whole above the receiver's plane. Where the plane cuts it, as it does along a solid's terminator, rows
// are of no use to others: neighbours' planes cut it elsewhere.
bool SeesWholeLight(MapReceiver receiver) {
  return !receiver.is_behind && !receiver.leaves_map &&
         receiver.height > dot(abs(receiver.normal.xy), half_edges);
}

// Taps a side of a window: as many as asked for, but no more than two a texel, which is all that there is to see.
int TapsFor(float half_window_texels, int most) {
  return min(2 * int(min(ceil(2.0 * half_window_texels), 128.0)) + 1, most);
}

// A band of more than this part of half the window's height tells nothing of a row.
const float kMostOfWindow = 0.5;

// How far the row of a pixel is from its neighbour's, in slopes, on the receiver's plane: the band of the map that the
// row stands for. Point samples of it would tear edges along rows.
float BandHeight(Receiver receiver) {
  vec3 to = receiver.position - eye_in_light;
  float along = (ndc_from_light * to).z;
  float v = receiver.position.y / receiver.position.z;
  float band = 0.0;
  for (int axis = 0; axis < 2; ++axis) {
    vec3 step = light_from_camera * ray_from_ndc[axis] * ndc_from_pixel[axis];
    vec3 neighbour;
    if (is_orthographic) {
      vec3 ray = light_from_camera * ray_from_ndc[2];
      neighbour = receiver.position + step - ray * (dot(receiver.normal, step) / dot(receiver.normal, ray));
    } else {
      vec3 ray = to + step * along;
      neighbour = eye_in_light + ray * (dot(receiver.normal, to) / dot(receiver.normal, ray));
    }
    band = max(band, abs(neighbour.y / neighbour.z - v));
  }
  return band;
}

// The line over the picture on which the receiver's tangent plane shows the rows before and after its own. At offset t:
// the plane's point (u, v + t, 1) / w(t), in the camera's axes times w: all affine in t.
struct RowLine {
  vec2 pixel;
  vec3 start, step;  // times w: pixels across and down, along
  float w, w_step;
};

RowLine FindRowLine(MapReceiver receiver, vec2 pixel) {
  RowLine line;
  line.pixel = pixel;
  line.w = receiver.w;
  line.w_step = -receiver.normal.y / receiver.height;
  line.start = ndc_from_light * (vec3(receiver.slope, 1.0) - receiver.w * eye_in_light);
  line.step = ndc_from_light * (vec3(0.0, 1.0, 0.0) - line.w_step * eye_in_light);
  return line;
}

struct SharedRow {
  bool is_near;  // stands within `tolerance` of the place
  float w;       // of what stands there
  float w_asked;
  vec2 values;
  vec2 place;  // in the picture, 0..1
};

SharedRow FindRow(sampler2D rows, RowLine line, MapReceiver receiver, float offset, vec2 tolerance) {
  SharedRow row;
  row.w_asked = line.w + offset * line.w_step;
  vec3 there = line.start + offset * line.step;
  float scale_start = is_orthographic ? line.w : line.start.z;
  float scale = is_orthographic ? row.w_asked : there.z;
  float scale_step = is_orthographic ? line.w_step : line.step.z;
  // ndc.xy = there.xy / scale; the difference from the pixel's own place, so that offset 0 is the pixel itself.
  vec2 ndc_step = line.step.xy - line.start.xy / scale_start * scale_step;
  vec2 pixel = line.pixel + offset * ndc_step / scale * vec2(0.5, -0.5) * picture_size;
  vec4 found = textureLod(rows, pixel / picture_size, 0.0);
  float place = is_orthographic ? there.z / row.w_asked : row.w_asked / there.z;
  vec2 slope = receiver.slope + vec2(0.0, offset);
  vec3 asked = vec3(slope, 1.0) / row.w_asked;
  vec3 stands = is_orthographic ? asked + light_from_camera * ray_from_ndc[2] * (found.x - place)
                                : mix(eye_in_light, asked, place / found.x);
  vec2 off = abs(stands.xy / stands.z - slope);
  bool is_in_picture = all(greaterThanEqual(pixel, vec2(0.5))) && all(lessThanEqual(pixel, picture_size - 0.5));
  row.is_near = is_in_picture && scale > 0.0 && found.x > 0.0 && row.w_asked > 0.0 && stands.z > 0.0 &&
                all(lessThanEqual(off, tolerance));
  row.w = found.y;
  row.values = found.zw;
  row.place = pixel / picture_size;
  return row;
}

// |1/a - 1/b| below the threshold, for two w.
bool IsWithin(float threshold, float a, float b, float receiver_w) {
  return abs(a - b) < threshold * a * b / (is_relative ? receiver_w : 1.0);
}
