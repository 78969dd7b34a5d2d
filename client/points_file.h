// Points of `halfshade query`, from a CSV file.
#pragma once

#include <absl/status/statusor.h>

#include <string>

namespace halfshade {

// As QueryVisibilityRequest has them: float32, little-endian, 12 bytes a point.
struct PackedPoints {
  std::string points;
  std::string normals;  // empty: the file has none
};

// A line a point: x,y,z or x,y,z,nx,ny,nz, all lines alike; spaces, empty lines, lines that begin with # and a first
// line of names are skipped. NOT_FOUND for an absent file, INVALID_ARGUMENT naming the line.
absl::StatusOr<PackedPoints> ReadPointsFile(const std::string& path);

}  // namespace halfshade
