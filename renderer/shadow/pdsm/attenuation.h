// Attenuation functions: for every ray of a PDSM the hidden fraction of the light as a function of depth d = z_near /
// z.
//
// A function is a polyline of vertices from the light outward (depths never rise; two vertices of one depth are a
// jump). It is 0 before its first vertex and keeps the last one's value to d = 0. No vertices: 0 everywhere. At the
// depth of a jump it has the value nearer to the light: a surface does not hide light from itself. Source: St-Amour et
// al. 2005, 3.2 and 4.1; the greedy segments are Lokovic and Veach 2000, 4.2. Pure; no GL.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace halfshade::pdsm {

struct Vertex {
  float depth = 0;
  float value = 0;  // in [0, 1]
};

struct AttenuationFunctions {
  int size = 0;                 // [size][size] functions
  std::vector<uint32_t> first;  // size^2 + 1: function r is vertices first[r] to, not including, first[r + 1]
  std::vector<Vertex> vertices;

  std::span<const Vertex> Function(size_t ray) const {
    return std::span(vertices).subspan(first[ray], first[ray + 1] - first[ray]);
  }
  uint64_t SizeBytes() const { return first.size() * sizeof(uint32_t) + vertices.size() * sizeof(Vertex); }
};

float Evaluate(std::span<const Vertex> function, float depth);

// Appends to `*out` a polyline that stays within eps of `function`, and within [0, 1], at every depth, and is exactly 0
// and 1 where the function is. eps >= 0.
void Compress(std::span<const Vertex> function, float eps, std::vector<Vertex>* out);

// The functions of one row of rays, compressed one after the other.
struct FunctionRow {
  std::vector<Vertex> vertices;
  std::vector<uint32_t> counts;
  void Add(std::span<const Vertex> exact, float eps);
};
AttenuationFunctions JoinRows(const std::vector<FunctionRow>& rows);

// At every depth of every ray a's value plus b's, at most 1: of two sets of occluders that do not hide the same part of
// the light. Of one size.
AttenuationFunctions Add(const AttenuationFunctions& a, const AttenuationFunctions& b);

struct FunctionCounts {
  double mean = 0;
  uint32_t most = 0;
};
FunctionCounts CountVertices(const AttenuationFunctions& functions);

}  // namespace halfshade::pdsm
