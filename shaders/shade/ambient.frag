// First pass of a frame: what surfaces emit and reflect of the ambient light, exact for a radiance that is the same from
// everywhere; the background elsewhere. Alpha is coverage.
#include "common/receiver.glsl"
#include "common/material.glsl"

layout(location = 0) out vec4 color;

uniform sampler2D emissions;  // a: occlusion of ambient light
uniform vec3 ambient;         // exposed
uniform vec3 background;      // exposed
uniform float exposure;

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  Receiver receiver = FetchReceiver(gl_FragCoord.xy);
  Surface surface = FetchSurface(pixel);
  vec4 emission = texelFetch(emissions, pixel, 0);
  float cosine = dot(surface.normal, normalize(receiver.to_eye));
  vec2 albedos = textureLod(ltc_albedos, LtcTexcoord(surface.roughness, cosine), 0.0).rg;
  vec3 specular_albedo = SpecularAlbedo(albedos, surface.f0);
  vec3 reflected = ambient * emission.a * (DiffuseAlbedo(surface, specular_albedo) + specular_albedo);
  color = receiver.is_drawn ? vec4(reflected + emission.rgb * exposure, 1.0) : vec4(background, 0.0);
}
