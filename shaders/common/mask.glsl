// glTF's alpha. The finest level of the mask decides, at every distance and in every map: mips average alpha, so leaves
// would thin out with distance, and a tree and its shadow would not be of one shape.
uniform sampler2D mask;  // alpha in red
uniform bool has_mask_texture;

// `cutoff`: of MASK the material's, of BLEND its place's.
bool IsMaskedAway(vec2 texcoord, float alpha, float cutoff) {
  if (has_mask_texture) alpha *= textureLod(mask, texcoord, 0.0).r;
  return alpha < cutoff;
}
