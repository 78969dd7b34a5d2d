// What a camera sees, kept on the context: the next call with the same scene, pose, camera and size draws it no more,
// whatever its lights and method.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "renderer/light/cpu_receivers.h"
#include "renderer/request.h"
#include "renderer/shade/gbuffer.h"

namespace halfshade {

struct SeenView {
  GBuffer gbuffer;
  std::optional<CpuReceivers> on_cpu;  // once a method asks for them
  uint64_t SizeBytes() const;
};

// Everything that DrawGBuffer depends on, request.camera being the view's; begins with LightDataPrefix(scene_name).
std::string SeenViewKey(const std::string& scene_name, const RenderRequest& request, GBufferChannels channels);

}  // namespace halfshade
