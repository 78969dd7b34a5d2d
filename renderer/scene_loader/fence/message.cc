#include "renderer/scene_loader/fence/message.h"

#include <algorithm>
#include <cstring>

#include "renderer/scene_loader/decode_image.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

constexpr size_t kMaxWords = 64 << 10;  // of a status

template <typename T>
bool Put(const T& value, const ByteSink& sink) {
  return sink(&value, sizeof(value));
}
bool Put(const std::string& text, const ByteSink& sink) {
  return Put(uint64_t(text.size()), sink) && sink(text.data(), text.size());
}
bool PutHead(LoaderTask::Kind kind, const SceneLoadLimits& limits, uint64_t texts, const ByteSink& sink) {
  return Put(kind, sink) && Put(limits.max_scene_bytes, sink) && Put(limits.max_triangles, sink) &&
         Put(limits.max_json_bytes, sink) && Put(limits.max_json_depth, sink) && Put(limits.max_texture_pixels, sink) &&
         Put(texts, sink);
}

bool PutStatus(const absl::Status& status, const ByteSink& sink) {
  const std::string_view words(status.message().data(), std::min(status.message().size(), kMaxWords));
  return Put(uint32_t(status.code()), sink) && sink(words.data(), words.size());
}

absl::Status NoAnswer(const std::string& why) { return absl::InternalError("the scene loader's answer: " + why); }

// Takes a value from the front.
template <typename T>
absl::StatusOr<T> Take(std::string_view* answer) {
  T value;
  if (answer->size() < sizeof(value)) return NoAnswer("it is cut");
  std::memcpy(&value, answer->data(), sizeof(value));
  answer->remove_prefix(sizeof(value));
  return value;
}

// Takes the status from the front.
absl::Status TakeStatus(std::string_view* answer) {
  ASSIGN_OR_RETURN(const uint32_t code, Take<uint32_t>(answer));
  if (code == uint32_t(absl::StatusCode::kOk)) return absl::OkStatus();
  if (code != uint32_t(absl::StatusCode::kInvalidArgument)) return NoAnswer("status " + std::to_string(code));
  return absl::InvalidArgumentError(std::string(answer->substr(0, kMaxWords)));
}

bool AnswerLoad(const LoaderTask& task, const ByteSink& sink) {
  FileMap files;
  for (size_t i = 1; i + 1 < task.texts.size(); i += 2) files[task.texts[i]] = &task.texts[i + 1];
  const absl::StatusOr<FlatScene> scene = LoadGltf(task.texts[0], files, task.limits);
  return PutStatus(scene.status(), sink) && (!scene.ok() || WriteFlatScene(*scene, sink));
}

bool AnswerDecode(const LoaderTask& task, const ByteSink& sink) {
  const absl::StatusOr<Rgba8Image> image =
      DecodeImage(EncodedImage{task.texts[0], task.texts[1]}, task.limits.max_texture_pixels);
  if (!PutStatus(image.status(), sink) || !image.ok()) return !image.ok();
  return Put(int32_t(image->width), sink) && Put(int32_t(image->height), sink) &&
         sink(image->texels.data(), image->texels.size());
}

}  // namespace

bool WriteLoadTask(const std::string& root, const FileMap& files, const SceneLoadLimits& limits, const ByteSink& sink) {
  bool is_written = PutHead(LoaderTask::kLoad, limits, 1 + 2 * files.size(), sink) && Put(root, sink);
  for (const auto& [uri, bytes] : files) is_written = is_written && Put(uri, sink) && Put(*bytes, sink);
  return is_written;
}

bool WriteDecodeTask(const EncodedImage& image, uint64_t max_pixels, const ByteSink& sink) {
  SceneLoadLimits limits;
  limits.max_texture_pixels = max_pixels;
  return PutHead(LoaderTask::kDecode, limits, 2, sink) && Put(image.name, sink) && Put(image.bytes, sink);
}

bool ReadTask(const ByteSource& source, LoaderTask* task) {
  const auto get = [&source](auto* value) { return source(value, sizeof(*value)); };
  uint64_t texts = 0;
  if (!get(&task->kind) || !get(&task->limits.max_scene_bytes) || !get(&task->limits.max_triangles) ||
      !get(&task->limits.max_json_bytes) || !get(&task->limits.max_json_depth) ||
      !get(&task->limits.max_texture_pixels) || !get(&texts)) {
    return false;
  }
  for (; texts > 0; --texts) {
    uint64_t size = 0;
    if (!get(&size)) return false;
    std::string& text = task->texts.emplace_back();
    text.resize(size);
    if (!source(text.data(), size)) return false;
  }
  return task->texts.size() >= (task->kind == LoaderTask::kLoad ? 1 : 2);
}

bool AnswerTask(const LoaderTask& task, const ByteSink& sink) {
  return task.kind == LoaderTask::kLoad ? AnswerLoad(task, sink) : AnswerDecode(task, sink);
}

absl::StatusOr<FlatScene> ReadSceneAnswer(std::string_view answer) {
  RETURN_IF_ERROR(TakeStatus(&answer));
  absl::StatusOr<FlatScene> scene = ReadFlatScene(answer);
  if (!scene.ok()) return NoAnswer(std::string(scene.status().message()));
  return scene;
}

absl::StatusOr<Rgba8Image> ReadImageAnswer(std::string_view answer) {
  RETURN_IF_ERROR(TakeStatus(&answer));
  Rgba8Image image;
  ASSIGN_OR_RETURN(image.width, Take<int32_t>(&answer));
  ASSIGN_OR_RETURN(image.height, Take<int32_t>(&answer));
  if (image.width <= 0 || image.height <= 0 || answer.size() % 4 != 0 ||
      answer.size() / 4 / uint64_t(image.width) != uint64_t(image.height) ||
      answer.size() / 4 % uint64_t(image.width) != 0) {
    return NoAnswer("an image of " + std::to_string(image.width) + " x " + std::to_string(image.height) + " in " +
                    std::to_string(answer.size()) + " bytes");
  }
  image.texels.assign(answer.begin(), answer.end());
  return image;
}

}  // namespace halfshade
