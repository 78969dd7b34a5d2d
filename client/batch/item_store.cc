#include "client/batch/item_store.h"

#include <absl/strings/str_cat.h>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <utility>

#include "client/batch/item_geometry.h"
#include "client/batch/request_digest.h"
#include "client/exit_code.h"
#include "client/input_file.h"
#include "client/output_file.h"
#include "client/session.h"
#include "renderer/status.h"
#include "server/digest.h"

namespace halfshade {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

absl::Status CannotWrite(const std::string& path) {
  return CannotWriteError(absl::StrCat(path, ": ", std::strerror(errno)));
}

// The manifest, open, and nobody else's until it is closed.
class LockedManifest {
 public:
  LockedManifest(const std::string& folder, FileOperations* operations)
      : folder_(folder), path_(absl::StrCat(folder, "/", kManifestName)), operations_(*operations) {}
  LockedManifest(const LockedManifest&) = delete;
  LockedManifest& operator=(const LockedManifest&) = delete;
  ~LockedManifest() {
    if (file_ >= 0) operations_.Close(file_);
  }

  absl::Status Open() {
    while (true) {
      file_ = operations_.Open(path_, O_RDWR | O_CREAT, 0666);
      if (file_ < 0) return CannotWrite(path_);
      // A file system without locks: each process needs a folder of its own there.
      while (flock(file_, LOCK_EX) != 0 && errno == EINTR) {
      }
      struct stat held {
      }, named{};
      if (fstat(file_, &held) != 0) return CannotWrite(path_);
      // CleanUp may have put another file in its place meanwhile.
      if (stat(path_.c_str(), &named) == 0 && held.st_ino == named.st_ino && held.st_dev == named.st_dev) {
        size_ = held.st_size;
        return absl::OkStatus();
      }
      operations_.Close(std::exchange(file_, -1));
    }
  }

  // On disk when it returns; after an error nothing of it is there. A torn line at the end, of a process that was
  // killed, is cut off first.
  absl::Status Append(const std::string& line) {
    RETURN_IF_ERROR(CutTornLine());
    const std::string bytes = line + "\n";
    if (operations_.WriteAll(file_, bytes.data(), bytes.size(), size_) != 0 || operations_.Sync(file_) != 0) {
      absl::Status status = CannotWrite(path_);
      // Where this fails too, the next one cuts.
      (void)operations_.Truncate(file_, size_);
      return status;
    }
    if (size_ == 0 && operations_.SyncFolder(folder_) != 0) return CannotWrite(folder_);
    size_ += off_t(bytes.size());
    return absl::OkStatus();
  }

  absl::StatusOr<std::string> Read() {
    std::string text(size_t(size_), '\0');
    if (operations_.ReadUpTo(file_, text.data(), text.size(), 0) != size_) return CannotWrite(path_);
    return text;
  }

  // The lock holds for the file that is replaced: others who wait for it open the new one.
  absl::Status Replace(const std::string& text) { return WriteOutputFiles({{path_, text}}, &operations_); }

 private:
  absl::Status CutTornLine() {
    off_t end = size_;
    for (char last = 0; end > 0; --end) {
      if (operations_.ReadUpTo(file_, &last, 1, end - 1) != 1) return CannotWrite(path_);
      if (last == '\n') break;
    }
    if (end == size_) return absl::OkStatus();
    if (operations_.Truncate(file_, end) != 0) return CannotWrite(path_);
    size_ = end;
    return absl::OkStatus();
  }

