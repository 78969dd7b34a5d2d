// The fitted table of the area-light specular: linearly transformed cosines for GGX, by roughness and viewing angle.
//
// Heitz, Dupuy, Hill, Neubelt 2016, "Real-Time Polygonal-Light Shading with Linearly Transformed Cosines". Surface
// frame: z the normal, the view in the half plane x > 0, y = 0. A direction of the lobe is a matrix times a direction
// of the clamped cosine; kept is the inverse, scaled to a middle element of 1:
//   m11 0 m13
//    0  1  0
//   m31 0 m33
// Departure: the part of the cosine that the matrix takes below the surface is cut off, and the rest made up for it:
// reflected radiance = albedo * (cosine integral over the light above the surface) / LtcShareAbove.
// Made by fit_ltc.cc; shaders/common/ltc.glsl reads it.
#pragma once

#include <array>

namespace halfshade {

struct LtcEntry {
  double m11 = 1, m13 = 0, m31 = 0, m33 = 1;
  double albedo = 0;   // reflected share of light from everywhere, for Fresnel 1; in (0,1]
  double grazing = 0;  // the same with Schlick's (1 - cos)^5 as Fresnel; in [0, albedo]
};

inline constexpr int kLtcSize = 64;               // rows and columns
inline constexpr double kMinLtcRoughness = 0.02;  // shaded for anything smoother: a lobe of a fortieth of a degree
inline constexpr double kMinLtcCosine = 1e-3;

// Where the table's rows and columns stand: roughness evenly, the view at even steps of sqrt(1 - cosine).
double LtcRoughness(int row);
double LtcCosine(int column);

// [kLtcSize * row + column].
const std::array<LtcEntry, std::size_t{kLtcSize} * kLtcSize>& LtcTable();

// Between rows and columns, as the shader reads it; roughness and cosine in [0,1].
LtcEntry InterpolateLtc(double roughness, double cosine);

// The part of the cosine that the matrix leaves above the surface, in (0, 1]; below 1/2 only at grazing views. Closed
// form: the image of the surface's half space, as a cosine sees it.
double LtcShareAbove(const LtcEntry& entry);

// Of the whole hemisphere of unit radiance, for Schlick's Fresnel between f0 and 1; what is reflected once.
inline double SpecularAlbedo(const LtcEntry& entry, double f0) {
  return f0 * (entry.albedo - entry.grazing) + entry.grazing;
}

// By how much more a surface reflects than once, since what its facets block they reflect again: a white metal reflects
// all. Source: Turquin 2019, "Practical multiple scattering compensation for microfacet models", eq. 16.
inline double MultipleScattering(const LtcEntry& entry, double f0) { return 1 + f0 * (1 / entry.albedo - 1); }

}  // namespace halfshade
