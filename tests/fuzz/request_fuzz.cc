// A RenderRequest or a QueryVisibilityRequest off the wire.
#include <cstdint>

#include "server/validate.h"
#include "tests/fuzz/flat_scene_use.h"
#include "tests/renderer/scene/every_array_scene.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace halfshade;
  static const FlatScene& scene = *new FlatScene(MakeEveryArrayScene());
  v1::RenderRequest render;
  if (render.ParseFromArray(data, int(size)) && CheckRenderFields(render, {}).ok()) {
    const auto validated = ValidateRender(render, scene, {});
    if (validated.ok()) {
      Require(validated->request.width > 0 && validated->request.height > 0 && !validated->request.lights.empty());
      Require(ContentKey("scenes/x", *validated, "1", "gl").size() == 64);
    }
  }
  v1::QueryVisibilityRequest query;
  if (query.ParseFromArray(data, int(size)) && CheckQueryFields(query, {}).ok()) {
    (void)ValidateQuery(query, scene, {}).ok();
  }
  return 0;
}
