// Adds one light to the frame: visibility times unshadowed diffuse and specular light.
#include "common/receiver.glsl"
#include "common/material.glsl"
#ifdef HAS_FOG
#include "shade/fog.glsl"
uniform float light_height;  // of the light's centre over the fog's ground
uniform vec3 up;             // in the light's frame
#endif

layout(location = 0) out vec4 color;

uniform sampler2D visibility;
uniform vec2 half_edges;
uniform vec3 emitted;  // radiance of a rectangle, intensity of a line or point; exposed

void main() {
  Receiver receiver = FetchReceiver(gl_FragCoord.xy);
  Surface surface = FetchSurface(ivec2(gl_FragCoord.xy));
  vec3 normal = light_from_camera * surface.normal;
  vec3 view = normalize(receiver.to_eye);
  vec2 texcoord = LtcTexcoord(surface.roughness, dot(normal, view));
  vec4 lobe = textureLod(ltc_lobes, texcoord, 0.0);
  vec2 albedos = textureLod(ltc_albedos, texcoord, 0.0).rg;
  vec3 specular_albedo = SpecularAlbedo(albedos, surface.f0);
#if defined(SHAPE_POINT)
  float irradiance = PointIrradiance(vec3(0.0), receiver.position, normal);
  vec3 specular = MultipleScattering(albedos, surface.f0) *
                  GgxPoint(receiver.position, normal, view, surface.roughness, surface.f0);
#elif defined(SHAPE_LINE)
  float irradiance = LineIrradiance(vec3(half_edges, 0.0), receiver.position, normal);
  vec3 specular = specular_albedo * LtcLine(half_edges, receiver.position, normal, view, lobe);
#else
  float irradiance = RectangleIrradiance(half_edges, receiver.position, normal);
  vec3 specular = specular_albedo * LtcRectangle(half_edges, receiver.position, normal, view, lobe);
#endif
  vec3 reflected = DiffuseAlbedo(surface, specular_albedo) * (irradiance / kPi) + specular;
  // Of the light above the horizon, the visible part: what is below is not in `reflected`. A share of -1: does not receive.
  vec2 visible_and_share = texelFetch(visibility, ivec2(gl_FragCoord.xy), 0).rg;
  float seen = visible_and_share.x / (visible_and_share.y > 0.0 ? visible_and_share.y : 1.0);
#ifdef HAS_FOG
  float way_m = length(receiver.position);
  seen *= exp(-OpticalDepth(ExtinctionAt(light_height), dot(receiver.position, up) / way_m, way_m));
#endif
  bool is_drawn = receiver.is_drawn && receiver.position.z > 0.0;
  color = is_drawn ? vec4(seen * emitted * reflected, 0.0) : vec4(0.0);
}
