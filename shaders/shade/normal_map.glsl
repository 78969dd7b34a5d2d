// Normal maps. The tangent is the file's; where it has none, the direction in which u grows over the triangle, from
// screen derivatives: what MikkTSpace gives before it averages over the triangles round a vertex.
in vec4 tangent;   // w: sign of the bitangent; 0: none
in vec3 position;  // camera-relative world axes
uniform sampler2D normal_texture;
uniform float normal_scale;  // 0: no map

// Tangent and sign of the bitangent cross(normal, tangent): glTF's maps have +y against v.
vec4 DerivedTangent(vec3 normal, vec2 texcoord) {
  vec3 p_x = dFdx(position);
  vec3 p_y = dFdy(position);
  vec2 t_x = dFdx(texcoord);
  vec2 t_y = dFdy(texcoord);
  float orientation = t_x.x * t_y.y - t_y.x * t_x.y < 0.0 ? -1.0 : 1.0;
  vec3 along_u = orientation * (p_x * t_y.y - p_y * t_x.y);
  vec3 along_v = orientation * (p_y * t_x.x - p_x * t_y.x);
  return vec4(along_u, dot(cross(normal, along_u), along_v) > 0.0 ? -1.0 : 1.0);
}

// The normal of the front side.
vec3 MapNormal(vec3 normal, vec2 texcoord) {
  vec3 mapped = texture(normal_texture, texcoord).xyz * 2.0 - 1.0;
  vec4 frame = tangent.w != 0.0 ? tangent : DerivedTangent(normal, texcoord);
  vec3 t = frame.xyz - normal * dot(normal, frame.xyz);
  float len = length(t);
  t = len > 0.0 ? t / len : vec3(0.0);
  vec3 b = cross(normal, t) * sign(frame.w);
  vec3 turned = t * (mapped.x * normal_scale) + b * (mapped.y * normal_scale) + normal * mapped.z;
  float size = length(turned);
  return len > 0.0 && normal_scale != 0.0 && size > 0.0 ? turned / size : normal;
}
