// The requests of a batch: JSON Lines, each a RenderRequest in proto JSON plus `id`. Pure but for reading the file.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "halfshade/v1/render.pb.h"

namespace halfshade {

struct BatchLine {
  std::string id;             // 1 to kMaxIdLength of A-Z a-z 0-9 _ -
  v1::RenderRequest request;  // scene is "scenes/<hex>", or else the path of a file
};

// So that "<id>.soft_shadow_map.exr" fits the 100 bytes of a name in a tar file.
inline constexpr size_t kMaxIdLength = 80;

// A JSON object that is not nested too deep to be walked. INVALID_ARGUMENT.
absl::StatusOr<nlohmann::ordered_json> ParseLineJson(std::string_view text);

// `folder`: what a scene's path is relative to. INVALID_ARGUMENT naming the field.
absl::StatusOr<BatchLine> ReadBatchLine(std::string_view text, const std::string& folder);

// "<id>.<kind>.<ext>" of each output (none: one FRAME as PNG), in order. Outputs with a layer share "<id>.layers.exr",
// which the first of them has; the others have "". INVALID_ARGUMENT for an unknown kind or encoding, and for two
// outputs with one name.
absl::StatusOr<std::vector<std::string>> ItemFileNames(const BatchLine& line);

// A line that could be read, without its request: a million of them are held at a time.
struct BatchItem {
  size_t line = 0;   // from 1
  size_t begin = 0;  // of the line in BatchFile::text
  size_t size = 0;
  std::string id;
  std::string scene;       // as BatchLine's
  uint64_t light_key = 0;  // equal where lights, method, pose and seed are: what light data depends on
};

// What could not be read, or rendered.
struct BatchFailure {
  size_t line = 0;
  std::string id;  // may be "": not known
  absl::Status status;
};

struct BatchFile {
  std::string folder;
  std::string text;
  std::vector<BatchItem> items;        // by scene, then light, then line: neighbours share what a server caches
  std::vector<BatchFailure> failures;  // lines that are no requests, or whose id another has; by line

  std::string_view TextOf(const BatchItem& item) const { return std::string_view(text).substr(item.begin, item.size); }
};

// Every line but blank ones. NOT_FOUND without the file.
absl::StatusOr<BatchFile> ReadBatchFile(const std::string& path);

inline constexpr size_t kMaxShards = 1'000'000;

// One of `count` runs over one file, 0 <= index < count <= kMaxShards.
struct Shard {
  size_t index = 0;
  size_t count = 1;
};

// "I/N". Usage error.
absl::StatusOr<Shard> ReadShard(const std::string& text);

// The index-th of `count` stretches of `items`, whose lengths differ by one at most: a scene's items stay together.
std::vector<BatchItem> ItemsOf(const Shard& shard, const std::vector<BatchItem>& items);

}  // namespace halfshade
