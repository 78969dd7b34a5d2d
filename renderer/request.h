// What Render(...) takes: plain values that server/validate has already checked. Units are in the names.
// World space is glTF's: metres, right-handed, y up. Row 0 of every image is on top.
#pragma once

#include <absl/status/status.h>

#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <optional>
#include <string>
#include <vector>

#include "renderer/method_options.h"

namespace halfshade {

// right, up, forward are orthonormal and right-handed: cross(right, up) = -forward.
// A pixel (x, y) of width x height looks along
//   forward + ((ndc_x + shift_ndc.x) aspect right + (ndc_y + shift_ndc.y) up) tan_half_fovy
// with ndc_x = 2 (x + .5) / width - 1, ndc_y = 1 - 2 (y + .5) / height, from eye_ws (perspective), or along forward
// from the matching point of the image plane (orthographic).
struct Camera {
  glm::dvec3 eye_ws{0, 0, 1};
  glm::dvec3 right_ws{1, 0, 0};
  glm::dvec3 up_ws{0, 1, 0};
  glm::dvec3 forward_ws{0, 0, -1};
  glm::dvec3 target_ws{0};  // what it looks at; centres the ground
  bool is_orthographic = false;
  double tan_half_fovy = 0.4;  // perspective
  double ortho_height_m = 1;   // orthographic: full height of the view
  double near_m = 0.01;        // > 0; orthographic: >= 0
  double far_m = 0;            // 0: infinite
  glm::dvec2 shift_ndc{0};     // perspective: of the picture's middle from the axis (math/camera.h: ShiftedCamera)
};

// A rectangle (or, with one zero edge, a line; with two, a point) that emits toward normal_ws.
// axis_u, axis_v, normal are orthonormal and right-handed, whatever the edges are.
struct AreaLight {
  glm::dvec3 center_ws{0};
  glm::dvec3 axis_u_ws{1, 0, 0};
  glm::dvec3 axis_v_ws{0, 1, 0};
  glm::dvec3 normal_ws{0, 0, 1};
  double width_m = 0;      // full edge along axis_u, >= 0
  double height_m = 0;     // full edge along axis_v, >= 0
  glm::vec3 radiance{0};   // W/(sr m^2), rectangles
  glm::vec3 intensity{0};  // W/sr along the normal, falling with the cosine: lines and points
  bool is_two_sided = false;
};

struct Ground {
  double height_m = 0;
  double size_m = 1;               // full edge
  bool is_shadow_catcher = false;  // FRAME shows its shadow alone, over nothing (renderer/shade/README.md)
};

// A medium that scatters light evenly in all directions. At height y its extinction is
// density_per_m exp(-(y - ground_m) / falloff_height_m); everywhere density_per_m where the falloff is 0.
struct Fog {
  double density_per_m = 0;     // >= 0
  glm::vec3 albedo{1};          // each in [0, 1]
  double falloff_height_m = 0;  // >= 0
  double ground_m = 0;
};

// A change to one node of the scene. What is false for a node is false for all below it, as visibility is in
// KHR_node_visibility: a node is drawn, casts and receives where it and all its ancestors do.
struct NodeOverride {
  uint32_t node = 0;                // into FlatScene::nodes
  std::optional<glm::dmat4> local;  // affine; in place of the node's own
  bool is_visible = true;           // drawn for the camera; says nothing of its shadow
  bool casts = true;                // hides light, drawn or not
  bool receives = true;             // gets shadows; where not, v = 1 and no horizon
};

enum class OutputKind : uint8_t {
  // [h][w][4] linear RGB (exposed, tone-mapped, before sRGB) over the background, and coverage; with a shadow catcher
  // over nothing: RGB is premultiplied by alpha.
  kFrame,
  kVisibility,  // [h][w][lights] v in [0,1], 1 = lit
  // Sampled at pixel centres, 0 in every channel where nothing is drawn:
  kDepth,     // [h][w][1] metres along the camera's axis
  kNormal,    // [h][w][3] unit, world axes, as shading uses it: turned with the side that the camera sees
  kAlbedo,    // [h][w][3] linear base colour
  kObjectId,  // [h][w][1] node index + 1; the ground: node count + 1. Whole numbers, exact to 2^24
  kPosition,  // [h][w][3] metres, world
  // [light_map_size][light_map_size][2] v and light_z of what the one light's centre sees of the receivers
  // (plan/light_grid.h); 1 and 0 where there are none.
  kSoftShadowMap,
  kPenumbraWidth,
};

// How colours that are brighter than a display become ones that it shows (shaders/shade/tone_map.glsl).
enum class ToneMap : uint8_t {
  kNone,     // as they are: encodings of whole numbers clamp, floats keep what is over 1
  kAces,     // Hill's fit of the ACES reference and output transforms (sRGB, 100 nits)
  kNeutral,  // Khronos PBR Neutral
};

struct Shading {
  glm::vec3 ambient{0.03f};  // radiance that reaches every point from everywhere
  double exposure_ev = 0;    // colours are multiplied by 2^exposure_ev
  ToneMap tone_map = ToneMap::kNone;
  glm::vec3 background{0.18f};  // linear
};

enum class CacheMode : uint8_t {
  kUse,
  kRefresh,  // light data of earlier requests is not looked at, and replaced
};

// Measure the error of visibility by rays (certify.h). Needs FRAME or VISIBILITY.
struct CertifyOptions {
  uint32_t pixels = 1024;  // of all lights together, 64..1'000'000
  int rays = 256;          // in each of two sets at each pixel, 16..65536
};

// What draws, as far as the choice of a method is concerned.
struct Machine {
  double slowness = 1;   // wall ms for each that the table predicts (plan/cost_model.h); of latencies alone
  bool has_gpu = false;  // GL is drawn by one, whatever context a request meets
};

// What the caller will bear.
struct Budget {
  std::optional<double> max_error{};       // mean |error| of visibility over shadowed receivers, in (0, 1)
  std::optional<double> max_latency_ms{};  // wall, from the start of drawing to the last byte encoded
  Machine machine{};                       // that it is to be kept on
};

struct RenderRequest {
  uint32_t scene_index = 0;
  std::vector<NodeOverride> node_overrides;  // each of another node
  std::optional<Ground> ground;
  std::optional<Fog> fog;  // of FRAME alone
  Camera camera;
  int width = 1280;
  int height = 720;
  int samples = 1;  // 1, 4 or 8 a pixel, for FRAME
  std::vector<AreaLight> lights;
  uint32_t expected_frames = 0;  // with these lights, this one included; 0: unknown
  MethodOptions method;
  bool is_auto = false;       // the method was chosen, not asked for (plan/choose_method.h)
  std::string method_reason;  // why this method, for the report
  std::optional<double> predicted_error, predicted_cpu_ms;  // by the choice
  // Checked against the error that the method tells, or the certificate's: FAILED_PRECONDITION where it is broken, and
  // where the method was chosen not before it was tried once more at half the error.
  Budget budget;
  std::vector<OutputKind> outputs;
  int light_map_size = 512;  // texels a side of kSoftShadowMap, and of the map that SSM projects, 16..8192
  Shading shading;
  std::optional<CertifyOptions> certify;
  uint32_t seed = 0;  // the points that sampled methods look from, the same for every light
  CacheMode cache = CacheMode::kUse;
};

// Width and height of an output.
inline glm::ivec2 SizeOf(const RenderRequest& request, OutputKind kind) {
  return kind == OutputKind::kSoftShadowMap ? glm::ivec2(request.light_map_size)
                                            : glm::ivec2(request.width, request.height);
}

// Pixels that are asked for visibility: each as often as it has samples.
inline uint64_t ReceiverCount(const RenderRequest& request) {
  return uint64_t(request.width) * uint64_t(request.height) * uint64_t(request.samples);
}

// Points to look from.
struct QueryPoints {
  std::vector<glm::vec3> points_ws;
  std::vector<glm::vec3> normals_ws;  // unit, one a point; or empty: no horizon
};

// Asked between GL submissions (each is predicted under 20 ms): a non-OK status stops the render, which returns it.
using StopCheck = std::function<absl::Status()>;

}  // namespace halfshade
