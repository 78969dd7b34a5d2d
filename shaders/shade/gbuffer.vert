// Primary visibility. Camera-relative world axes; the image's row 0 is the framebuffer's row 0, so y points down.
layout(location = 0) in vec3 position_ms;  // relative to the mesh's origin
#ifdef HAS_MATERIAL
layout(location = 1) in vec3 normal_ms;
uniform mat3 normal_from_mesh;
out vec3 shading_normal;
#endif
#if defined(HAS_MATERIAL) || defined(HAS_MASK)
layout(location = 2) in vec2 texcoord0_in;
layout(location = 3) in vec2 texcoord1_in;
layout(location = 5) in vec4 vertex_color_in;
out vec4 texcoords;  // first, second
out vec4 vertex_color;
#endif
#ifdef HAS_MAPS
layout(location = 4) in vec4 tangent_ms;
uniform mat4 camera_from_mesh;
uniform float handedness;  // -1: the mesh is mirrored
out vec4 tangent;
out vec3 position;
#endif

uniform mat4 clip_from_mesh;

void main() {
  gl_Position = clip_from_mesh * vec4(position_ms, 1.0);
#ifdef HAS_MATERIAL
  shading_normal = normal_from_mesh * normal_ms;
#endif
#if defined(HAS_MATERIAL) || defined(HAS_MASK)
  texcoords = vec4(texcoord0_in, texcoord1_in);
  vertex_color = vertex_color_in;
#endif
#ifdef HAS_MAPS
  tangent = vec4(mat3(camera_from_mesh) * tangent_ms.xyz, tangent_ms.w * handedness);
  position = (camera_from_mesh * vec4(position_ms, 1.0)).xyz;
#endif
}
