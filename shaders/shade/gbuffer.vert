// Primary visibility. Camera-relative world axes; the image's row 0 is the framebuffer's row 0, so y points down.
layout(location = 0) in vec3 position_ms;  // relative to the mesh's origin
#ifdef HAS_MATERIAL
layout(location = 1) in vec3 normal_ms;
layout(location = 2) in vec2 texcoord_in;
uniform mat3 normal_from_mesh;
out vec3 shading_normal;
out vec2 texcoord;
#endif

uniform mat4 clip_from_mesh;

void main() {
  gl_Position = clip_from_mesh * vec4(position_ms, 1.0);
#ifdef HAS_MATERIAL
  shading_normal = normal_from_mesh * normal_ms;
  texcoord = texcoord_in;
#endif
}
