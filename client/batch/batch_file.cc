#include "client/batch/batch_file.h"

#include <absl/strings/ascii.h>
#include <absl/strings/escaping.h>
#include <absl/strings/str_cat.h>
#include <google/protobuf/util/json_util.h>

#include <algorithm>
#include <charconv>
#include <cstring>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <tuple>

#include "client/batch/request_digest.h"
#include "client/exit_code.h"
#include "client/input_file.h"
#include "renderer/status.h"
#include "server/scene_name.h"

namespace halfshade {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr int kMaxDepth = 100;

absl::Status Fault(const std::string& field, const std::string& fault) {
  return absl::InvalidArgumentError(absl::StrCat(field, ": ", fault));
}

// Of what a stranger wrote: short and printable.
std::string Shown(const std::string& text) { return absl::StrCat("'", absl::CHexEscape(text.substr(0, 100)), "'"); }

absl::Status CheckId(const Json& line) {
  const auto id = line.find("id");
  if (id == line.end()) return Fault("id", "missing");
  if (!id->is_string()) return Fault("id", "must be a string");
  const std::string text = id->get<std::string>();
  const bool is_plain =
      std::all_of(text.begin(), text.end(), [](char c) { return absl::ascii_isalnum(c) || c == '_' || c == '-'; });
  if (text.empty() || text.size() > kMaxIdLength || !is_plain) {
    return Fault("id", absl::StrCat(Shown(text), "; must be 1 to ", kMaxIdLength, " of A-Z a-z 0-9 _ -"));
  }
  return absl::OkStatus();
}

const char* ExtensionOf(v1::Encoding encoding) {
  switch (encoding) {
    case v1::ENCODING_UNSPECIFIED:
    case v1::ENCODING_PNG:
      return "png";
    case v1::ENCODING_EXR_HALF:
    case v1::ENCODING_EXR_FLOAT:
      return "exr";
    case v1::ENCODING_JPEG:
      return "jpg";
    case v1::ENCODING_TIFF:
      return "tif";
    case v1::ENCODING_RAW_F32:
      return "f32";
    case v1::ENCODING_RAW_F16:
      return "f16";
    default:
      return nullptr;
  }
}

// "frame"; "" for what is no kind.
std::string NameOf(v1::OutputKind kind) {
  if (kind == v1::OUTPUT_KIND_UNSPECIFIED) kind = v1::OUTPUT_KIND_FRAME;
  const std::string& name = v1::OutputKind_Name(kind);
  return absl::AsciiStrToLower(name.substr(std::min(name.size(), std::strlen("OUTPUT_KIND_"))));
}

uint64_t LightKey(const v1::RenderRequest& request) {
  v1::RenderRequest of_light;
  if (request.has_scene_index()) of_light.set_scene_index(request.scene_index());
  *of_light.mutable_animation() = request.animation();
  *of_light.mutable_node_overrides() = request.node_overrides();
  *of_light.mutable_lights() = request.lights();
  *of_light.mutable_method() = request.method();
  of_light.set_seed(request.seed());
  return std::stoull(RequestDigest(of_light).substr(0, 16), nullptr, 16);
}

}  // namespace

absl::StatusOr<Json> ParseLineJson(std::string_view text) {
  bool is_too_deep = false;  // for those who walk the tree
  const auto keeps = [&](int depth, Json::parse_event_t, Json&) {
    is_too_deep |= depth > kMaxDepth;
    return depth <= kMaxDepth;
  };
  Json json = Json::parse(text, keeps, /*allow_exceptions=*/false);
  if (is_too_deep) return absl::InvalidArgumentError(absl::StrCat("nested deeper than ", kMaxDepth));
  if (!json.is_object()) return absl::InvalidArgumentError("is not a JSON object");
  return json;
}

absl::StatusOr<BatchLine> ReadBatchLine(std::string_view text, const std::string& folder) {
  ASSIGN_OR_RETURN(Json json, ParseLineJson(text));
  RETURN_IF_ERROR(CheckId(json));
  BatchLine line;
  line.id = json["id"].get<std::string>();
  json.erase("id");
  const auto status = google::protobuf::util::JsonStringToMessage(json.dump(), &line.request);
  if (!status.ok()) return absl::InvalidArgumentError(std::string(status.message()));
  if (line.request.scene().empty()) return Fault("scene", "missing");
  if (!IsSceneName(line.request.scene())) line.request.set_scene((fs::path(folder) / line.request.scene()).string());
  RETURN_IF_ERROR(ItemFileNames(line).status());
  return line;
}

