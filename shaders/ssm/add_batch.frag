// A batch of patches, added to the others by blending.
layout(location = 0) out float hidden;

uniform sampler2D batch;

void main() { hidden = texelFetch(batch, ivec2(gl_FragCoord.xy), 0).r; }
