// Primary visibility. Camera-relative world axes; the image's row 0 is the framebuffer's row 0, so y points down.
layout(location = 0) in vec3 position_ms;  // relative to the mesh's origin
#ifdef HAS_MATERIAL
layout(location = 1) in vec3 normal_ms;
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
out vec4 tangent;
out vec3 position;
#endif

// Of the instance.
layout(location = 6) in mat4 clip_from_mesh;
layout(location = 10) in mat3x4 camera_from_mesh_rows;  // world axes, origin at the eye
layout(location = 13) in mat3x4 normal_from_mesh_etc;   // columns; w: -1 where mirrored, scale of planes, object id
flat out mat3x4 camera_from_mesh_transposed;
flat out mat3x4 normal_from_mesh;

void main() {
  camera_from_mesh_transposed = camera_from_mesh_rows;
  normal_from_mesh = normal_from_mesh_etc;
  gl_Position = clip_from_mesh * vec4(position_ms, 1.0);
#ifdef HAS_MATERIAL
  shading_normal = mat3(normal_from_mesh_etc) * normal_ms;
#endif
#if defined(HAS_MATERIAL) || defined(HAS_MASK)
  texcoords = vec4(texcoord0_in, texcoord1_in);
  vertex_color = vertex_color_in;
#endif
#ifdef HAS_MAPS
  mat4x3 camera_from_mesh = transpose(camera_from_mesh_rows);
  tangent = vec4(mat3(camera_from_mesh) * tangent_ms.xyz, tangent_ms.w * normal_from_mesh_etc[0].w);
  position = camera_from_mesh * vec4(position_ms, 1.0);
#endif
}
