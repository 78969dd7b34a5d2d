#include "client/render_flags.h"

#include <absl/strings/ascii.h>
#include <absl/strings/match.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>
#include <absl/strings/str_split.h>
#include <google/protobuf/util/json_util.h>
#include <google/protobuf/util/time_util.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <map>
#include <set>

#include "client/exit_code.h"
#include "client/field_text.h"
#include "client/input_file.h"
#include "client/view_file.h"
#include "renderer/status.h"
#include "server/scene_name.h"

namespace halfshade {
namespace {

namespace fs = std::filesystem;

constexpr FieldWord kCameraWords[] = {
    {"eye", "eye"},     {"target", "target"}, {"up", "up"}, {"fovy", "fovy_deg"}, {"ortho_height", "ortho_height_m"},
    {"near", "near_m"}, {"far", "far_m"}};
constexpr FieldWord kLightWords[] = {{"center", "center"},       {"edge_u", "edge_u"},     {"edge_v", "edge_v"},
                                     {"direction", "direction"}, {"radiance", "radiance"}, {"intensity", "intensity"},
                                     {"two_sided", "two_sided"}};
constexpr FieldWord kGroundWords[] = {{"height", "height_m"}, {"size", "size_m"}, {"catcher", "shadow_catcher"}};

absl::Status ApplyRequestFile(const std::string& path, v1::RenderRequest* request) {
  ASSIGN_OR_RETURN(const std::string text, ReadInputFile(path));
  const auto status = google::protobuf::util::JsonStringToMessage(text, request);
  if (!status.ok()) return absl::InvalidArgumentError(absl::StrCat(path, ": ", std::string(status.message())));
  if (!request->scene().empty() && !IsSceneName(request->scene())) {
    request->set_scene((fs::path(path).parent_path() / request->scene()).string());
  }
  return absl::OkStatus();
}

// Two whole numbers with `separator` between them, of at least 1 each.
absl::Status ReadPair(const std::string& flag, const std::string& text, char separator, const std::string& form,
                      uint32_t* first, uint32_t* second) {
  const char* end = text.data() + text.size();
  const auto [middle, first_error] = std::from_chars(text.data(), end, *first);
  if (first_error == std::errc() && middle != end && *middle == separator) {
    const auto [stop, second_error] = std::from_chars(middle + 1, end, *second);
    if (second_error == std::errc() && stop == end && *first > 0 && *second > 0) return absl::OkStatus();
  }
  return UsageError(absl::StrCat(flag, ": '", text, "' is not ", form, " with whole numbers from 1 to 4294967295"));
}

absl::Status ApplyCamera(const RenderFlags& flags, v1::RenderRequest* request) {
  if (flags.camera_index) request->mutable_camera()->set_index(*flags.camera_index);
  if (flags.camera.empty()) return absl::OkStatus();
  request->clear_camera();
  return SetFieldsFromWords("--camera", flags.camera, kCameraWords, request->mutable_camera()->mutable_look_at());
}

absl::Status ApplyLights(const RenderFlags& flags, v1::RenderRequest* request) {
  if (!flags.lights.empty()) request->clear_lights();
  for (const std::string& light : flags.lights) {
    RETURN_IF_ERROR(SetFieldsFromWords("--light", light, kLightWords, request->add_lights()));
  }
  return absl::OkStatus();
}

absl::Status ApplyGround(const RenderFlags& flags, v1::RenderRequest* request) {
  if (flags.ground.empty()) return absl::OkStatus();
  request->clear_ground();
  return SetFieldsFromWords("--ground", flags.ground, kGroundWords, request->mutable_ground());
}

// The option message of the method that --method or the request file names; null where neither does.
absl::StatusOr<google::protobuf::Message*> SelectMethod(const std::string& name, v1::RenderRequest* request) {
  const google::protobuf::OneofDescriptor& methods = *v1::Method::descriptor()->oneof_decl(0);
  const google::protobuf::Reflection& reflection = *v1::Method::GetReflection();
  const google::protobuf::FieldDescriptor* field = nullptr;
  std::vector<std::string> names;
  for (int i = 0; i < methods.field_count(); ++i) {
    names.push_back(methods.field(i)->name());
    if (names.back() == absl::AsciiStrToLower(name)) field = methods.field(i);
  }
  if (name.empty()) field = reflection.GetOneofFieldDescriptor(request->method(), &methods);
  if (field == nullptr && !name.empty()) {
    return UsageError(absl::StrCat("--method: no method '", name, "'; there are ", absl::StrJoin(names, ", ")));
  }
  if (field == nullptr) return nullptr;
  return reflection.MutableMessage(request->mutable_method(), field);
}

absl::Status ApplyMethod(const RenderFlags& flags, v1::RenderRequest* request) {
  ASSIGN_OR_RETURN(google::protobuf::Message * options, SelectMethod(flags.method, request));
  for (const std::string& text : flags.options) {
    const std::vector<std::string> key_value = absl::StrSplit(text, absl::MaxSplits('=', 1));
    if (key_value.size() != 2) return UsageError(absl::StrCat("--set: '", text, "' is not KEY=VALUE"));
    if (options == nullptr) return UsageError("--set: needs --method, since every method has its own keys");
    const auto* field = options->GetDescriptor()->FindFieldByName(key_value[0]);
    if (field == nullptr) {
      std::vector<std::string> keys;
      for (int i = 0; i < options->GetDescriptor()->field_count(); ++i) {
        keys.push_back(options->GetDescriptor()->field(i)->name());
      }
      return UsageError(absl::StrCat("--set: this method has no option '", key_value[0], "'; it has ",
                                     keys.empty() ? "none" : absl::StrJoin(keys, ", ")));
    }
    RETURN_IF_ERROR(SetFieldFromText(options, *field, absl::StrCat("--set ", key_value[0]), key_value[1]));
  }
  return absl::OkStatus();
}

absl::Status ApplyNumbers(const RenderFlags& flags, v1::RenderRequest* request) {
  if (!flags.size.empty()) {
    ASSIGN_OR_RETURN(const auto size, ReadSize("--size", flags.size));
    request->set_width(size.first);
    request->set_height(size.second);
  }
  if (flags.max_error) request->mutable_budget()->set_max_error(*flags.max_error);
  if (flags.max_latency_ms) {
    // A Duration cannot say more than 10 000 years, nor NaN.
    if (!(std::abs(*flags.max_latency_ms) < 3e14)) return UsageError("--max-latency: not a number of milliseconds");
    *request->mutable_budget()->mutable_max_latency() =
        google::protobuf::util::TimeUtil::MicrosecondsToDuration(std::llround(*flags.max_latency_ms * 1000));
  }
  if (!flags.certify.empty()) {
    uint32_t pixels = 0, rays = 0;
    RETURN_IF_ERROR(ReadPair("--certify", flags.certify, ',', "PIXELS,RAYS", &pixels, &rays));
    request->mutable_certify()->set_pixels(pixels);
    request->mutable_certify()->set_rays(rays);
  }
  if (flags.seed) request->set_seed(*flags.seed);
  if (flags.expected_frames) request->set_expected_frames(*flags.expected_frames);
  if (!flags.cache.empty()) {
    const auto& field = *v1::RenderRequest::descriptor()->FindFieldByName("cache");
    RETURN_IF_ERROR(SetFieldFromText(request, field, "--cache", flags.cache));
  }
  return absl::OkStatus();
}

// By the file's extension. EXR: half floats hold colours well, and metres badly.
absl::StatusOr<v1::Encoding> EncodingOf(const std::string& file, v1::OutputKind kind) {
  const std::string extension = absl::AsciiStrToLower(fs::path(file).extension().string());
  if (extension == ".png") return v1::ENCODING_PNG;
  if (extension == ".exr") return kind == v1::OUTPUT_KIND_FRAME ? v1::ENCODING_EXR_HALF : v1::ENCODING_EXR_FLOAT;
  if (extension == ".jpg" || extension == ".jpeg") return v1::ENCODING_JPEG;
  if (extension == ".tif" || extension == ".tiff") return v1::ENCODING_TIFF;
  if (extension == ".f32") return v1::ENCODING_RAW_F32;
  if (extension == ".f16") return v1::ENCODING_RAW_F16;
  return UsageError(absl::StrCat("-o: '", file, "' has none of the extensions .png .exr .jpg .tif .f32 .f16"));
}

// "FILE" or "KIND=FILE". A file whose name has a '=' is told by a folder or a dot before it: "./a=b.png".
absl::Status ReadOutput(const std::string& text, v1::Output* output, std::string* file) {
  output->set_kind(v1::OUTPUT_KIND_FRAME);
  *file = text;
  const size_t equals = text.find('=');
  const std::string before = text.substr(0, equals);
  if (equals != std::string::npos && before.find_first_of("./") == std::string::npos) {
    const auto& field = *v1::Output::descriptor()->FindFieldByName("kind");
    RETURN_IF_ERROR(SetFieldFromText(output, field, "-o KIND=FILE", before));
    *file = text.substr(equals + 1);
  }
  ASSIGN_OR_RETURN(const v1::Encoding encoding, EncodingOf(*file, output->kind()));
  output->set_encoding(encoding);
  return absl::OkStatus();
}

// The layer of an output that shares its EXR with others: the request file's name for it, else its kind.
void NameLayer(v1::Output* output) {
  const std::string kind = v1::OutputKind_Name(output->kind()).substr(std::strlen("OUTPUT_KIND_"));
  if (output->layer().empty()) output->set_layer(absl::AsciiStrToLower(kind));
}

// Outputs of one FILE become layers of one EXR, which the first of them carries; all others have no layer.
absl::Status ShareFiles(PreparedRender* job) {
  std::map<std::string, std::vector<int>> targets;
  for (size_t i = 0; i < job->files.size(); ++i) {
    targets[fs::absolute(job->files[i]).lexically_normal().string()].push_back(int(i));
  }
  std::string shared;
  for (const auto& [target, outputs] : targets) {
    if (outputs.size() == 1) {
      job->request.mutable_outputs(outputs[0])->clear_layer();
      continue;
    }
    std::set<v1::OutputKind> kinds;
    for (const int i : outputs) {
      v1::Output* output = job->request.mutable_outputs(i);
      const bool is_exr = output->encoding() == v1::ENCODING_EXR_HALF || output->encoding() == v1::ENCODING_EXR_FLOAT;
      const std::string& file = job->files[size_t(outputs[0])];
      if (!is_exr || !kinds.insert(output->kind()).second) {
        return UsageError(
            absl::StrCat("-o: '", file, "' would be written twice; an .exr takes one output of each kind"));
      }
      if (!shared.empty() && shared != target) {
        return UsageError(absl::StrCat("-o: '", file, "' and another .exr have several outputs; one may"));
      }
      shared = target;
      NameLayer(output);
      if (i != outputs[0]) job->files[size_t(i)].clear();
    }
  }
  return absl::OkStatus();
}

// -o replaces the request file's outputs; what else that file says of an output of the same kind stays.
absl::Status ApplyOutputs(const RenderFlags& flags, PreparedRender* job) {
  if (flags.outputs.empty()) return absl::OkStatus();
  const auto asked = job->request.outputs();
  job->request.clear_outputs();
  for (const std::string& text : flags.outputs) {
    v1::Output from_flag;
    std::string file;
    RETURN_IF_ERROR(ReadOutput(text, &from_flag, &file));
    const auto same_kind = std::find_if(asked.begin(), asked.end(),
                                        [&](const v1::Output& output) { return output.kind() == from_flag.kind(); });
    v1::Output* output = job->request.add_outputs();
    if (same_kind != asked.end()) *output = *same_kind;
    output->MergeFrom(from_flag);
    job->files.push_back(file);
  }
  return ShareFiles(job);
}

}  // namespace

absl::StatusOr<std::pair<uint32_t, uint32_t>> ReadSize(const std::string& flag, const std::string& text) {
  std::pair<uint32_t, uint32_t> size;
  RETURN_IF_ERROR(ReadPair(flag, text, 'x', "WIDTHxHEIGHT", &size.first, &size.second));
  return size;
}

absl::StatusOr<PreparedRender> PrepareRender(const RenderFlags& flags) {
  PreparedRender job;
  v1::RenderRequest* request = &job.request;
  if (!flags.request_file.empty()) RETURN_IF_ERROR(ApplyRequestFile(flags.request_file, request));
  if (!flags.view_file.empty()) RETURN_IF_ERROR(ApplyViewFile(flags.view_file, request));
  if (!flags.scene.empty() && flags.scene != "-") request->set_scene(flags.scene);
  if (request->scene().empty()) return UsageError("SCENE: none given, and no file names one");
  RETURN_IF_ERROR(ApplyCamera(flags, request));
  RETURN_IF_ERROR(ApplyLights(flags, request));
  RETURN_IF_ERROR(ApplyGround(flags, request));
  RETURN_IF_ERROR(ApplyMethod(flags, request));
  RETURN_IF_ERROR(ApplyNumbers(flags, request));
  RETURN_IF_ERROR(ApplyOutputs(flags, &job));
  return job;
}

}  // namespace halfshade
