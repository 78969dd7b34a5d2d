// First pass of a frame: ambient light where something is drawn, the background elsewhere. Alpha is coverage.
layout(location = 0) out vec4 color;

uniform sampler2D planes;
uniform sampler2D base_colors;
uniform vec3 ambient;     // exposed
uniform vec3 background;  // exposed

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  bool is_drawn = texelFetch(planes, pixel, 0).xyz != vec3(0.0);
  color = is_drawn ? vec4(ambient * texelFetch(base_colors, pixel, 0).rgb, 1.0) : vec4(background, 0.0);
}