absl::StatusOr<std::vector<std::string>> ItemFileNames(const BatchLine& line) {
  auto outputs = line.request.outputs();
  if (outputs.empty()) outputs.Add();
  std::vector<std::string> names;
  std::map<std::string, int> owners;
  bool has_layers = false;
  for (int i = 0; i < outputs.size(); ++i) {
    const std::string field = absl::StrCat("outputs[", i, "]"), kind = NameOf(outputs[i].kind());
    const char* extension = ExtensionOf(outputs[i].encoding());
    if (kind.empty()) return Fault(field + ".kind", absl::StrCat(outputs[i].kind(), "; no such kind"));
    if (extension == nullptr) {
      return Fault(field + ".encoding", absl::StrCat(outputs[i].encoding(), "; no such encoding"));
    }
    if (!outputs[i].layer().empty()) {
      names.push_back(has_layers ? "" : absl::StrCat(line.id, ".layers.", extension));
      has_layers = true;
    } else {
      names.push_back(absl::StrCat(line.id, ".", kind, ".", extension));
    }
    const auto [owner, is_new] = owners.emplace(names.back(), i);
    if (!is_new && !names.back().empty()) {
      return Fault(field,
                   absl::StrCat("its file would be ", names.back(), ", as that of outputs[", owner->second, "]"));
    }
  }
  return names;
}

absl::StatusOr<BatchFile> ReadBatchFile(const std::string& path) {
  BatchFile batch;
  ASSIGN_OR_RETURN(batch.text, ReadInputFile(path));
  batch.folder = fs::absolute(path).lexically_normal().parent_path().string();
  std::map<std::string, size_t> lines;  // id -> line
  size_t number = 0;
  for (size_t begin = 0; begin < batch.text.size();) {
    const size_t size = std::min(batch.text.find('\n', begin), batch.text.size()) - begin;
    const std::string_view text = std::string_view(batch.text).substr(begin, size);
    ++number;
    if (text.find_first_not_of(" \t\r") != text.npos) {
      absl::StatusOr<BatchLine> line = ReadBatchLine(text, batch.folder);
      if (line.ok()) {
        const auto [first, is_new] = lines.emplace(line->id, number);
        if (!is_new) line = Fault("id", absl::StrCat(line->id, "; line ", first->second, " has it too"));
      }
      if (line.ok()) {
        batch.items.push_back({number, begin, size, line->id, line->request.scene(), LightKey(line->request)});
      } else {
        batch.failures.push_back({number, "", line.status()});
      }
    }
    begin += size + 1;
  }
  std::sort(batch.items.begin(), batch.items.end(), [](const BatchItem& a, const BatchItem& b) {
    return std::tie(a.scene, a.light_key, a.line) < std::tie(b.scene, b.light_key, b.line);
  });
  return batch;
}

absl::StatusOr<Shard> ReadShard(const std::string& text) {
  Shard shard;
  const char* end = text.data() + text.size();
  const auto [middle, first_error] = std::from_chars(text.data(), end, shard.index);
  if (first_error == std::errc() && middle != end && *middle == '/') {
    const auto [stop, second_error] = std::from_chars(middle + 1, end, shard.count);
    if (second_error == std::errc() && stop == end && shard.index < shard.count && shard.count <= kMaxShards) {
      return shard;
    }
  }
  return UsageError(absl::StrCat("--shard: '", text, "' is not I/N with whole numbers, 0 <= I < N <= ", kMaxShards));
}

std::vector<BatchItem> ItemsOf(const Shard& shard, const std::vector<BatchItem>& items) {
  const auto at = [&](size_t index) { return static_cast<ptrdiff_t>(items.size() * index / shard.count); };
  return {items.begin() + at(shard.index), items.begin() + at(shard.index + 1)};
}

}  // namespace halfshade
