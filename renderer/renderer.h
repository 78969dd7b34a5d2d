// Render(...): a posed scene, lights, a camera and a method in; images and a report out.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "renderer/image/image.h"
#include "renderer/plan/light_grid.h"
#include "renderer/report.h"
#include "renderer/request.h"
#include "renderer/scene/flat_scene.h"

namespace halfshade {

namespace gl {
class Context;
}

// One decoded texture: [height][width][4] uint8, row 0 on top, sRGB colour and linear alpha as in the file.
struct Rgba8Image {
  int width = 0;
  int height = 0;
  std::vector<uint8_t> texels;
};

// Decodes a scene's image when a request needs it. Given from outside, since decoding strangers' bytes is fenced there.
using ImageDecoder = std::function<absl::StatusOr<Rgba8Image>(const EncodedImage&)>;

struct RenderedImage {
  OutputKind kind = OutputKind::kFrame;
  Image image;
  std::optional<LightGrid> grid{};  // of kSoftShadowMap: how it is projected
};

struct RenderResult {
  std::vector<RenderedImage> images;  // in the order of RenderRequest::outputs
  RenderReport report;
};

struct QueryResult {
  std::vector<float> visibility;  // [point][light], 1 = sees all of it
  RenderReport report;
};

// Where light data outlives its context, as bytes under a key. What comes back may be anything: it is checked.
class LightStore {
 public:
  virtual ~LightStore() = default;
  // Empty: nothing is there.
  virtual std::string Get(const std::string& scene_name, const std::string& key) = 0;
  virtual void Put(const std::string& scene_name, const std::string& key, std::string bytes) = 0;
};

// What may stay with a context between calls, in GL's memory or, of ray scenes, in the process's. What a call itself
// needs comes on top: its scene and one light's data where they are not kept (with several samples a pixel all lights',
// light_data_bytes together), and the textures of its frame.
struct ContextMemory {
  uint64_t scene_bytes = 1ull << 30;         // buffers and textures of scenes
  uint64_t light_data_bytes = 512ull << 20;  // maps and other products of lights
  uint64_t view_bytes = 256ull << 20;        // what cameras saw
  uint64_t ray_scene_bytes = 512ull << 20;   // triangles and hierarchies that rays are traced in
  uint64_t scene_data_bytes = 256ull << 20;  // what methods keep of scenes
  LightStore* light_store = nullptr;         // outlives the renderer; null: light data is built by every context
};

// The renderer of one GL context. Lives and is used on the context's thread, with the context current.
class Renderer {
 public:
  // Compiles and draws every program once (shaders compile at the first draw), so that the first request is not slow.
  // INTERNAL with a shader's path and log if one does not compile.
  static absl::StatusOr<std::unique_ptr<Renderer>> Create(gl::Context* context, ImageDecoder decoder,
                                                          const ContextMemory& memory = {});
  virtual ~Renderer() = default;

  // `scene_name` keys what stays on the context between calls; `scene` must be the same for the same name. Errors: what
  // `stop` returns (CANCELLED, DEADLINE_EXCEEDED); UNIMPLEMENTED naming what is missing; INVALID_ARGUMENT where only
  // the scene tells (scene_index); INTERNAL for a GL error or a NaN.
  virtual absl::StatusOr<RenderResult> Render(const std::string& scene_name, const FlatScene& scene,
                                              const RenderRequest& request, const StopCheck& stop) = 0;

  // Visibility of the request's lights from points. Of the request scene, overrides, lights, method and seed count.
  // Errors as Render.
  virtual absl::StatusOr<QueryResult> QueryVisibility(const std::string& scene_name, const FlatScene& scene,
                                                      const RenderRequest& request, const QueryPoints& points,
                                                      const StopCheck& stop);

  // Frees all that stayed of a scene. OK if there is nothing.
  virtual void ForgetScene(const std::string& scene_name) = 0;

  // Draws a small known picture, in some milliseconds. UNAVAILABLE where the context is lost; INTERNAL where it draws
  // something else than at the first time, or fails.
  virtual absl::Status CheckCanary() { return absl::OkStatus(); }

  // What stays on the context now, and how often it was found since the start.
  virtual std::vector<CacheReport> Caches() const { return {}; }
};

// What is known before drawing: method, options, reason, and the skips that the scene proves. Pure, on any thread.
// INVALID_ARGUMENT where only the scene tells (scene_index);
// UNIMPLEMENTED as Render.
absl::StatusOr<RenderReport> PlanRender(const FlatScene& scene, const RenderRequest& request);

// "hard", "multi_map": what RenderRequest::method may hold, by proto field name.
std::vector<std::string> RegisteredMethods();

}  // namespace halfshade