  const std::string folder_, path_;
  FileOperations& operations_;
  int file_ = -1;
  off_t size_ = 0;
};

std::string WithoutPrefix(const std::string& name, const std::string& prefix) { return name.substr(prefix.size()); }

Json ToJson(const v1::OutputImage& image, const std::string& file, const std::string& pixel_sha256) {
  Json json = {{"file", file},
               {"kind", WithoutPrefix(v1::OutputKind_Name(image.kind()), "OUTPUT_KIND_")},
               {"encoding", WithoutPrefix(v1::Encoding_Name(image.encoding()), "ENCODING_")},
               {"width", image.width()},
               {"height", image.height()},
               {"channels", image.channels()},
               {"pixelSha256", pixel_sha256}};
  if (!image.layer().empty()) json["layer"] = image.layer();
  if (image.light_from_world_size() > 0) {
    json["lightFromWorld"] = std::vector<double>(image.light_from_world().begin(), image.light_from_world().end());
    json["window"] = std::vector<double>(image.window().begin(), image.window().end());
  }
  return json;
}

absl::StatusOr<std::string> ManifestText(const BatchLine& line, const v1::RenderResponse& response,
                                         const std::vector<std::string>& names) {
  ASSIGN_OR_RETURN(const Json geometry, ItemGeometry(line.request));
  Json files = Json::array(), outputs = Json::array();
  std::string layers;  // the file that all layers are in
  for (size_t i = 0; i < names.size(); ++i) {
    const v1::OutputImage& image = response.images(int(i));
    if (!names[i].empty()) {
      files.push_back({{"name", names[i]}, {"bytes", image.data().size()}, {"sha256", Sha256Hex(image.data())}});
      if (!image.layer().empty()) layers = names[i];
    }
    outputs.push_back(
        ToJson(image, image.layer().empty() ? names[i] : layers, response.report().outputs(int(i)).pixel_sha256()));
  }
  const Json json = {{"id", line.id},
                     {"scene", line.request.scene()},
                     {"files", files},
                     {"outputs", outputs},
                     {"camera", geometry["camera"]},
                     {"lights", geometry["lights"]},
                     {"requestSha256", RequestDigest(line.request)},
                     {"contentKey", response.report().content_key()},
                     {"report", Json::parse(halfshade::ToJson(response.report(), /*with_defaults=*/true))}};
  return json.dump();
}

// False for what is no line of ours.
bool ParseLine(const std::string& text, ManifestLine* line) {
  const Json json = Json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (!json.is_object() || !json.contains("files") || !json["files"].is_array()) return false;
  const auto string = [](const Json& object, const char* key) {
    const auto found = object.find(key);
    return found != object.end() && found->is_string() ? found->template get<std::string>() : std::string();
  };
  line->text = text;
  line->id = string(json, "id");
  line->request_sha256 = string(json, "requestSha256");
  for (const Json& file : json["files"]) {
    if (!file.is_object()) return false;
    line->files.push_back({string(file, "name"), string(file, "sha256")});
  }
  return !line->id.empty() && !line->files.empty();
}

// Whole lines: what stands after the last end of a line is torn.
std::vector<std::string> LinesOf(const std::string& text) {
  std::vector<std::string> lines;
  size_t begin = 0;
  for (size_t end; (end = text.find('\n', begin)) != std::string::npos; begin = end + 1) {
    lines.push_back(text.substr(begin, end - begin));
  }
  return lines;
}

}  // namespace

absl::Status StoreItem(const std::string& folder, const BatchLine& line, const v1::RenderResponse& response,
                       FileOperations* operations) {
  ASSIGN_OR_RETURN(const std::vector<std::string> names, ItemFileNames(line));
  const int outputs = int(names.size());
  if (response.images_size() != outputs || response.report().outputs_size() != outputs) {
    return absl::InternalError(absl::StrCat("the server sent ", response.images_size(), " images, not ", outputs));
  }
  ASSIGN_OR_RETURN(const std::string text, ManifestText(line, response, names));
  std::vector<OutputFile> files;
  for (int i = 0; i < outputs; ++i) {
    if (!names[size_t(i)].empty()) files.push_back({folder + "/" + names[size_t(i)], response.images(i).data()});
  }
  RETURN_IF_ERROR(WriteOutputFiles(files, operations));
  LockedManifest manifest(folder, operations);
  RETURN_IF_ERROR(manifest.Open());
  return manifest.Append(text);
}

absl::StatusOr<std::map<std::string, ManifestLine>> ReadManifest(const std::string& folder) {
  std::map<std::string, ManifestLine> lines;
  const absl::StatusOr<std::string> text = ReadInputFile(absl::StrCat(folder, "/", kManifestName));
  if (absl::IsNotFound(text.status())) return lines;
  RETURN_IF_ERROR(text.status());
  for (const std::string& of_line : LinesOf(*text)) {
    ManifestLine line;
    if (ParseLine(of_line, &line)) lines[line.id] = line;
  }
  return lines;
}

bool IsWhole(const std::string& folder, const ManifestLine& line, const std::string& request_sha256) {
  return line.request_sha256 == request_sha256 &&
         std::all_of(line.files.begin(), line.files.end(), [&](const ManifestFile& file) {
           const absl::StatusOr<std::string> bytes = ReadInputFile(folder + "/" + file.name);
           return bytes.ok() && Sha256Hex(*bytes) == file.sha256;
         });
}

absl::Status CleanUp(const std::string& folder, const std::set<std::string>& ids, const std::set<std::string>& whole,
                     FileOperations* operations) {
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const std::string target = TargetOfTemporary(entry.path().filename().string());
    const std::string id = target.substr(0, target.find('.'));
    if (ids.contains(id) || target == kManifestName) operations->Unlink(entry.path().string());
  }
  LockedManifest manifest(folder, operations);
  RETURN_IF_ERROR(manifest.Open());
  ASSIGN_OR_RETURN(const std::string text, manifest.Read());
  std::map<std::string, std::string> kept;  // id -> its last line
  std::vector<std::string> order;
  for (const std::string& of_line : LinesOf(text)) {
    ManifestLine line;
    if (!ParseLine(of_line, &line) || (ids.contains(line.id) && !whole.contains(line.id))) continue;
    if (!kept.contains(line.id)) order.push_back(line.id);
    kept[line.id] = of_line;
  }
  std::string clean;
  for (const std::string& id : order) absl::StrAppend(&clean, kept[id], "\n");
  return clean == text ? absl::OkStatus() : manifest.Replace(clean);
}

}  // namespace halfshade
