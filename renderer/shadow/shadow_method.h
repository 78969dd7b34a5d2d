// The door that every shadow method opens by.
//
// A method turns occluders and one light into LightData (camera-free, cacheable) and LightData and receivers into
// visibility. A new method is a new folder and a line in registry.cc. Used on the context's thread.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "renderer/gl/draw_context.h"
#include "renderer/light/light_data.h"
#include "renderer/light/occluders_on_context.h"
#include "renderer/light/receivers.h"
#include "renderer/report.h"
#include "renderer/request.h"
#include "renderer/scene/flat_scene.h"
#include "renderer/scene/pose.h"
#include "renderer/scene/ray_mask.h"
#include "renderer/scene/ray_scene.h"

namespace halfshade {

// What a method's needs depend on.
struct SceneFacts {
  uint64_t occluder_triangles = 0;
  bool is_software_gl = false;  // GL runs on the CPU: what a method does better there itself, it does
};

// What a method takes. Pure: known before anything is drawn.
struct MethodNeeds {
  uint32_t maps = 0;              // depth maps drawn, side windows not counted; 0: no LightInputs::occluders
  int map_size = 0;               // texels a side
  uint64_t light_data_bytes = 0;  // if everything is kept
  bool ray_scene = false;         // LightInputs::ray_scene
  bool cpu_receivers = false;     // Receivers::on_cpu instead of its textures
  bool scene_data = false;        // LightInputs::scene_data, and the scene and pose
  bool receiver_map = false;      // LightInputs::receiver_map: light data depends on what receives
};

// What a method keeps of a scene whatever its pose, its lights and its cameras. Immutable once built.
class SceneData {
 public:
  virtual ~SceneData() = default;
  virtual uint64_t SizeBytes() const = 0;
};

struct LightInputs {
  std::shared_ptr<const OccludersOnContext> occluders;  // null unless needed
  std::shared_ptr<const RayScene> ray_scene;            // null unless needed
  std::shared_ptr<const SceneData> scene_data;          // null unless needed
  const FlatScene* scene = nullptr;                     // null unless scene_data is needed; the three live no longer
  const Pose* pose = nullptr;                           // than the call
  const ImageDecoder* decoder = nullptr;
  const ReceiverMap* receiver_map = nullptr;  // null unless needed; lives no longer than the call
  AreaLight light;                            // one-sided
  uint32_t seed = 0;
  // What does not fit is left out and drawn again at every resolve: the same occlusion, only later.
  uint64_t max_light_data_bytes = 0;
  // The same of all lights together. A method that can leave nothing out may refuse more: RESOURCE_EXHAUSTED.
  uint64_t light_cache_bytes = 0;
};

// What a method returns before the door: occlusion as a sum, of the part of the light above the receiver's plane.
// Hidden fraction of that part = sum / full_sum. One per receiver, where the method works: an R32F texture, or in
// memory, [height][width]; or an RG32F texture with the receiver's own full sum beside it (0: all of it is hidden).
struct OcclusionSum {
  std::variant<gl::Texture, std::vector<float>> sums;
  float full_sum = 1;     // 0: it stands beside each sum
  uint64_t count = 0;     // what the report says of its pass: rays traced, tiles resolved
  std::string note = {};  // and this
  // Expected |error| of the hidden fraction, one per receiver; empty: the method has no estimate.
  std::vector<float> errors = {};
  // Neighbouring pixels have samples of their own: their errors are independent (picture_error.h).
  bool has_independent_errors = false;
  // Where Receivers::wants_blockers: RG32F, sum of w of what hides part of the light less the receiver's w, and the sum
  // of its weights; 0 0: nothing does. Of it PENUMBRA_WIDTH is made.
  gl::Texture blockers{};
  // Options that the request left open and that were chosen by what the receivers see, for the report.
  std::vector<std::pair<std::string, std::string>> chosen_options = {};
  // What the resolve was made of, where a method has passes worth telling apart; names are the method's own.
  std::vector<PassReport> steps{};
  // The largest hidden fraction before it was clamped, where light data did that; sums tell the others.
  double largest_fraction = 0;
};

class ShadowMethod {
 public:
  virtual ~ShadowMethod() = default;
  virtual MethodNeeds Needs(const MethodOptions& options, const SceneFacts& facts) const = 0;
  // For methods that need it. The pacer's error comes back.
  virtual absl::StatusOr<std::unique_ptr<SceneData>> BuildSceneData(const DrawContext&, const FlatScene&) const {
    return absl::InternalError("the method keeps nothing of a scene");
  }
  virtual absl::StatusOr<std::unique_ptr<LightData>> BuildLightData(const DrawContext& draw, const LightInputs& inputs,
                                                                    const MethodOptions& options) const = 0;
  // The options that light data depends on, for its key. Unless overridden, all.
  virtual std::string LightDataOptions(const MethodOptions& options) const {
    std::string text;
    for (const auto& [name, value] : DescribeOptions(options)) text.append(name).append("=").append(value).append(" ");
    return text;
  }
  virtual absl::StatusOr<OcclusionSum> ResolveOcclusion(const DrawContext& draw, const LightData& data,
                                                        const Receivers& receivers,
                                                        const MethodOptions& options) const = 0;
  // Light data as bytes, for a store that outlives the context; empty: this method's is as soon built again.
  virtual absl::StatusOr<std::string> SaveLightData(const DrawContext&, const LightData&) const {
    return std::string();
  }
  // Light data of bytes that were saved for the same inputs and options, by whomever. Null: they are not what this
  // build saves (torn, foreign, another version), and light data is to be built.
  virtual absl::StatusOr<std::unique_ptr<LightData>> LoadLightData(const DrawContext&, const LightInputs&,
                                                                   const MethodOptions&, const std::string&) const {
    return std::unique_ptr<LightData>();
  }
  // Whether light data is dear, and is kept without the nodes that a request moves: they hide light on their own.
  virtual bool KeepsMovedApart() const { return false; }
  // Whether it gives OcclusionSum::blockers.
  virtual bool KnowsBlockers() const { return false; }
  // Every option by its proto field name, for the report.
  virtual std::vector<std::pair<std::string, std::string>> DescribeOptions(const MethodOptions& options) const = 0;
};

struct RegisteredMethod {
  std::string name;  // proto field name
  const ShadowMethod* method = nullptr;
};

// All methods, in the order of MethodOptions' alternatives.
const std::vector<RegisteredMethod>& MethodRegistry();

// The method of these options.
const RegisteredMethod& FindMethod(const MethodOptions& options);

}  // namespace halfshade
