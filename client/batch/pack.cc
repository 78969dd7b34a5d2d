#include "client/batch/pack.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <cassert>
#include <cstring>
#include <filesystem>

#include "client/batch/item_store.h"
#include "client/input_file.h"
#include "client/output_file.h"
#include "renderer/status.h"
#include "server/digest.h"

namespace halfshade {
namespace {

constexpr size_t kBlock = 512;

// POSIX.1-1988 ustar; numbers are octal text.
struct TarHeader {
  char name[100], mode[8], uid[8], gid[8], size[12], mtime[12], checksum[8], type, link[100], magic[6], version[2],
      user[32], group[32], major[8], minor[8], prefix[155], rest[12];
};
static_assert(sizeof(TarHeader) == kBlock);

template <size_t kSize>
void SetOctal(uint64_t value, char (&field)[kSize]) {
  const std::string digits = absl::StrFormat("%0*o", int(kSize - 1), value);
  std::memcpy(field, digits.c_str(), kSize);
}

// The item's members, or which of its files is not what its line says.
absl::StatusOr<std::string> MembersOf(const std::string& folder, const ManifestLine& line) {
  std::string members;
  for (const ManifestFile& file : line.files) {
    const std::string path = absl::StrCat(folder, "/", file.name);
    // A name in a manifest may be anything; one of ours begins with the id and has no folder.
    const bool is_ours = file.name.rfind(line.id + ".", 0) == 0 && file.name.find('/') == std::string::npos;
    const absl::StatusOr<std::string> bytes = ReadInputFile(path);
    if (!is_ours || file.name.size() > sizeof(TarHeader::name) || !bytes.ok() || Sha256Hex(*bytes) != file.sha256) {
      return absl::InvalidArgumentError(
          absl::StrCat(path, ": is not what the manifest says; the batch with --resume mends it"));
    }
    members += TarMember(file.name, *bytes);
  }
  return members + TarMember(line.id + ".json", line.text + "\n");
}

}  // namespace

std::string TarMember(const std::string& name, const std::string& bytes) {
  assert(!name.empty() && name.size() <= sizeof(TarHeader::name) && bytes.size() < uint64_t{8} << 30);
  TarHeader header{};
  std::memcpy(header.name, name.data(), name.size());
  SetOctal(0644, header.mode);
  SetOctal(0, header.uid);
  SetOctal(0, header.gid);
  SetOctal(bytes.size(), header.size);
  SetOctal(0, header.mtime);
  header.type = '0';
  std::memcpy(header.magic, "ustar", sizeof(header.magic));
  std::memcpy(header.version, "00", sizeof(header.version));
  // The sum of all bytes, its own field as blanks: six digits, NUL, blank.
  std::memset(header.checksum, ' ', sizeof(header.checksum));
  uint32_t sum = 0;
  unsigned char raw[kBlock];
  std::memcpy(raw, &header, kBlock);
  for (const unsigned char byte : raw) sum += byte;
  std::memcpy(header.checksum, absl::StrFormat("%06o", sum).c_str(), 7);
  std::string member(reinterpret_cast<const char*>(&header), kBlock);
  member += bytes;
  member.resize((member.size() + kBlock - 1) / kBlock * kBlock, '\0');
  return member;
}

std::string TarEnd() { return std::string(2 * kBlock, '\0'); }

absl::StatusOr<Packed> PackItems(const std::string& folder, const std::string& to_folder, uint64_t max_bytes) {
  RETURN_IF_ERROR(CheckInputFile(absl::StrCat(folder, "/", kManifestName)));
  ASSIGN_OR_RETURN(const auto manifest, ReadManifest(folder));
  Packed packed;
  std::string shard;
  const auto flush = [&]() -> absl::Status {
    const std::string path = absl::StrFormat("%s/shard-%06d.tar", to_folder, packed.shards);
    ++packed.shards;
    return WriteOutputFiles({{path, std::exchange(shard, {}) + TarEnd()}});
  };
  for (const auto& [id, line] : manifest) {
    ASSIGN_OR_RETURN(const std::string members, MembersOf(folder, line));
    if (!shard.empty() && shard.size() + members.size() + TarEnd().size() > max_bytes) RETURN_IF_ERROR(flush());
    shard += members;
    ++packed.items;
  }
  if (!shard.empty()) RETURN_IF_ERROR(flush());
  return packed;
}

}  // namespace halfshade
