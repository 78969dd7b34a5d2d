// What a request needs, what it does not, and why. Pure; no GL; every predicate is conservative: a skip is a proof.
#pragma once

#include <array>
#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "renderer/request.h"
#include "renderer/scene/flat_scene.h"
#include "renderer/scene/pose.h"

namespace halfshade {

enum class LightOutcome {
  kCompute,      // the method runs
  kNoMapNeeded,  // nothing can hide the light: visibility is the horizon's share
  kSkipped,      // nobody asks for this light
};

// One side of a light of the request. A two-sided light is two one-sided ones, back to back: a receiver stands in front
// of one of them at most, and the other's visibility is 0 there, so that the larger of both is the light's.
struct LightPlan {
  uint32_t index = 0;  // into RenderRequest::lights
  bool is_back = false;
  AreaLight light;  // of this side; never two-sided
  LightOutcome outcome = LightOutcome::kCompute;
  std::string reason;  // of anything but kCompute, naming the light
};

// One drawing of everything, with the pixels' samples moved from their centres.
struct ViewPlan {
  glm::dvec2 offset_pixels{0};    // x right, y down
  bool shows_frame = false;       // one of the samples of FRAME
  bool shows_data = false;        // all other outputs, which are sampled at the centres
  bool needs_materials = false;   // normals and base colours: for FRAME, NORMAL, ALBEDO
  bool needs_object_ids = false;  // for OBJECT_ID, and for a FRAME that must know the ground from the rest
};

struct FramePlan {
  bool draws_gbuffer = true;
  std::string gbuffer_reason;     // why not
  bool needs_shading = true;      // FRAME
  bool needs_visibility = true;   // FRAME, VISIBILITY or PENUMBRA_WIDTH: lights count
  bool needs_materials = true;    // of some view
  bool needs_textures = true;     // for materials, or because a MASK material says where its meshes are
  bool needs_object_ids = false;  // of some view
  double camera_far_m = 0;        // 0: infinite. An orthographic camera always has one, behind everything visible
  // One, or one for data (if any is asked) and then one per sample of FRAME; none for a soft shadow map alone.
  std::vector<ViewPlan> views;
  std::vector<LightPlan> lights;  // in the request's order, the front of a two-sided light before its back
};

FramePlan PlanFrame(const FlatScene& scene, const Pose& pose, const RenderRequest& request);

// The lights of a query of points in the box `points_ws`; of the request neither camera nor outputs are looked at.
std::vector<LightPlan> PlanQuery(const FlatScene& scene, const Pose& pose, const RenderRequest& request,
                                 const Box3d& points_ws);

// One surface hides the light: one casting mesh, flat along an axis of its own, whose nearest and furthest surfaces are
// the same from everywhere. A second layer of occluders (SsmOptions::passes) holds nothing more.
bool IsOneFlatOccluder(const FlatScene& scene, const Pose& pose);

// Some caster is there only where its mask lets it.
bool HasMaskedCaster(const FlatScene& scene, const Pose& pose);

// The predicates, each with the reason that the report gives. They take one side of a light.

// The light emits nothing: radiance zero (rectangle), intensity zero (line, point).
bool HasNoPower(const AreaLight& light);
// Every receiver's box stands at or behind the light's plane: nothing is lit, whatever occludes.
bool FacesAway(const AreaLight& light, const std::vector<Box3d>& receivers);
// No casting box reaches into the hull of the light and the box around the receivers' boxes in its frame, tested along
// the light's axes, at the depths that the box has: false when in doubt.
bool HasNoOccluder(const AreaLight& light, const std::vector<Box3d>& occluders, const std::vector<Box3d>& receivers);
// No box reaches into the camera's view.
bool SeesNone(const Camera& camera, double aspect, const std::vector<Box3d>& boxes);

// The part of the ground that the camera sees, a pixel more on each side; empty: none.
Box3d SeenGround(const RenderRequest& request, const Camera& camera);

// Triangles of one mesh at one place, within the mesh.
struct TriangleRun {
  uint32_t first = 0, count = 0;
};
// Those whose clusters' boxes reach into the camera's view: what is left out has no pixel. In their order, neighbours
// joined.
std::vector<TriangleRun> SeenTriangles(const FlatScene& scene, const Instance& instance, const Camera& camera,
                                       double aspect);

// World box of one mesh at one place: of its bounds' transformed corners, so it may be larger than the mesh.
Box3d WorldBox(const FlatScene& scene, const Instance& instance);

// Corners of the request's ground: a square centred under the camera's target, 1e-4 of its size lower than told so that
// flat bases don't fight with it. Counter-clockwise seen from above. Requires request.ground.
std::array<glm::dvec3, 4> GroundQuad(const RenderRequest& request);

}  // namespace halfshade
