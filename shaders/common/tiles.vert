// Square tiles of the picture as points: what is not in the list is not rasterised, on every kind of GL.
layout(location = 0) in vec2 center_pixels;  // from the top left corner

uniform vec2 ndc_from_viewport;  // 2 / its size
uniform float tile_pixels;

void main() {
  gl_Position = vec4(center_pixels * ndc_from_viewport - 1.0, 0.0, 1.0);
  gl_PointSize = tile_pixels;
}
