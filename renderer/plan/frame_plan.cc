#include "renderer/plan/frame_plan.h"

#include <algorithm>
#include <glm/gtc/matrix_transform.hpp>
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

// All corners are beyond one of: left, right, bottom, top, near, far.
bool IsBeyond(const glm::dmat4& clip_from_box, const Box3d& box) {
  std::array<bool, 6> all_beyond;
  all_beyond.fill(true);
  for (const glm::dvec3& corner : Corners(box)) {
    const glm::dvec4 p = clip_from_box * glm::dvec4(corner, 1);
    const bool beyond[6] = {p.x<-p.w, p.x> p.w, p.y<-p.w, p.y> p.w, p.z > p.w, p.z < 0};
    for (int i = 0; i < 6; ++i) all_beyond[i] = all_beyond[i] && beyond[i];
  }
  return std::find(all_beyond.begin(), all_beyond.end(), true) != all_beyond.end();
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
  // What a segment from the light to a receiver at depth r passes at depth z is a mean of both, (1 - t) light + t
  // receiver, t = z / r. An occluder at depths [a, b] meets segments with t from a / far_z to b / (the nearest
  // receiver's z), at most 1; their bounds are linear in t.
  const double near_z = std::max(0.0, all_receivers.min.z);
  return std::all_of(occluders.begin(), occluders.end(), [&](const Box3d& box) {
    const Box3d in_light = InLightFrame(frame, box);
    if (in_light.max.z <= 0 || in_light.min.z > far_z) return true;
    const double least = std::clamp(in_light.min.z / far_z, 0.0, 1.0);
    const double most = in_light.max.z < near_z ? in_light.max.z / near_z : 1;
    const auto is_outside = [&](int axis) {
      const double low = all_receivers.min[axis] + half[axis], high = all_receivers.max[axis] - half[axis];
      return in_light.max[axis] < -half[axis] + std::min(least * low, most * low) ||
             in_light.min[axis] > half[axis] + std::max(least * high, most * high);
    };
    return is_outside(0) || is_outside(1);
  });
}

bool SeesNone(const Camera& camera, double aspect, const std::vector<Box3d>& boxes) {
  const glm::dmat4 clip_from_camera = ClipFromView(camera, aspect) * glm::dmat4(ViewRotationFromWorld(camera));
  return std::all_of(boxes.begin(), boxes.end(), [&](const Box3d& box) {
    return IsBeyond(clip_from_camera, {box.min - camera.eye_ws, box.max - camera.eye_ws});
  });
}

std::vector<TriangleRun> SeenTriangles(const FlatScene& scene, const Instance& instance, const Camera& camera,
                                       double aspect) {
  const Mesh& mesh = scene.meshes[instance.mesh];
  const glm::dmat4 clip_from_mesh = ClipFromView(camera, aspect) * glm::dmat4(ViewRotationFromWorld(camera)) *
                                    glm::translate(glm::dmat4(1), -camera.eye_ws) * instance.world_from_mesh;
  std::vector<TriangleRun> runs;
  for (uint32_t i = mesh.first_cluster; i < mesh.first_cluster + mesh.cluster_count; ++i) {
    const Cluster& cluster = scene.clusters[i];
    if (IsBeyond(clip_from_mesh, {glm::dvec3(cluster.bounds.min), glm::dvec3(cluster.bounds.max)})) continue;
    if (!runs.empty() && runs.back().first + runs.back().count == cluster.first_triangle) {
      runs.back().count += cluster.triangle_count;
    } else {
      runs.push_back({cluster.first_triangle, cluster.triangle_count});
    }
  }
  return runs;
}

Box3d SeenGround(const RenderRequest& request, const Camera& camera) {
  const double aspect = double(request.width) / request.height;
  const glm::dmat4 clip_from_camera = ClipFromView(camera, aspect) * glm::dmat4(ViewRotationFromWorld(camera));
  struct Corner {
    glm::dvec3 at_ws;
    glm::dvec4 clip;
  };
  std::vector<Corner> polygon;
  for (const glm::dvec3& corner : GroundQuad(request)) {
    polygon.push_back({corner, clip_from_camera * glm::dvec4(corner - camera.eye_ws, 1)});
  }
  // Left, right, bottom, top: a pixel further out. What is nearer than the near plane counts as seen.
  const double side_x = 1 + 2.0 / request.width, side_y = 1 + 2.0 / request.height;
  const glm::dvec4 planes[] = {{1, 0, 0, side_x}, {-1, 0, 0, side_x}, {0, 1, 0, side_y}, {0, -1, 0, side_y}};
  for (const glm::dvec4& plane : planes) {
    std::vector<Corner> inside;
    for (size_t i = 0; i < polygon.size(); ++i) {
      const Corner &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
      const double from_a = glm::dot(plane, a.clip), from_b = glm::dot(plane, b.clip);
      if (from_a >= 0) inside.push_back(a);
      if ((from_a >= 0) == (from_b >= 0)) continue;
      const double share = from_a / (from_a - from_b);
      inside.push_back({glm::mix(a.at_ws, b.at_ws, share), glm::mix(a.clip, b.clip, share)});
    }
    polygon = std::move(inside);
  }
  Box3d box;
  for (const Corner& corner : polygon) box.Add(corner.at_ws);
  return box;
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
  bool sees_air = false;  // fog is lit and shadowed wherever the camera looks: boxes of receivers prove nothing
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
      } else if (occluders.empty()) {
        decide(LightOutcome::kNoMapNeeded, "nothing casts");
      } else if (view.sees_air) {
        // Its visibility is asked everywhere.
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
    visible.push_back(ground);
    if (!wants_light_map) ground = SeenGround(request, request.camera);
    if (!ground.IsEmpty()) receivers.push_back(ground);
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
  const bool sees_air = request.fog.has_value() && plan.needs_shading;
  // Nothing else of the scene has a pixel; a soft shadow map has texels of all.
  if (!wants_light_map) {
    std::erase_if(receivers, [&](const Box3d& box) { return no_view_sees({box}); });
  }
  plan.lights = PlanSides(request, occluders, receivers,
                          {plan.needs_visibility, wants_visibility || wants_light_map, sees_receiver, sees_air});
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

bool IsOneFlatOccluder(const FlatScene& scene, const Pose& pose) {
  const Instance* only = nullptr;
  for (const Instance& instance : pose.instances) {
    if (!instance.casts) continue;
    if (only != nullptr) return false;
    only = &instance;
  }
  if (only == nullptr) return false;
  const Box3f& bounds = scene.meshes[only->mesh].bounds;
  return bounds.min.x == bounds.max.x || bounds.min.y == bounds.max.y || bounds.min.z == bounds.max.z;
}

bool HasMaskedCaster(const FlatScene& scene, const Pose& pose) {
  return std::any_of(pose.instances.begin(), pose.instances.end(), [&](const Instance& instance) {
    return instance.casts && scene.CoverageOf(scene.meshes[instance.mesh]) == MaskCoverage::kTested;
  });
}

}  // namespace halfshade
