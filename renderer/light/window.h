// The window of a map: which part of light perspective space (u = x/z, v = y/z from a point of the light) it covers.
//
// Light frame, metres. For a point s of the light an occluder at (x, y, z) stands at u = (x - s_x)/z: affine in s_x for
// each occluder, so the smallest u over all occluders is concave in s_x and the largest convex. Knowing both at the two
// ends of the light therefore bounds them for every sample between: a hull is four numbers an axis, found in one pass
// over the vertices, and every window is conservative.
#pragma once

#include <glm/glm.hpp>

namespace halfshade {

// A rectangle of a map's image plane. Empty when u1 < u0.
struct Window {
  double u0 = 0, v0 = 0, u1 = -1, v1 = -1;
  bool IsEmpty() const { return !(u0 <= u1 && v0 <= v1); }
};

// Windows do not reach beyond this slope (methods.md 0) ...
inline constexpr double kMaxWindowSlope = 8;
// ... and where occluders do, five windows share the half space instead: the front one ends here and each side window
// begins here. One wide window would spend nearly all of its texels on grazing directions.
inline constexpr double kSideWindowSlope = 1;

// The extent of the occluders in front of the light, in slopes, as seen from every point of the light.
class OccluderHull {
 public:
  // Half edges of the light, >= 0; points nearer to the light's plane than z_near are clipped away.
  OccluderHull(double half_width, double half_height, double z_near);

  // A vertex in the light's frame with z >= z_near.
  void AddPoint(const glm::dvec3& point);
  // A triangle in the light's frame: the corners of its part with z >= z_near are added.
  void AddTriangle(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c);

  bool IsEmpty() const { return !(u_.low[0] <= u_.high[0]); }
  double z_near() const { return z_near_; }
  double z_far() const { return z_far_; }  // of the farthest point; z_near where there is none
  // Occluders reach beyond kMaxWindowSlope: side windows are needed, the front one ends at kSideWindowSlope.
  bool NeedsSideWindows() const;
  // Largest |slope| of the front window: kMaxWindowSlope or kSideWindowSlope.
  double FrontSlope() const { return NeedsSideWindows() ? kSideWindowSlope : kMaxWindowSlope; }
  // Occluders may stand in the side window toward `side`: 0 front, 1 +x, 2 -x, 3 +y, 4 -y.
  bool ReachesSide(int side) const;
  // The front window of the light's point (x, y), clipped at FrontSlope().
  Window FrontWindow(const glm::dvec2& sample) const;

 private:
  // Smallest and largest slope seen from the two ends of the light along one axis (index 0: -half, 1: +half).
  struct Axis {
    double half = 0;
    double low[2];
    double high[2];
    void Add(double position, double z);
    double Low(double sample) const;
    double High(double sample) const;
  };
  Axis u_, v_;
  double z_near_;
  double z_far_;
};

// Rows of the matrix that turns the light's frame into the frame of a side's map, whose third axis is the viewing
// direction: (x, y, z), (y, z, x), (y, z, -x), (x, z, y), (x, z, -y). Some are reflections: depth passes do not cull.
glm::dmat3 MapFromLight(int side);

}  // namespace halfshade
