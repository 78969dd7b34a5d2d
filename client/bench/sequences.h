// Frames in a row, as a user asks for them: a light dragged, a camera orbited, a data set of views. What each predicate
// of the plan leaves out then, and what that saves.
#pragma once

#include <absl/status/statusor.h>

#include <optional>
#include <string>
#include <vector>

#include "client/bench/bench.h"

namespace halfshade::bench {

struct SequencePlan {
  std::string name;
  SceneFiles files;
  std::vector<v1::RenderRequest> frames;
  std::vector<size_t> judged;  // frames whose error is measured
  uint32_t reference_rays = 512;
};

// A pass that was left out for one reason, whose figures are "N".
struct Skip {
  std::string pass, reason;
  double share = 0;                  // of the frames
  std::optional<double> saved_ms{};  // wall, a frame: what the pass took where it was drawn; unknown: it never was
};

struct SequenceResult {
  std::string name;
  std::string failure;  // the status where one failed; then nothing below holds
  double first_ms = 0, later_ms = 0, first_cpu_ms = 0,
         later_cpu_ms = 0;            // of a frame without encoding; medians of later
  double error = 0, predicted = 0;    // means over the judged
  std::optional<double> lit_tiles{};  // share of tiles that shaft proved lit
  std::vector<Skip> skips;
};
// The first frame uses nothing that was kept before.
SequenceResult MeasureSequence(Client& client, const SequencePlan& plan, Progress& progress);

// Of the frames' reports.
std::vector<Skip> CountSkips(const std::vector<v1::RenderReport>& reports);
// Mean share of tiles that are lit, by the notes of resolve passes.
std::optional<double> LitTiles(const std::vector<v1::RenderReport>& reports);

// Of one request.
struct ReplyTimes {
  std::string name;
  double plan_ms = 0;         // PlanRender at the client, the decision in it: median
  double repeated_ms = 0;     // totalMs of a request that was rendered before: median
  double first_image_ms = 0;  // of a progressive render where nothing is kept, totalMs of its first result
  double whole_ms = 0;        // and of its last
};
absl::StatusOr<ReplyTimes> MeasureReplies(Client& client, const Case& bench_case);

// Frames of a case: the light moved along its first edge, by a twentieth of it each time; the camera turned around its
// target by 6 degrees each time; cameras around the target at random. Require a look-at camera and a light.
SequencePlan DragLight(const Case& bench_case, int frames);
SequencePlan OrbitCamera(const Case& bench_case, int frames);
SequencePlan ScatterCameras(const Case& bench_case, int frames);

// As text, as the bench prints it.
std::string ToTable(const std::vector<SequenceResult>& sequences, const std::vector<ReplyTimes>& replies);

}  // namespace halfshade::bench
