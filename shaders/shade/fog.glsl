// A medium whose extinction falls with height: closed forms along straight lines.

uniform float fog_density;        // extinction per metre at fog's ground
uniform float fog_inverse_height; // 1 / falloff height, 0: homogeneous

const float kLargestExponent = 80.0;
const float kLargestDepth = 1e30;  // optical: nothing is seen through it

// (1 - exp(-x)) / x
float FallOff(float x) {
  return abs(x) < 1e-3 ? 1.0 - 0.5 * x : (1.0 - exp(clamp(-x, -kLargestExponent, kLargestExponent))) / x;
}

float ExtinctionAt(float height) {
  return fog_density * exp(clamp(-height * fog_inverse_height, -kLargestExponent, kLargestExponent));
}

// Optical depth along `length` metres from a place of this extinction; `climb`: height gained a metre.
float OpticalDepth(float extinction, float climb, float length) {
  return min(extinction * length * FallOff(climb * fog_inverse_height * length), kLargestDepth);
}

// The length whose optical depth is `depth`, less than that of the whole ray.
float LengthOf(float depth, float extinction, float climb) {
  float rate = climb * fog_inverse_height;
  float straight = depth / extinction;
  float bend = rate * straight;
  return abs(bend) < 1e-3 ? straight * (1.0 + 0.5 * bend) : -log(max(1.0 - bend, 1e-30)) / rate;
}

// 1 - exp(-depth), to float precision of itself.
float Opacity(float depth) { return depth < 1e-3 ? depth * (1.0 - 0.5 * depth) : 1.0 - exp(-depth); }
