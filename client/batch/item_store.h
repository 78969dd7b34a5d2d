// What a batch leaves in its folder: every item's files, and manifest.jsonl with a line for each item whose files are
// whole. Several processes may work in one folder at a time, on different items.
#pragma once

#include <absl/status/statusor.h>

#include <map>
#include <set>
#include <string>
#include <vector>

#include "client/batch/batch_file.h"
#include "halfshade/v1/render.pb.h"
#include "server/file_operations.h"

namespace halfshade {

inline constexpr char kManifestName[] = "manifest.jsonl";

struct ManifestFile {
  std::string name;
  std::string sha256;
};

struct ManifestLine {
  std::string text;  // without its end
  std::string id;
  std::string request_sha256;  // RequestDigest, with the scene's name
  std::vector<ManifestFile> files;
};

// Writes the item's files, then its line: both are on disk when it returns, and the line is in the manifest only if
// every file is. `line.request.scene` is the scene's name. Thread-safe. Errors: exit code 74; no half line and no
// temporary file is left. INTERNAL for a response that does not fit the request.
absl::Status StoreItem(const std::string& folder, const BatchLine& line, const v1::RenderResponse& response,
                       FileOperations* operations = SystemFiles());

// The last line of each id that can be read as one; none without a manifest.
absl::StatusOr<std::map<std::string, ManifestLine>> ReadManifest(const std::string& folder);

// Whether the line is of this very request, and every file has the digest that it tells.
bool IsWhole(const std::string& folder, const ManifestLine& line, const std::string& request_sha256);

// For a run that goes on after another: takes temporary files of these items away, and lines from the manifest that are
// torn or of one of these items but not in `whole`. Exit code 74.
absl::Status CleanUp(const std::string& folder, const std::set<std::string>& ids, const std::set<std::string>& whole,
                     FileOperations* operations = SystemFiles());

}  // namespace halfshade
