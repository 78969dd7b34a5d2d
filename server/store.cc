#include "server/store.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <filesystem>

#include "renderer/status.h"

namespace halfshade {
namespace {

namespace fs = std::filesystem;
constexpr const char* kFolders[kStoreKinds] = {"blobs", "scenes", "derived"};
constexpr char kIncoming[] = "incoming";
constexpr char kLock[] = "lock";

absl::Status Unusable(const std::string& directory, const std::string& why) {
  return absl::FailedPreconditionError("scene store " + directory + ": " + why);
}

}  // namespace

absl::StatusOr<std::unique_ptr<Store>> Store::Open(const std::string& directory, const StoreOptions& options) {
  auto store = std::unique_ptr<Store>(new Store);
  store->options_ = options;
  store->files_ = options.files;
  store->directory_ = directory;
  if (directory.empty()) {
    std::string pattern = (fs::temp_directory_path() / "halfshade-XXXXXX").string();
    if (mkdtemp(pattern.data()) == nullptr) return Unusable(pattern, std::string(FileError("making it").message()));
    store->directory_ = pattern;
    store->is_temporary_ = true;
  }
  for (const char* folder : {kFolders[0], kFolders[1], kFolders[2], kIncoming}) {
    std::error_code error;
    fs::create_directories(fs::path(store->directory_) / folder, error);
    if (error) return Unusable(store->directory_, error.message());
  }
  RETURN_IF_ERROR(store->Lock());
  RETURN_IF_ERROR(store->Scan());
  RETURN_IF_ERROR(store->ScanIncoming());
  return store;
}

// Two processes would drop each other's unfinished blobs. The lock goes with the process, however it ends.
absl::Status Store::Lock() {
  lock_file_ = files_->Open(directory_ + "/" + kLock, O_RDWR | O_CREAT);
  if (lock_file_ < 0) return Unusable(directory_, std::string(FileError(kLock).message()));
  if (flock(lock_file_, LOCK_EX | LOCK_NB) != 0) return Unusable(directory_, "another process has it");
  return absl::OkStatus();
}

absl::Status Store::Scan() {
  std::error_code error;
  std::vector<std::pair<fs::file_time_type, std::string>> derived;
  for (int kind = 0; kind < kStoreKinds; ++kind) {
    for (const auto& entry : fs::directory_iterator(fs::path(directory_) / kFolders[kind], error)) {
      const std::string digest = entry.path().filename().string();
      if (!entry.is_regular_file(error) || !IsSha256Hex(digest)) continue;
      sizes_[kind][digest] = entry.file_size(error);
      size_bytes_ += sizes_[kind][digest];
      if (StoreKind(kind) == StoreKind::kDerived) derived.emplace_back(entry.last_write_time(error), digest);
    }
    if (error) return Unusable(directory_, error.message());
  }
  std::sort(derived.begin(), derived.end());
  for (const auto& [time, digest] : derived) derived_uses_[digest] = next_use_++;
  return absl::OkStatus();
}

// What a killed process left: unfinished blobs are kept, oldest first in line to go, and synced now, so that what Query
// says holds; the rest is removed. (After a power cut a file may have its length and not its bytes. The digest at the
// end finds that.)
absl::Status Store::ScanIncoming() {
  std::error_code error;
  std::vector<std::pair<fs::file_time_type, std::string>> kept;
  for (const auto& entry : fs::directory_iterator(IncomingPath(""), error)) {
    const std::string name = entry.path().filename().string();
    const bool is_resumable =
        IsSha256Hex(name) && entry.is_regular_file(error) && entry.file_size(error) > 0 && !Has(StoreKind::kBlob, name);
    if (is_resumable) {
      kept.emplace_back(entry.last_write_time(error), name);
    } else {
      fs::remove_all(entry.path(), error);
    }
  }
  if (error) return Unusable(directory_, error.message());
  std::sort(kept.begin(), kept.end());
  for (const auto& [time, name] : kept) {
    const std::string path = IncomingPath(name);
    const int file = files_->Open(path, O_RDONLY);
    struct stat status {};
    const bool is_synced = file >= 0 && fstat(file, &status) == 0 && files_->Sync(file) == 0;
    if (file >= 0) files_->Close(file);
    if (!is_synced) return Unusable(directory_, std::string(FileError(path).message()));
    unfinished_[name] = {uint64_t(status.st_size), uint64_t(status.st_size), next_use_++, nullptr};
    size_bytes_ += uint64_t(status.st_size);
  }
  return absl::OkStatus();
}

Store::~Store() {
  std::error_code error;
  if (is_temporary_) fs::remove_all(directory_, error);
  if (lock_file_ >= 0) files_->Close(lock_file_);
}

std::string Store::Folder(StoreKind kind) const { return directory_ + "/" + kFolders[int(kind)]; }
std::string Store::Path(StoreKind kind, const std::string& digest) const { return Folder(kind) + "/" + digest; }
std::string Store::IncomingPath(const std::string& name) const { return directory_ + "/" + kIncoming + "/" + name; }

Store::Progress Store::Query(const std::string& blob_digest) const {
  const std::lock_guard lock(mutex_);
  const auto& sizes = sizes_[int(StoreKind::kBlob)];
  if (const auto whole = sizes.find(blob_digest); whole != sizes.end()) return {whole->second, true};
  if (const auto part = unfinished_.find(blob_digest); part != unfinished_.end()) {
    return {part->second.committed_bytes, false};
  }
  return {};
}

bool Store::Has(StoreKind kind, const std::string& digest) const {
  const std::lock_guard lock(mutex_);
  return sizes_[int(kind)].contains(digest);
}

uint64_t Store::SizeOf(StoreKind kind, const std::string& digest) const {
  const std::lock_guard lock(mutex_);
  const auto found = sizes_[int(kind)].find(digest);
  return found == sizes_[int(kind)].end() ? 0 : found->second;
}

absl::StatusOr<std::string> Store::Get(StoreKind kind, const std::string& digest) {
  uint64_t size = 0;
  {
    const std::lock_guard lock(mutex_);
    const auto found = sizes_[int(kind)].find(digest);
    if (found == sizes_[int(kind)].end()) return absl::NotFoundError(digest + " is not here");
    size = found->second;
    if (kind == StoreKind::kDerived) derived_uses_[digest] = next_use_++;
  }
  // A file that Remove takes away meanwhile is read to its end.
  const int file = files_->Open(Path(kind, digest), O_RDONLY);
  if (file < 0 && errno == ENOENT) {
    Discard(kind, digest, 0);
    return absl::NotFoundError(digest + " is not here");
  }
  if (file < 0) return FileError("opening " + digest);
  struct stat status {};
  std::string bytes;
  bool is_read = fstat(file, &status) == 0;
  if (is_read && uint64_t(status.st_size) == size) {
    bytes.resize(size);
    const ssize_t got = files_->ReadUpTo(file, bytes.data(), size, 0);
    is_read = got >= 0;
    bytes.resize(size_t(std::max<ssize_t>(got, 0)));
  }
  const absl::Status error = is_read ? absl::OkStatus() : FileError("reading " + digest);
  files_->Close(file);
  RETURN_IF_ERROR(error);  // may pass: not the file's fault
  if (uint64_t(status.st_size) != size || bytes.size() != size ||
      (kind != StoreKind::kDerived && Sha256Hex(bytes) != digest)) {
    Discard(kind, digest, status.st_ino);
    return absl::DataLossError(digest + " was damaged in the scene store and is removed; upload it again");
  }
  return bytes;
}

// Forgets a value whose file is gone, or is the one of this inode: another may have taken its place.
void Store::Discard(StoreKind kind, const std::string& digest, uint64_t inode) {
  const std::lock_guard lock(mutex_);
  struct stat status {};
  const bool is_there = stat(Path(kind, digest).c_str(), &status) == 0;
  if (is_there && status.st_ino != inode) return;
  if (!sizes_[int(kind)].contains(digest)) return;
  Forget(kind, digest);
  if (is_there) files_->Unlink(Path(kind, digest));
}

absl::Status Store::Remove(StoreKind kind, const std::vector<std::string>& digests) {
  {
    const std::lock_guard lock(mutex_);
    for (const std::string& digest : digests) {
      if (!sizes_[int(kind)].contains(digest)) continue;
      if (files_->Unlink(Path(kind, digest)) != 0 && errno != ENOENT) return FileError("removing " + digest);
      Forget(kind, digest);
    }
  }
  return files_->SyncFolder(Folder(kind)) == 0 ? absl::OkStatus() : FileError("syncing the scene store");
}

void Store::Forget(StoreKind kind, const std::string& digest) {
  const auto found = sizes_[int(kind)].find(digest);
  if (found == sizes_[int(kind)].end()) return;
  size_bytes_ -= found->second;
  sizes_[int(kind)].erase(found);
  if (kind == StoreKind::kDerived) derived_uses_.erase(digest);
}

std::vector<std::string> Store::List(StoreKind kind) const {
  const std::lock_guard lock(mutex_);
  std::vector<std::string> digests;
  for (const auto& [digest, size] : sizes_[int(kind)]) digests.push_back(digest);
  return digests;
}

uint64_t Store::size_bytes() const {
  const std::lock_guard lock(mutex_);
  return size_bytes_;
}

}  // namespace halfshade
