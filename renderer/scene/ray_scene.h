// The casting triangles of one pose in a bounding volume hierarchy (Embree 3), for segments between receivers and
// lights.
//
// Trace space: world axes, origin at the middle of the casters' box, scaled by the power of two that brings its longest
// half edge into [1/2, 1): floats are as fine as they can be wherever the scene stands, and scaling the world by a
// power of two changes no bit. Immutable once made; may be used by any number of threads at once.
#pragma once

#include <absl/status/statusor.h>

#include <atomic>
#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <vector>

#include "renderer/renderer.h"
#include "renderer/scene/flat_scene.h"
#include "renderer/scene/pose.h"
#include "renderer/scene/ray_boxes.h"
#include "renderer/scene/ray_mask.h"

struct RTCDeviceTy;
struct RTCSceneTy;

namespace halfshade {

class RayScene {
 public:
  // Both sides of every triangle occlude, those of a MASK or BLEND material where RayMask lets them: its image is
  // decoded here, and the decoder's errors come back. RESOURCE_EXHAUSTED when Embree has no memory. `stop` is asked by
  // any thread while the hierarchy is built; its error comes back.
  static absl::StatusOr<std::unique_ptr<RayScene>> Create(
      const FlatScene& scene, const Pose& pose, const ImageDecoder& decoder,
      const StopCheck& stop = [] { return absl::OkStatus(); });
  ~RayScene();
  RayScene(const RayScene&) = delete;
  RayScene& operator=(const RayScene&) = delete;

  glm::dvec3 TraceFromWorld(const glm::dvec3& point_ws) const { return (point_ws - origin_ws_) * scale_; }
  double trace_scale() const { return scale_; }  // trace lengths per metre

  // Of ray_fan.h; null where nothing casts.
  RTCSceneTy* embree_scene() const { return scene_; }
  const RayBoxes& boxes() const { return boxes_; }
  uint64_t SizeBytes() const;  // the hierarchy's memory included

  struct Triangles {
    std::vector<glm::vec4> vertices;  // trace space; w is padding
    std::vector<uint32_t> indices;
    // Masked triangles stand last: of triangle first_masked + i the mask, and of its corners texture coordinate and
    // alpha.
    uint32_t first_masked = 0;
    std::vector<uint32_t> mask_of_triangle;
    std::vector<glm::vec3> mask_corners;
    std::vector<glm::vec3> blend_corners;  // BlendSpace::Place of theirs; empty where nothing is BLEND
    std::vector<RayMask> masks;
    // Whether the mask leaves nothing at the point (u, v) of the triangle (weights of its second and third corner).
    bool IsMaskedAway(uint32_t triangle, float u, float v) const;
  };
  const Triangles& triangles() const { return triangles_; }

 private:
  RayScene() = default;
  absl::Status AddCasters(const FlatScene& scene, const Pose& pose, const ImageDecoder& decoder);
  absl::Status Build(const StopCheck& stop);

  glm::dvec3 origin_ws_{0};
  double scale_ = 1;
  Triangles triangles_;
  RayBoxes boxes_;
  RTCDeviceTy* device_ = nullptr;
  RTCSceneTy* scene_ = nullptr;
  std::atomic<int64_t> embree_bytes_{0};
};

}  // namespace halfshade
