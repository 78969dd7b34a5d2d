// Depth only; a MASK material's occluders only where they are.
#ifdef HAS_MASK
#include "common/mask.glsl"

in vec3 texcoord_and_alpha;

void main() {
  if (IsMaskedAway(texcoord_and_alpha.xy, texcoord_and_alpha.z)) discard;
}
#else
void main() {}
#endif
