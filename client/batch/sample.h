// Lines of a batch out of a template: a line in whose place of any value may stand a draw. Pure.
//
// A draw is an object with one key of these (and, for $light, what else the light shall have):
//   {"$uniform": [a, b]}   a number         {"$log": [a, b]}   its logarithm uniform, a > 0
//   {"$integer": [a, b]}   a whole number, a and b among them  {"$choice": [...]}   one of them, draws in it drawn
//   {"$hemisphere": {"target": [x, y, z], "radius": [a, b], "elevation_deg": [a, b], "azimuth_deg": [a, b]}}
//                          a point {x, y, z} around the target, uniform over the part of the sphere; elevations from
//                          the horizon up (default 0 to 90), azimuths from +z to +x (default 0 to 360), radii metres
//   {"$light": {... as $hemisphere, "width_m": [a, b], "height_m": [a, b]}}
//                          center, edgeU (level) and edgeV of a rectangle there that emits toward the target
// A range [a, b] needs a <= b. A draw depends on the seed, the line's number and its place in the template alone: a
// field more, or more lines, changes no other; the numbers have nine digits, so that they are the same on any machine.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <memory>
#include <string>

namespace halfshade {

class LineSampler {
 public:
  // `text`: the template; its `id` is the beginning of every line's id. `folder`: what its scenes' paths are relative
  // to. INVALID_ARGUMENT with the JSON pointer of what is no draw.
  static absl::StatusOr<LineSampler> Create(const std::string& text, const std::string& folder);
  LineSampler(LineSampler&&) noexcept;
  ~LineSampler();

  // The index-th line, "<id>-<index>", with its scene's path absolute. INVALID_ARGUMENT as Create, and for what would
  // be no line of a batch.
  absl::StatusOr<std::string> Line(uint64_t seed, uint64_t index) const;

 private:
  struct Template;
  explicit LineSampler(std::unique_ptr<Template> parsed);
  std::unique_ptr<Template> template_;
};

}  // namespace halfshade
