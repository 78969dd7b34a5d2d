// Depth only; a MASK or BLEND material's occluders only where they are.
#ifdef HAS_MASK
#include "common/mask.glsl"

in vec3 texcoord_and_alpha;
#ifdef HAS_BLEND
#include "common/blend.glsl"
in vec3 blend_place_here;
#else
uniform float alpha_cutoff;
#endif

void main() {
#ifdef HAS_BLEND
  float cutoff = BlendThreshold(blend_place_here);
#else
  float cutoff = alpha_cutoff;
#endif
  if (IsMaskedAway(texcoord_and_alpha.xy, texcoord_and_alpha.z, cutoff)) discard;
}
#else
void main() {}
#endif
