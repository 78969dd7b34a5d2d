#include "server/scene_name.h"

#include <algorithm>

#include "server/digest.h"

namespace halfshade {
namespace {

constexpr char kPrefix[] = "scenes/";

}  // namespace

std::string SceneManifest(const std::string& root_digest, const std::map<std::string, std::string>& files) {
  std::string text = root_digest + "\n";
  for (const auto& [uri, digest] : files) text.append(digest).append(" ").append(uri).append("\n");
  return text;
}

bool ParseSceneManifest(const std::string& manifest, std::string* root_digest,
                        std::map<std::string, std::string>* files) {
  constexpr size_t kHex = 64;
  *root_digest = manifest.substr(0, kHex);
  files->clear();
  for (size_t at = kHex + 1; at < manifest.size();) {
    const size_t end = manifest.find('\n', at);
    if (end == std::string::npos || end < at + kHex + 1) return false;
    (*files)[manifest.substr(at + kHex + 1, end - at - kHex - 1)] = manifest.substr(at, kHex);
    at = end + 1;
  }
  // The same text again: digests, separators and order are as they must be.
  const auto is_digest = [](const auto& file) { return IsSha256Hex(file.second); };
  return IsSha256Hex(*root_digest) && std::all_of(files->begin(), files->end(), is_digest) &&
         SceneManifest(*root_digest, *files) == manifest;
}

std::string SceneName(const std::string& root_digest, const std::map<std::string, std::string>& files) {
  return kPrefix + Sha256Hex(SceneManifest(root_digest, files));
}

bool IsSceneName(const std::string& name) {
  return name.starts_with(kPrefix) && IsSha256Hex(name.substr(sizeof(kPrefix) - 1));
}

}  // namespace halfshade
