#include "server/scene_name.h"

#include "server/digest.h"

namespace halfshade {
namespace {

constexpr char kPrefix[] = "scenes/";

}  // namespace

std::string SceneName(const std::string& root_digest, const std::map<std::string, std::string>& files) {
  std::string text = root_digest + "\n";
  for (const auto& [uri, digest] : files) text += digest + " " + uri + "\n";
  return kPrefix + Sha256Hex(text);
}

bool IsSceneName(const std::string& name) {
  return name.starts_with(kPrefix) && IsSha256Hex(name.substr(sizeof(kPrefix) - 1));
}

}  // namespace halfshade
