// What a surface of GGX reflects of a light: linearly transformed cosines (renderer/shade/ltc/ltc_table.h) for rectangles
// and lines, the BRDF itself for points. All for Fresnel 1, radiance or intensity 1; light frame.
#include "common/form_factor.glsl"

uniform sampler2D ltc_lobes;    // m11, m13, m31, m33
uniform sampler2D ltc_albedos;  // albedo, grazing
uniform vec2 ltc_layout;        // smallest roughness; columns and rows of the tables

float LtcRoughness(float roughness) { return max(roughness, ltc_layout.x); }

// Texel centres stand on the fitted values.
vec2 LtcTexcoord(float roughness, float cosine) {
  vec2 unit = vec2(sqrt(1.0 - clamp(cosine, 0.0, 1.0)), (LtcRoughness(roughness) - ltc_layout.x) / (1.0 - ltc_layout.x));
  return (unit * (ltc_layout.y - 1.0) + 0.5) / ltc_layout.y;
}

// By how much more a surface reflects than once (MultipleScattering of ltc_table.h).
vec3 MultipleScattering(vec2 albedos, vec3 f0) { return 1.0 + f0 * (1.0 / albedos.x - 1.0); }

// Of light from everywhere: the reflected share for Schlick's Fresnel from f0 to 1.
vec3 SpecularAlbedo(vec2 albedos, vec3 f0) {
  return (f0 * (albedos.x - albedos.y) + albedos.y) * MultipleScattering(albedos, f0);
}

// Rows: axes of the surface, the view in the half plane x > 0, y = 0. Any axes where the view is the normal.
mat3 SurfaceFromLight(vec3 n, vec3 view) {
  vec3 across = view - n * dot(n, view);
  vec3 other = cross(n, abs(n.x) < 0.7 ? vec3(1.0, 0.0, 0.0) : vec3(0.0, 1.0, 0.0));
  vec3 x = normalize(dot(across, across) > 1e-12 ? across : other);
  return transpose(mat3(x, cross(n, x), n));
}

// The share of a lobe that the rectangle fills: the cosine integral over its part above the surface, transformed.
float LtcRectangle(vec2 half_edges, vec3 position, vec3 n, vec3 view, vec4 lobe) {
  float scale = UnitScale(half_edges, position);
  position *= scale;
  half_edges *= scale;
  mat3 cosine_from_light = mat3(lobe.x, 0.0, lobe.z, 0.0, 1.0, 0.0, lobe.y, 0.0, lobe.w) * SurfaceFromLight(n, view);
  Clip horizon = MakeClip(position, n);
  Clip cosine = MakeClip(position, transpose(cosine_from_light)[2]);
  const vec3 up = vec3(0.0, 0.0, 1.0);
  float sum = 0.0;
  for (int i = 0; i < 5; ++i) {
    vec2 a = i < 4 ? kCornerSigns[i] * half_edges : horizon.dive;
    vec2 b = i < 4 ? kCornerSigns[i + 1] * half_edges : horizon.rise;
    bool is_there = i < 4 ? ClipEdge(horizon, a, b) : horizon.is_cut;
    if (is_there && ClipEdge(cosine, a, b)) {
      sum += EdgeIrradiance(cosine_from_light * (vec3(a, 0.0) - position), cosine_from_light * vec3(b - a, 0.0), up);
    }
  }
  if (cosine.is_cut) {
    sum += EdgeIrradiance(cosine_from_light * (vec3(cosine.dive, 0.0) - position),
                          cosine_from_light * vec3(cosine.rise - cosine.dive, 0.0), up);
  }
  float share_above = 0.5 + 0.5 * lobe.x / length(lobe.xz);
  return min(abs(sum) / (2.0 * kPi * share_above), 1.0);
}

// A line is a strip, this fraction of its distance wide: as sharp as a lobe needs, and far from the precision of floats.
const float kStripWidth = 1.0 / 256.0;

float LtcLine(vec2 half_edges, vec3 position, vec3 n, vec3 view, vec4 lobe) {
  vec2 strip = max(half_edges, vec2(0.5 * kStripWidth * length(position)));
  return LtcRectangle(strip, position, n, view, lobe) / (4.0 * strip.x * strip.y);
}

// GGX with height-correlated shadowing, Fresnel and all, for a point at the light's centre.
vec3 GgxPoint(vec3 position, vec3 n, vec3 view, float roughness, vec3 f0) {
  float alpha = LtcRoughness(roughness) * LtcRoughness(roughness);
  vec3 light = -normalize(position);
  vec3 half_vector = normalize(light + view);
  float n_light = dot(n, light);
  float n_view = max(dot(n, view), 1e-4);
  vec3 off_normal = cross(n, half_vector);  // sine: does not cancel near the normal
  float n_half = dot(n, half_vector);
  float spread = dot(off_normal, off_normal) + alpha * alpha * n_half * n_half;
  float density = alpha * alpha / (kPi * spread * spread);
  float root_view = sqrt(n_view * n_view * (1.0 - alpha * alpha) + alpha * alpha);
  float root_light = sqrt(n_light * n_light * (1.0 - alpha * alpha) + alpha * alpha);
  float brdf = density * 0.5 / (max(n_light, 1e-6) * root_view + n_view * root_light);
  vec3 fresnel = f0 + (1.0 - f0) * pow(1.0 - clamp(dot(half_vector, light), 0.0, 1.0), 5.0);
  return fresnel * (brdf * PointIrradiance(vec3(0.0), position, n));
}
