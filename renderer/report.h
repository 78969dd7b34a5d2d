// What a render did, what it skipped and why. Plain values; server turns them into the wire's RenderReport.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace halfshade {

// Visibility nearer to 0 or 1 than this is umbra or light.
inline constexpr float kPenumbraMargin = 1.0f / 512;

// The value of an option that light data or the resolve will choose.
inline constexpr char kChosen[] = "auto";

struct PassReport {
  std::string name{};  // "light[0]/multi_map", "gbuffer", "shade", ...
  double ms = 0;       // wall, GL work included
  bool is_skipped = false;
  std::string reason{};  // of a skip: "light[0]: radiance is zero"; or of work that is left for later
  uint64_t count = 0;    // what the pass counts: maps drawn, pixels, triangles
};

struct CacheReport {
  std::string name{};  // "scene", "scene_on_context", "light_data", "programs"
  uint64_t hits = 0;
  uint64_t misses = 0;
  uint64_t bytes = 0;
};

// Mean absolute error of visibility over shadowed pixels. Absent: not known.
struct ErrorReport {
  std::optional<double> predicted{};  // from the method's error model
  std::optional<double> measured{};   // by certify
  std::optional<double> ci95{};       // half width of the 95 % interval around measured
  std::optional<double> noise{};      // of the rays that measured
  std::optional<double> bound{};      // where one is known
};

struct RenderReport {
  std::string method;                                        // "multi_map"
  std::vector<std::pair<std::string, std::string>> options;  // resolved, by proto field name
  std::string reason;
  // Over the pixels where something is drawn and that face part of at least one light; sums to 1 unless there are none.
  double share_umbra = 0;
  double share_penumbra = 0;
  double share_lit = 0;
  ErrorReport error;
  double max_sum = 0;    // largest visibility or occlusion sum before clamping
  double upload_ms = 0;  // scene to GL
  double light_ms = 0;
  double resolve_ms = 0;
  double shade_ms = 0;
  double readback_ms = 0;
  std::vector<PassReport> passes;
  std::vector<CacheReport> caches;
};

}  // namespace halfshade
