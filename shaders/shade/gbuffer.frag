// The receiver plane of the triangle seen through each pixel (shaders/common/receiver.glsl), and what shading needs.
layout(std430, binding = 0) readonly buffer Triangles {
  vec4 planes[];  // mesh frame: unit normal, offset from the mesh's origin
};

uniform mat4 camera_from_mesh;  // world axes, origin at the eye
uniform mat3 normal_from_mesh;  // inverse transpose
uniform int first_triangle;
uniform bool is_orthographic;
uniform vec3 forward;
uniform float plane_scale;  // 2 for what does not receive (common/receiver.glsl), else 1
uniform float object_id;

layout(location = 0) out vec4 receiver_plane;
layout(location = 7) out float out_object_id;  // dropped where no output needs it
#ifdef HAS_MATERIAL
in vec3 shading_normal;
in vec2 texcoord;
uniform vec4 base_color;
uniform bool has_texture;
uniform sampler2D base_color_texture;
layout(location = 1) out vec4 out_normal;
layout(location = 2) out vec4 out_base_color;
#endif

void main() {
  vec4 plane = planes[first_triangle + gl_PrimitiveID];
  vec3 normal = normalize(normal_from_mesh * plane.xyz);
  vec3 point = (camera_from_mesh * vec4(plane.xyz * plane.w, 1.0)).xyz;
  float offset = dot(normal, point);
  bool is_turned_away = is_orthographic ? dot(normal, forward) > 0.0 : offset > 0.0;
  if (is_turned_away) {
    normal = -normal;
    offset = -offset;
  }
  receiver_plane = vec4(normal, offset) * plane_scale;
  out_object_id = object_id;
#ifdef HAS_MATERIAL
  // glTF: without a normal the geometric one shades; seen from behind, the normal turns round.
  float len = length(shading_normal);
  vec3 smooth_normal = len > 0.0 ? shading_normal / len : normal;
  if (len > 0.0 && !gl_FrontFacing) smooth_normal = -smooth_normal;
  out_normal = vec4(smooth_normal, 1.0);
  vec4 color = base_color;
  if (has_texture) color *= texture(base_color_texture, texcoord);
  out_base_color = vec4(color.rgb, 1.0);
#endif
}
