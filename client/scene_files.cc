#include "client/scene_files.h"

#include <absl/strings/ascii.h>
#include <absl/strings/escaping.h>
#include <absl/strings/match.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_split.h>
#include <absl/strings/strip.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>

#include "client/input_file.h"
#include "client/obj_to_glb.h"
#include "renderer/status.h"
#include "server/digest.h"
#include "server/scene_name.h"

namespace halfshade {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

// The JSON of a GLB (its first chunk) or of a .gltf (all of it); "" where the container is broken.
std::string JsonText(const std::string& root) {
  if (!absl::StartsWith(root, "glTF")) return root;
  constexpr size_t kHeader = 20;  // magic, version, length; the chunk's length and type; little-endian
  uint32_t length = 0;
  if (root.size() < kHeader || root.compare(16, 4, "JSON") != 0) return "";
  for (size_t i = 4; i-- > 0;) length = length << 8 | static_cast<unsigned char>(root[12 + i]);
  return root.substr(kHeader, length);
}

// "%20" -> " "; a percent sign that starts no escape stays.
std::string PercentDecode(const std::string& uri) {
  std::string decoded;
  for (size_t i = 0; i < uri.size(); ++i) {
    const bool is_escape =
        uri[i] == '%' && i + 2 < uri.size() && absl::ascii_isxdigit(uri[i + 1]) && absl::ascii_isxdigit(uri[i + 2]);
    decoded += is_escape ? absl::HexStringToBytes(uri.substr(i + 1, 2)) : std::string(1, uri[i]);
    if (is_escape) i += 2;
  }
  return decoded;
}

// "http:", "file:": letters before a colon and before any slash.
bool HasScheme(const std::string& uri) {
  const size_t colon = uri.find(':');
  return colon != std::string::npos && colon > 0 && absl::ascii_isalpha(uri[0]) &&
         std::all_of(uri.begin(), uri.begin() + static_cast<ptrdiff_t>(colon),
                     [](char c) { return absl::ascii_isalnum(c) || c == '+' || c == '-' || c == '.'; });
}

bool IsDataUri(const std::string& uri) { return absl::StartsWithIgnoreCase(uri, "data:"); }

absl::Status SchemeFault() {
  return absl::InvalidArgumentError("has a scheme; only files in the scene's folder and data URIs are read");
}

bool IsInside(const fs::path& folder, const fs::path& file) {
  return std::mismatch(folder.begin(), folder.end(), file.begin(), file.end()).first == folder.end();
}

// The regular file that `name` means in `folder`, which is canonical. NOT_FOUND if there is none, INVALID_ARGUMENT if
// it may not be read.
absl::StatusOr<fs::path> ResolveInFolder(const fs::path& folder, const std::string& name) {
  auto fault = [](const std::string& why) { return absl::InvalidArgumentError(why); };
  if (name.empty()) return fault("is empty");
  if (name.find('\0') != std::string::npos) return fault("has a NUL byte");
  std::error_code error;
  const fs::path file = fs::weakly_canonical(folder / name, error);
  if (error) return fault(error.message());
  if (name[0] == '/' || !IsInside(folder, file)) return fault("outside the scene's folder");
  if (!fs::exists(file, error)) return absl::NotFoundError("no such file");
  if (!fs::is_regular_file(file, error)) return fault("is not a regular file");
  return file;
}

absl::StatusOr<std::string> ReadInFolder(const fs::path& folder, const std::string& name) {
  ASSIGN_OR_RETURN(const fs::path file, ResolveInFolder(folder, name));
  return ReadInputFile(file.string());
}

// The words of a mtllib line as tinyobjloader splits them: at blanks, a backslash keeps the next character.
std::vector<std::string> MaterialFiles(const std::string& words) {
  std::vector<std::string> names(1);
  for (size_t i = 0; i < words.size(); ++i) {
    if (words[i] == '\\' && i + 1 < words.size()) {
      names.back() += words[++i];
    } else if (words[i] == ' ' || words[i] == '\t') {
      names.emplace_back();
    } else {
      names.back() += words[i];
    }
  }
  std::erase(names, "");
  return names;
}

// tinyobjloader opens what mtllib names by itself, so that is judged before. An absent file only leaves the model grey.
absl::Status CheckMaterialFiles(const std::string& obj, const fs::path& folder) {
  for (const auto& part : absl::StrSplit(obj, absl::ByAnyChar("\r\n"))) {
    const std::string line(absl::StripLeadingAsciiWhitespace(part));
    if (!absl::StartsWith(line, "mtllib ") && !absl::StartsWith(line, "mtllib\t")) continue;
    for (const std::string& name : MaterialFiles(line.substr(7))) {
      const absl::Status status = ResolveInFolder(folder, name).status();
      if (status.ok() || absl::IsNotFound(status)) continue;
      return absl::InvalidArgumentError(
          absl::StrCat("mtllib ", absl::CHexEscape(name.substr(0, 200)), ": ", status.message()));
    }
  }
  return absl::OkStatus();
}

// URI (decoded) -> bytes, of every entry of `list` ("buffers", "images").
absl::Status ReadUris(const Json& gltf, const std::string& list, const fs::path& folder,
                      std::map<std::string, std::string>* files) {
  if (!gltf.is_object() || !gltf.contains(list) || !gltf[list].is_array()) return absl::OkStatus();
  for (size_t i = 0; i < gltf[list].size(); ++i) {
    const Json& entry = gltf[list][i];
    if (!entry.is_object() || !entry.contains("uri") || !entry["uri"].is_string()) continue;
    const std::string uri = entry["uri"].get<std::string>();
    const std::string key = PercentDecode(uri);
    if (IsDataUri(uri) || files->contains(key)) continue;
    absl::StatusOr<std::string> bytes = HasScheme(uri) ? SchemeFault() : ReadInFolder(folder, key);
    if (!bytes.ok()) {
      const std::string shown = absl::CHexEscape(uri.substr(0, 200));
      return absl::InvalidArgumentError(
          absl::StrCat("/", list, "/", i, "/uri: ", shown, ": ", bytes.status().message()));
    }
    files->emplace(key, *std::move(bytes));
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<SceneFiles> ReadSceneFiles(const std::string& path) {
  SceneFiles scene;
  ASSIGN_OR_RETURN(scene.root.bytes, ReadInputFile(path));
  std::error_code error;
  const fs::path folder = fs::canonical(fs::absolute(path).parent_path(), error);
  if (error) return absl::NotFoundError(absl::StrCat(path, ": ", error.message()));
  std::map<std::string, std::string> files;
  if (absl::EndsWithIgnoreCase(path, ".obj")) {
    RETURN_IF_ERROR(CheckMaterialFiles(scene.root.bytes, folder));
    // Without a folder in its path tinyobjloader would take an absolute mtllib by its word.
    ASSIGN_OR_RETURN(scene.root.bytes, ObjToGlb(fs::path(path).has_parent_path() ? path : "./" + path));
  } else {
    const Json gltf = Json::parse(JsonText(scene.root.bytes), nullptr, /*allow_exceptions=*/false);
    RETURN_IF_ERROR(ReadUris(gltf, "buffers", folder, &files));
    RETURN_IF_ERROR(ReadUris(gltf, "images", folder, &files));
  }
  scene.root.digest = Sha256Hex(scene.root.bytes);
  std::map<std::string, std::string> digests;
  for (auto& [uri, bytes] : files) {
    const std::string digest = Sha256Hex(bytes);
    digests[uri] = digest;
    scene.files.push_back({uri, std::move(bytes), digest});
  }
  scene.name = SceneName(scene.root.digest, digests);
  return scene;
}

absl::StatusOr<std::unique_ptr<SceneFiles>> TakeSceneFiles(v1::RenderRequest* request) {
  if (IsSceneName(request->scene())) return nullptr;
  ASSIGN_OR_RETURN(SceneFiles files, ReadSceneFiles(request->scene()));
  request->set_scene(files.name);
  return std::make_unique<SceneFiles>(std::move(files));
}

}  // namespace halfshade
