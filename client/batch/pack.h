// Items of a batch into tar files by the WebDataset convention: members of one item stand together and share the name
// up to the first dot, "<id>.frame.png", "<id>.depth.exr", and "<id>.json", the item's line of the manifest.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <string>

namespace halfshade {

// A member of a tar file (POSIX ustar): header, bytes, zeros up to 512. Time, owner and group are 0, so that the same
// members make the same file. `name` has 1 to 100 bytes, `bytes` fewer than 8 GiB (asserted).
std::string TarMember(const std::string& name, const std::string& bytes);
// What ends a tar file.
std::string TarEnd();

struct Packed {
  uint64_t items = 0;
  uint64_t shards = 0;
};

// Every item of `folder`'s manifest, by id, into to_folder/shard-000000.tar and on, each whole or absent; a shard ends
// before the item that would take it over max_bytes (one item at least). Only what has its digest is packed:
// INVALID_ARGUMENT naming the file otherwise. NOT_FOUND without a manifest; exit code 74 where it cannot be written.
absl::StatusOr<Packed> PackItems(const std::string& folder, const std::string& to_folder, uint64_t max_bytes);

}  // namespace halfshade
