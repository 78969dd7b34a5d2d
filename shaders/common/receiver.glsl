// What gets a shadow: one point and its tangent plane, rebuilt from the receiver-plane texture in the frame of a light
// (origin at the light's centre, x and y along its edges, z its normal).
//
// planes: rgb the geometric normal in world axes, turned to the camera; a the plane's offset: n.(x - eye) = a for every
// point x of the plane. All zero: nothing is drawn there; normal and offset times 2: it does not receive.
// A zero normal and a far below: a point without a horizon.
// points: positions relative to the eye, where receivers are not pixels.

struct Receiver {
  bool is_drawn;
  bool is_receiving;
  vec3 position;
  vec3 to_eye;   // not unit
  vec3 normal;
  float offset;  // normal . x = offset on the tangent plane
  float error;   // metres by which position and plane may be off: 4 ulps of the distances they were made from
};

uniform sampler2D planes;
uniform sampler2D points;
uniform bool are_points;
uniform mat3 ray_from_ndc;          // world axes: columns right, up, forward, scaled to the edges of the view
uniform bool is_orthographic;
uniform vec2 ndc_from_pixel;        // 2 / size
uniform mat3 light_from_camera;     // rotation from world axes
uniform vec3 eye_in_light;

Receiver FetchReceiver(vec2 fragment) {
  vec4 plane = texelFetch(planes, ivec2(fragment), 0);
  bool is_doubled = dot(plane.xyz, plane.xyz) > 2.0;
  plane *= is_doubled ? 0.5 : 1.0;  // exact
  vec2 ndc = vec2(fragment.x * ndc_from_pixel.x - 1.0, 1.0 - fragment.y * ndc_from_pixel.y);  // row 0 on top
  vec3 across = ray_from_ndc[0] * ndc.x + ray_from_ndc[1] * ndc.y;
  vec3 origin = is_orthographic ? across : vec3(0.0);
  vec3 ray = is_orthographic ? ray_from_ndc[2] : across + ray_from_ndc[2];
  Receiver receiver;
  receiver.is_drawn = plane != vec4(0.0);
  receiver.is_receiving = receiver.is_drawn && !is_doubled;
  float along = (plane.w - dot(plane.xyz, origin)) / dot(plane.xyz, ray);
  vec3 from_eye = are_points ? texelFetch(points, ivec2(fragment), 0).xyz : origin + ray * along;
  receiver.position = light_from_camera * from_eye + eye_in_light;
  receiver.to_eye = -(light_from_camera * ray);
  receiver.normal = light_from_camera * plane.xyz;
  receiver.error = 4.0 * 1.1920929e-7 * (length(receiver.position) + length(eye_in_light));
  receiver.offset = plane.w + dot(receiver.normal, eye_in_light);
  return receiver;
}
