// What a render is predicted to cost and to be off by, from facts of scene and request and a table that belongs to the
// build. Pure; no GL, no clocks.
//
// CPU milliseconds of all threads on two cores with llvmpipe (README.md: the commands that print what the table was
// fitted to). Only their ratios decide where no latency is asked for; wall time is theirs times how much slower this
// machine is (Machine::slowness).
#pragma once

#include <cstdint>

#include "renderer/request.h"
#include "renderer/scene/flat_scene.h"
#include "renderer/scene/pose.h"

namespace halfshade {

// What costs and errors are predicted from.
struct MethodFacts {
  uint64_t casting_triangles = 0;
  double masked_share = 0;      // of them: those with a mask to test
  double blend_share = 0;       // of them: those of the masked that are BLEND
  double clutter = 0;           // in [0,1]: how little they hang together, by the vertices that they share and by masks
  double kept_share = 0;        // of meshes that SHAFT keeps for all lights (light/kept_meshes.h)
  uint64_t kept_triangles = 0;  // theirs, once
  uint64_t receivers = 0;       // pixels of all views, or points
  uint64_t lights = 1;
  uint64_t frames = 1;  // with these lights
  bool wants_penumbra_width = false;
  bool can_certify = true;        // a picture shows the light: rays can measure its error
  bool has_gpu = false;           // Machine::has_gpu
  bool has_side_windows = false;  // some caster's box stands beside a light: each map is five (light/window.h)
};
MethodFacts FactsForMethod(const FlatScene& scene, const Pose& pose, const RenderRequest& request, uint64_t receivers);

// Primary visibility included, nothing cached.
struct PredictedCost {
  double scene_ms = 0;     // what stays for the next light: RAY's hierarchy, SHAFT's shapes
  double light_ms = 0;     // what stays for the next camera
  double receiver_ms = 0;  // what does not
  double TotalMs() const { return scene_ms + light_ms + receiver_ms; }
  // What methods are compared by: one of `frames` with the same lights. A scene is seldom drawn once.
  double FrameMs(uint64_t frames) const {
    return scene_ms / double(FramesOfScene(frames)) + light_ms / double(frames) + receiver_ms;
  }
  static uint64_t FramesOfScene(uint64_t frames) { return frames > 30 ? frames : 30; }
};
// Of options that are left open: as if the most were chosen, but shaft's rows and adaptive rays with a max_error, which
// are those for it.
PredictedCost PredictCost(const MethodFacts& facts, const MethodOptions& options);

// Wall time to the last byte encoded, of a render of cpu_ms, on a machine that is so much slower than the table's.
double PredictWallMs(const MethodFacts& facts, double cpu_ms, double slowness);

// Mean errors over shadowed receivers. `max_error` > 0.
double ShaftError(const MethodFacts& facts, int rows);
int ShaftRowsFor(const MethodFacts& facts, double max_error);  // 8 to 64, at most 16 where there is a mask
// How many polygons without masks the lists of all blocks of a frame may hold that is to take so long; 1 or more.
uint64_t ShaftPolygonsIn(const MethodFacts& facts, int rows, double ms);
double RayError(const MethodFacts& facts, int rays);
int RaysFor(const MethodFacts& facts, double max_error);  // kFewestRays to kMostRays, a power of two
inline constexpr int kFewestRays = 16, kMostRays = 65536;
double FilteredRayError(int rays);  // on smooth surfaces
double PdsmError(const MethodFacts& facts, int k);
double SsmError(const MethodFacts& facts, int sub_lights);
double PcssError(const MethodFacts& facts);
double SssmError(const MethodFacts& facts);
// What a picture is off by, of what its method's samples say (picture_error.h).
double ErrorOfTold(const MethodOptions& options);

// Of a certificate of `pixels` by two sets of `rays`; the hierarchy that they are traced in is the scene's.
PredictedCost CertificateCost(const MethodFacts& facts, const CertifyOptions& certificate);

}  // namespace halfshade
