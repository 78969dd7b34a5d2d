#include "renderer/plan/frame_plan.h"

#include <algorithm>
#include <limits>

#include "renderer/math/camera.h"
#include "renderer/math/light_frame.h"

namespace halfshade {
namespace {

std::array<glm::dvec3, 8> Corners(const Box3d& box) {
  std::array<glm::dvec3, 8> corners;
  for (int i = 0; i < 8; ++i) {
    corners[i] = {i & 1 ? box.max.x : box.min.x, i & 2 ? box.max.y : box.min.y, i & 4 ? box.max.z : box.min.z};
  }
  return corners;
}

bool Wants(const RenderRequest& request, OutputKind kind) {
  return std::find(request.outputs.begin(), request.outputs.end(), kind) != request.outputs.end();
}

// Positions of samples in their pixel, in sixteenths from its centre: Direct3D's standard patterns, as every GPU has
// them. No two samples share a row or a column, so that an upright edge crosses them one by one.
std::vector<glm::dvec2> SamplePattern(int samples) {
  switch (samples) {
    case 4:
      return {{-2, -6}, {6, -2}, {-6, 2}, {2, 6}};
    case 8:
      return {{1, -3}, {-1, 3}, {5, 1}, {-3, -5}, {-5, 5}, {-7, -1}, {3, 7}, {7, -7}};
    default:
      return {{0, 0}};
  }
}

std::vector<ViewPlan> PlanViews(const RenderRequest& request) {
  const bool shows_frame = Wants(request, OutputKind::kFrame);
  const bool shows_data = std::any_of(request.outputs.begin(), request.outputs.end(), [](OutputKind kind) {
    return kind != OutputKind::kFrame && kind != OutputKind::kSoftShadowMap;
  });
  std::vector<ViewPlan> views;
  if (!shows_frame && !shows_data) return views;  // a soft shadow map alone needs no camera
  if (!shows_frame || request.samples == 1) {
    views.push_back({{0, 0}, shows_frame, shows_data});
  } else {
    if (shows_data) views.push_back({{0, 0}, false, true});
    for (const glm::dvec2& sixteenths : SamplePattern(request.samples)) views.push_back({sixteenths / 16.0, true});
  }
  const bool has_catcher = request.ground && request.ground->is_shadow_catcher;
  const bool shows_materials = Wants(request, OutputKind::kNormal) || Wants(request, OutputKind::kAlbedo);
  const bool shows_object_ids = Wants(request, OutputKind::kObjectId);
  for (ViewPlan& view : views) {
    view.needs_materials = view.shows_frame || (view.shows_data && shows_materials);
    view.needs_object_ids = (view.shows_frame && has_catcher) || (view.shows_data && shows_object_ids);
  }
  return views;
}

// Orthographic depth is linear: its end is put close behind what is visible, so that floats resolve it.
double FarPlane(const Camera& camera, const std::vector<Box3d>& visible) {
  if (!camera.is_orthographic || camera.far_m > camera.near_m) return camera.far_m;
  double farthest = 0, extent = 0;
  for (const Box3d& box : visible) {
    for (const glm::dvec3& corner : Corners(box)) {
      farthest = std::max(farthest, glm::dot(corner - camera.eye_ws, camera.forward_ws));
      extent = std::max(extent, glm::length(corner - camera.eye_ws));
    }
  }
  return farthest > camera.near_m ? farthest + 1e-6 * extent : 0;
}

Box3d InLightFrame(const LightFrame& frame, const Box3d& box) {
  Box3d result;
  for (const glm::dvec3& corner : Corners(box)) result.Add(PointToLight(frame, corner));
  return result;
}

}  // namespace

Box3d WorldBox(const FlatScene& scene, const Instance& instance) {
  const Box3f& bounds = scene.meshes[instance.mesh].bounds;
  Box3d box;
  if (bounds.IsEmpty()) return box;
  for (const glm::dvec3& corner : Corners({glm::dvec3(bounds.min), glm::dvec3(bounds.max)})) {
    box.Add(glm::dvec3(instance.world_from_mesh * glm::dvec4(corner, 1)));
  }
  return box;
}

bool HasNoPower(const AreaLight& light) {
  const bool is_rectangle = light.width_m > 0 && light.height_m > 0;
  return (is_rectangle ? light.radiance : light.intensity) == glm::vec3(0);
}

bool FacesAway(const AreaLight& light, const std::vector<Box3d>& receivers) {
  const LightFrame frame = MakeLightFrame(light);
  return std::all_of(receivers.begin(), receivers.end(),
                     [&](const Box3d& box) { return InLightFrame(frame, box).max.z <= 0; });
}

bool HasNoOccluder(const AreaLight& light, const std::vector<Box3d>& occluders, const std::vector<Box3d>& receivers) {
  const LightFrame frame = MakeLightFrame(light);
  const glm::dvec2 half(light.width_m / 2, light.height_m / 2);
  Box3d all_receivers;
  for (const Box3d& box : receivers) {
    const Box3d in_light = InLightFrame(frame, box);
    all_receivers.Add(in_light.min);
    all_receivers.Add(in_light.max);
  }
  const double far_z = all_receivers.max.z;
  if (all_receivers.IsEmpty() || far_z <= 0) return true;
  // At depth z the hull lies inside the light's rectangle grown linearly, by z / (the nearest receiver's z), to the
  // receivers' rectangle; with receivers at every depth from 0 the union of the two bounds it.
  const auto is_outside = [&](double low, double high, double half_edge, double receivers_low, double receivers_high) {
    return high < std::min(-half_edge, receivers_low) || low > std::max(half_edge, receivers_high);
  };
  return std::all_of(occluders.begin(), occluders.end(), [&](const Box3d& box) {
    const Box3d in_light = InLightFrame(frame, box);
    return in_light.max.z <= 0 || in_light.min.z > far_z ||
           is_outside(in_light.min.x, in_light.max.x, half.x, all_receivers.min.x, all_receivers.max.x) ||
           is_outside(in_light.min.y, in_light.max.y, half.y, all_receivers.min.y, all_receivers.max.y);
  });
}

bool SeesNone(const Camera& camera, double aspect, const std::vector<Box3d>& boxes) {
  const glm::dmat4 clip_from_camera = ClipFromView(camera, aspect) * glm::dmat4(ViewRotationFromWorld(camera));
  return std::all_of(boxes.begin(), boxes.end(), [&](const Box3d& box) {
    // Outside if all corners are beyond one of: left, right, bottom, top, near, far.
    std::array<bool, 6> all_beyond;
    all_beyond.fill(true);
    for (const glm::dvec3& corner : Corners(box)) {
      const glm::dvec4 p = clip_from_camera * glm::dvec4(corner - camera.eye_ws, 1);
      const bool beyond[6] = {p.x<-p.w, p.x> p.w, p.y<-p.w, p.y> p.w, p.z > p.w, p.z < 0};
      for (int i = 0; i < 6; ++i) all_beyond[i] = all_beyond[i] && beyond[i];
    }
    return std::find(all_beyond.begin(), all_beyond.end(), true) != all_beyond.end();
  });
}

std::array<glm::dvec3, 4> GroundQuad(const RenderRequest& request) {
  const double half = request.ground->size_m / 2;
  const double y = request.ground->height_m - 1e-4 * request.ground->size_m;
  const glm::dvec3& c = request.camera.target_ws;
  return {glm::dvec3(c.x - half, y, c.z + half), glm::dvec3(c.x + half, y, c.z + half),
          glm::dvec3(c.x + half, y, c.z - half), glm::dvec3(c.x - half, y, c.z - half)};
}

namespace {

// What the outputs and the camera say of all lights.
struct LightView {
  bool needs_light = true;
  bool wants_visibility = true;
  bool sees_receiver = true;
};

std::vector<LightPlan> PlanSides(const RenderRequest& request, const std::vector<Box3d>& occluders,
                                 const std::vector<Box3d>& receivers, const LightView& view) {
  std::vector<LightPlan> lights;
  for (uint32_t i = 0; i < request.lights.size(); ++i) {
    const AreaLight& light = request.lights[i];
    for (const bool is_back : {false, true}) {
      if (is_back && !light.is_two_sided) continue;
      LightPlan side;
      side.index = i;
      side.is_back = is_back;
      side.light = is_back ? OtherSide(light) : light;
      side.light.is_two_sided = false;
      const std::string name = "lights[" + std::to_string(i) + (is_back ? "], back: " : "]: ");
      const auto decide = [&](LightOutcome outcome, const char* reason) {
        side.outcome = outcome;
        side.reason = name + reason;
      };
      if (!view.needs_light) {
        decide(LightOutcome::kSkipped, "no output shows light");
      } else if (HasNoPower(light) && !view.wants_visibility) {
        decide(LightOutcome::kSkipped, "emits nothing, and visibility is not asked");
      } else if (!view.sees_receiver) {
        decide(is_back ? LightOutcome::kSkipped : LightOutcome::kNoMapNeeded, "no receiver is in view");
      } else if (FacesAway(side.light, receivers)) {
        // Where the other side lights something, this one has nothing to add. The front stays if neither does.
        const bool is_spare = light.is_two_sided && (is_back || !FacesAway(OtherSide(side.light), receivers));
        decide(is_spare ? LightOutcome::kSkipped : LightOutcome::kNoMapNeeded, "faces away from every receiver");
      } else if (HasNoOccluder(side.light, occluders, receivers)) {
        decide(LightOutcome::kNoMapNeeded, "no occluder between it and the receivers");
      }
      lights.push_back(side);
    }
  }
  return lights;
}

}  // namespace

FramePlan PlanFrame(const FlatScene& scene, const Pose& pose, const RenderRequest& request) {
  FramePlan plan;
  const bool wants_visibility = Wants(request, OutputKind::kVisibility) || Wants(request, OutputKind::kPenumbraWidth);
  plan.needs_shading = Wants(request, OutputKind::kFrame);
  const bool wants_light_map = Wants(request, OutputKind::kSoftShadowMap);
  plan.needs_visibility = plan.needs_shading || wants_visibility || wants_light_map;
  plan.views = PlanViews(request);
  const auto some_view = [&](bool ViewPlan::*needs) {
    return std::any_of(plan.views.begin(), plan.views.end(), [&](const ViewPlan& view) { return view.*needs; });
  };
  plan.needs_materials = some_view(&ViewPlan::needs_materials);
  plan.needs_object_ids = some_view(&ViewPlan::needs_object_ids);
  plan.needs_textures =
      plan.needs_materials || std::any_of(pose.instances.begin(), pose.instances.end(), [&](const Instance& instance) {
        return (instance.casts || instance.is_visible) &&
               scene.CoverageOf(scene.meshes[instance.mesh]) == MaskCoverage::kTested;
      });

  std::vector<Box3d> occluders, receivers, visible;
  for (const Instance& instance : pose.instances) {
    const Box3d box = WorldBox(scene, instance);
    if (box.IsEmpty()) continue;
    if (instance.casts) occluders.push_back(box);
    if (instance.is_visible) visible.push_back(box);
    if (instance.is_visible && instance.receives) receivers.push_back(box);
  }
  if (request.ground) {
    Box3d ground;
    for (const glm::dvec3& corner : GroundQuad(request)) ground.Add(corner);
    receivers.push_back(ground);
    visible.push_back(ground);
  }

  Camera camera = request.camera;
  camera.far_m = plan.camera_far_m = FarPlane(request.camera, visible);
  const double aspect = double(request.width) / request.height;
  const auto no_view_sees = [&](const std::vector<Box3d>& boxes) {
    return std::all_of(plan.views.begin(), plan.views.end(), [&](const ViewPlan& view) {
      return SeesNone(ShiftedCamera(camera, view.offset_pixels, request.width, request.height), aspect, boxes);
    });
  };
  if (no_view_sees(visible)) {
    plan.draws_gbuffer = false;
    plan.gbuffer_reason = "nothing is in view";
  }
  const bool sees_receiver = wants_light_map || !no_view_sees(receivers);
  plan.lights = PlanSides(request, occluders, receivers,
                          {plan.needs_visibility, wants_visibility || wants_light_map, sees_receiver});
  return plan;
}

std::vector<LightPlan> PlanQuery(const FlatScene& scene, const Pose& pose, const RenderRequest& request,
                                 const Box3d& points_ws) {
  std::vector<Box3d> occluders;
  for (const Instance& instance : pose.instances) {
    const Box3d box = WorldBox(scene, instance);
    if (instance.casts && !box.IsEmpty()) occluders.push_back(box);
  }
  return PlanSides(request, occluders, {points_ws}, LightView());
}

bool HasMaskedCaster(const FlatScene& scene, const Pose& pose) {
  return std::any_of(pose.instances.begin(), pose.instances.end(), [&](const Instance& instance) {
    return instance.casts && scene.CoverageOf(scene.meshes[instance.mesh]) == MaskCoverage::kTested;
  });
}

}  // namespace halfshade
