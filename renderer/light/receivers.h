// Where visibility is wanted, and the textures it comes back in.
#pragma once

#include <vector>

#include "renderer/gl/program.h"
#include "renderer/gl/texture.h"
#include "renderer/light/cpu_receivers.h"
#include "renderer/request.h"

namespace halfshade {

// The points seen through the pixels of a camera, as planes: shaders/common/receiver.glsl rebuilds position, normal and
// tangent plane of each in the frame of any light, to float precision of the distances to camera and light. Or points
// that a caller names, with planes and positions. A method says which of both forms it reads (MethodNeeds).
struct Receivers {
  // [height][width] RGBA32F: geometric normal (world axes, turned to the camera), offset from the eye along it, both
  // times kNotReceivingScale where what is drawn does not receive; a zero normal where nothing is drawn. Outlives this
  // struct.
  const gl::Texture* planes = nullptr;
  Camera camera;
  int width = 0;
  int height = 0;
  const gl::Texture* points = nullptr;   // RGBA32F, CpuReceivers::points; null for pixels
  const CpuReceivers* on_cpu = nullptr;  // the same in memory
  bool wants_blockers = false;           // OcclusionSum::blockers, of methods that know them
};

// What a light's centre sees of the receivers (renderer/plan/light_grid.h says of which).
struct ReceiverMap {
  Receivers receivers;         // size x size pixels of the light's view, row 0 at v0
  glm::dvec4 window{0};        // u0, v0, u1, v1; square
  std::vector<float> light_z;  // [size][size] metres, 0: nothing there
  bool casts = false;          // what is seen occludes too
};

// The textures of receivers that come from memory.
struct ReceiverTextures {
  gl::Texture planes, points;
};
absl::StatusOr<ReceiverTextures> UploadReceivers(const gl::Context& context, const CpuReceivers& receivers);
// The form in memory of receivers that are pixels. Waits for the drawing.
absl::StatusOr<CpuReceivers> ReadBackReceivers(const Receivers& pixels);
// n.x = d and 2 n.x = 2 d are the same plane, exactly: the length of the normal is free to say that a surface does not
// receive.
inline constexpr float kNotReceivingScale = 2;

// Texture unit of Receivers::planes in every program that includes common/receiver.glsl; others start above it.
inline constexpr int kPlanesUnit = 0;
inline constexpr int kPointsUnit = 15;  // the last that every GL has

// Binds the planes and sets the uniforms of common/receiver.glsl for the frame of `light`.
void SetReceivers(gl::Program& program, const Receivers& receivers, const AreaLight& light);

}  // namespace halfshade
