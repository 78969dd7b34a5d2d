#include "server/scene_reader.h"

#include "renderer/scene_loader/decode_image.h"

namespace halfshade {
namespace {

class InProcess final : public SceneReader {
 public:
  absl::StatusOr<FlatScene> Load(const std::string& root, const FileMap& files,
                                 const SceneLoadLimits& limits) override {
    return LoadGltf(root, files, limits);
  }
  absl::StatusOr<Rgba8Image> Decode(const EncodedImage& image, uint64_t max_pixels) override {
    return DecodeImage(image, max_pixels);
  }
};

}  // namespace

std::unique_ptr<SceneReader> ReadInProcess() { return std::make_unique<InProcess>(); }

}  // namespace halfshade
