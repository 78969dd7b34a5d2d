// Linear sRGB colours, exposed and >= 0, to what a display shows: [0,1], still linear.

// Past every curve's end, and far from where its terms would overflow.
const float kBrightest = 65504.0;

// Hill's fit of the ACES reference rendering and output transforms for sRGB (BakingLab, 2016). Unlike curves on each
// channel alone it lets saturated colours fade to white as they grow.
vec3 ToneMapAces(vec3 color) {
  const mat3 curve_from_srgb = transpose(mat3(0.59719, 0.35458, 0.04823,  //
                                              0.07600, 0.90834, 0.01566,  //
                                              0.02840, 0.13383, 0.83777));
  const mat3 srgb_from_curve = transpose(mat3(1.60475, -0.53108, -0.07367,  //
                                              -0.10208, 1.10813, -0.00605,  //
                                              -0.00327, -0.07276, 1.07602));
  vec3 x = curve_from_srgb * color;
  vec3 y = (x * (x + 0.0245786) - 0.000090537) / (x * (0.983729 * x + 0.4329510) + 0.238081);
  return clamp(srgb_from_curve * y, 0.0, 1.0);
}

// Khronos PBR Neutral (2024): base colours up to .8 keep their hue and value but for the 4 % that a dielectric reflects;
// what is brighter is compressed toward 1 and fades to white.
vec3 ToneMapNeutral(vec3 color) {
  const float start = 0.8 - 0.04;
  const float room = 1.0 - start;
  float darkest = min(color.r, min(color.g, color.b));
  color -= darkest < 0.08 ? darkest - 6.25 * darkest * darkest : 0.04;
  float peak = max(color.r, max(color.g, color.b));
  if (peak < start) return color;
  float new_peak = 1.0 - room * room / (peak - start + room);
  float fade = 1.0 - 1.0 / (0.15 * (peak - new_peak) + 1.0);
  return mix(color * (new_peak / peak), vec3(new_peak), fade);
}

// 0 none, 1 ACES, 2 neutral: halfshade::ToneMap.
vec3 ToneMap(int curve, vec3 color) {
  if (curve == 1) return ToneMapAces(min(color, kBrightest));
  if (curve == 2) return ToneMapNeutral(min(color, kBrightest));
  return color;
}
