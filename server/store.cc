#include "server/store.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "renderer/status.h"

namespace halfshade {
namespace {

namespace fs = std::filesystem;
constexpr const char* kFolders[2] = {"blobs", "scenes"};
constexpr char kTemporary[] = "incoming";

absl::Status Errno(const std::string& what) {
  const int error = errno;
  const std::string message = what + ": " + std::strerror(error);
  if (error == ENOSPC || error == EDQUOT) return absl::ResourceExhaustedError(message);
  return absl::InternalError(message);
}

absl::Status SyncFolder(const std::string& path) {
  const int folder = open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder < 0) return Errno("opening " + path);
  const int result = fsync(folder);
  close(folder);
  return result == 0 ? absl::OkStatus() : Errno("syncing " + path);
}

}  // namespace

absl::StatusOr<std::unique_ptr<Store>> Store::Open(const std::string& directory, uint64_t max_bytes) {
  auto store = std::unique_ptr<Store>(new Store);
  store->max_bytes_ = max_bytes;
  store->directory_ = directory;
  if (directory.empty()) {
    std::string pattern = (fs::temp_directory_path() / "halfshade-XXXXXX").string();
    if (mkdtemp(pattern.data()) == nullptr) return absl::FailedPreconditionError(Errno("making " + pattern).message());
    store->directory_ = pattern;
    store->is_temporary_ = true;
  }
  RETURN_IF_ERROR(store->Scan());
  return store;
}

absl::Status Store::Scan() {
  std::error_code error;
  fs::remove_all(fs::path(directory_) / kTemporary, error);
  for (const char* folder : {kFolders[0], kFolders[1], kTemporary}) {
    fs::create_directories(fs::path(directory_) / folder, error);
    if (error) return absl::FailedPreconditionError("scene store " + directory_ + ": " + error.message());
  }
  for (int kind = 0; kind < 2; ++kind) {
    for (const auto& entry : fs::directory_iterator(fs::path(directory_) / kFolders[kind], error)) {
      const std::string digest = entry.path().filename().string();
      if (!entry.is_regular_file(error) || !IsSha256Hex(digest)) continue;
      sizes_[kind][digest] = entry.file_size(error);
      size_bytes_ += sizes_[kind][digest];
    }
    if (error) return absl::FailedPreconditionError("scene store " + directory_ + ": " + error.message());
  }
  return absl::OkStatus();
}

Store::~Store() {
  std::error_code error;
  if (is_temporary_) fs::remove_all(directory_, error);
}

std::string Store::Path(StoreKind kind, const std::string& digest) const {
  return directory_ + "/" + kFolders[int(kind)] + "/" + digest;
}

absl::StatusOr<std::unique_ptr<Store::Writer>> Store::Write(StoreKind kind, const std::string& digest,
                                                            uint64_t size_bytes) {
  auto writer = std::unique_ptr<Writer>(new Writer);
  {
    const std::lock_guard lock(mutex_);
    if (size_bytes_ + size_bytes > max_bytes_) {
      return absl::ResourceExhaustedError("the scene store is full: " + std::to_string(size_bytes_) + " of " +
                                          std::to_string(max_bytes_) + " bytes are taken, " +
                                          std::to_string(size_bytes) + " more do not fit; delete scenes");
    }
    writer->path_ = directory_ + "/" + kTemporary + "/" + std::to_string(next_temporary_++);
  }
  writer->store_ = this;
  writer->kind_ = kind;
  writer->digest_ = digest;
  writer->file_ = open(writer->path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  if (writer->file_ < 0) return Errno("creating a file in the scene store");
  return writer;
}

Store::Writer::~Writer() {
  if (file_ < 0) return;
  close(file_);
  unlink(path_.c_str());
}

absl::Status Store::Writer::Append(const std::string& bytes) {
  size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t written = write(file_, bytes.data() + done, bytes.size() - done);
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return Errno("writing to the scene store");
    done += size_t(written);
  }
  sha_.Add(bytes.data(), bytes.size());
  size_bytes_ += bytes.size();
  return absl::OkStatus();
}

absl::Status Store::Writer::Commit() {
  const std::string actual = sha_.FinishHex();
  if (actual != digest_) {
    return absl::InvalidArgumentError("digest: " + digest_ + "; the bytes have " + actual);
  }
  if (fsync(file_) != 0) return Errno("syncing a file of the scene store");
  close(file_);
  file_ = -1;
  const std::string target = store_->Path(kind_, digest_);
  if (rename(path_.c_str(), target.c_str()) != 0) {
    const absl::Status status = Errno("renaming a file of the scene store");
    unlink(path_.c_str());
    return status;
  }
  RETURN_IF_ERROR(SyncFolder(store_->directory_ + "/" + kFolders[int(kind_)]));
  const std::lock_guard lock(store_->mutex_);
  if (store_->sizes_[int(kind_)].emplace(digest_, size_bytes_).second) store_->size_bytes_ += size_bytes_;
  return absl::OkStatus();
}

absl::Status Store::Put(StoreKind kind, const std::string& digest, const std::string& bytes) {
  ASSIGN_OR_RETURN(const auto writer, Write(kind, digest, bytes.size()));
  RETURN_IF_ERROR(writer->Append(bytes));
  return writer->Commit();
}

bool Store::Has(StoreKind kind, const std::string& digest) const {
  const std::lock_guard lock(mutex_);
  return sizes_[int(kind)].contains(digest);
}

absl::StatusOr<std::string> Store::Get(StoreKind kind, const std::string& digest) {
  if (!Has(kind, digest)) return absl::NotFoundError(digest + " is not here");
  std::ifstream file(Path(kind, digest), std::ios::binary);
  std::ostringstream bytes;
  bytes << file.rdbuf();
  if (!file || Sha256Hex(bytes.str()) != digest) {
    Remove(kind, digest);
    return absl::DataLossError(digest + " is damaged in the scene store; upload it again");
  }
  return std::move(bytes).str();
}

void Store::Remove(StoreKind kind, const std::string& digest) {
  const std::lock_guard lock(mutex_);
  const auto found = sizes_[int(kind)].find(digest);
  if (found == sizes_[int(kind)].end()) return;
  size_bytes_ -= found->second;
  sizes_[int(kind)].erase(found);
  unlink(Path(kind, digest).c_str());
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
