// Values on their way into the store.
#include <fcntl.h>

#include <algorithm>
#include <vector>

#include "renderer/status.h"
#include "server/status.h"
#include "server/store.h"

namespace halfshade {
namespace {

constexpr size_t kReadBytes = 1 << 20;
constexpr auto kComeBack = std::chrono::milliseconds(500);

// Blobs lie there under their digest, and a later writer finds them; what is no digest is swept at the next start.
std::string NameInIncoming(StoreKind kind, const std::string& digest) {
  return kind == StoreKind::kBlob ? digest : (kind == StoreKind::kScene ? "scene-" : "derived-") + digest;
}

}  // namespace

absl::StatusOr<std::unique_ptr<Store::Writer>> Store::Write(StoreKind kind, const std::string& digest,
                                                            uint64_t size_bytes, uint64_t offset_bytes) {
  if (size_bytes > options_.max_bytes) {
    return absl::InvalidArgumentError("size_bytes: " + std::to_string(size_bytes) + "; the scene store holds at most " +
                                      std::to_string(options_.max_bytes));
  }
  auto writer = std::unique_ptr<Writer>(new Writer);
  const std::string name = NameInIncoming(kind, digest);
  {
    const std::lock_guard lock(mutex_);
    if (kind != StoreKind::kDerived && sizes_[int(kind)].contains(digest)) {
      return absl::AlreadyExistsError(digest + " is here");
    }
    const auto found = unfinished_.find(name);
    const Unfinished before = found == unfinished_.end() ? Unfinished{} : found->second;
    if (offset_bytes > before.committed_bytes) {
      return absl::InvalidArgumentError("offset_bytes: " + std::to_string(offset_bytes) + "; the next byte is " +
                                        std::to_string(before.committed_bytes));
    }
    if (before.writer != nullptr && (before.writer->is_busy_ || std::chrono::steady_clock::now() <
                                                                    before.writer->used_at_ + options_.yield_after)) {
      return ComeBackLater("digest: another call is uploading " + digest, kComeBack);
    }
    RETURN_IF_ERROR(MakeRoom(kind, name, size_bytes));
    if (before.writer != nullptr) before.writer->is_replaced_ = true;
    size_bytes_ += size_bytes - before.bytes;
    unfinished_[name] = {size_bytes, offset_bytes, next_use_++, writer.get()};
    // From here on the writer's destructor gives the entry back.
    writer->store_ = this;
    writer->kind_ = kind;
    writer->digest_ = digest;
    writer->size_bytes_ = writer->synced_bytes_ = offset_bytes;
  }
  RETURN_IF_ERROR(OpenIncoming(*writer));
  writer->End();
  return writer;
}

// Opens the writer's file, cut at its offset, and takes the digest of what is kept.
absl::Status Store::OpenIncoming(Writer& writer) {
  const std::string name = NameInIncoming(writer.kind_, writer.digest_);
  writer.file_ = files_->Open(IncomingPath(name), O_RDWR | O_CREAT);
  if (writer.file_ < 0) return FileError("opening incoming/" + name);
  if (files_->Truncate(writer.file_, off_t(writer.size_bytes_)) != 0) return FileError("truncating incoming/" + name);
  std::vector<char> bytes(std::min<size_t>(kReadBytes, writer.size_bytes_));
  for (uint64_t at = 0; at < writer.size_bytes_;) {
    const size_t wanted = std::min<size_t>(bytes.size(), writer.size_bytes_ - at);
    const ssize_t got = files_->ReadUpTo(writer.file_, bytes.data(), wanted, off_t(at));
    if (got != ssize_t(wanted)) {
      writer.is_worthless_ = true;
      return got < 0 ? FileError("reading incoming/" + name) : absl::InternalError("incoming/" + name + " is short");
    }
    writer.sha_.Add(bytes.data(), wanted);
    at += wanted;
  }
  return absl::OkStatus();
}

// Room for `bytes` under `name`, at the cost of what is derived and then of idle unfinished blobs, the longest
// untouched first; none of them goes if that is not enough. For what is derived no blob goes.
absl::Status Store::MakeRoom(StoreKind kind, const std::string& name, uint64_t bytes) {
  uint64_t own_bytes = 0, under_way_bytes = 0;
  uint32_t under_way = 0;
  std::vector<std::pair<uint64_t, std::string>> idle;  // by last use
  uint64_t idle_bytes = 0;
  for (const auto& [other, unfinished] : unfinished_) {
    if (other == name) {
      own_bytes = unfinished.bytes;
    } else if (unfinished.writer != nullptr || kind == StoreKind::kDerived) {
      ++under_way;
      under_way_bytes += unfinished.bytes;
    } else {
      idle.emplace_back(unfinished.last_use, other);
      idle_bytes += unfinished.bytes;
    }
  }
  if (under_way >= options_.max_unfinished) {
    return ComeBackLater("the scene store takes at most " + std::to_string(options_.max_unfinished) +
                             " uploads at a time; " + std::to_string(under_way) + " are under way",
                         kComeBack);
  }
  std::vector<std::pair<uint64_t, std::string>> derived;  // by last use
  uint64_t derived_bytes = 0;
  for (const auto& [digest, use] : derived_uses_) {
    derived.emplace_back(use, digest);
    derived_bytes += sizes_[int(StoreKind::kDerived)][digest];
  }
  const uint64_t taken = size_bytes_ - own_bytes - idle_bytes - derived_bytes;
  if (taken + bytes > options_.max_bytes) {
    const std::string message = "the scene store is full: " + std::to_string(taken) + " of " +
                                std::to_string(options_.max_bytes) + " bytes are taken, " + std::to_string(bytes) +
                                " more do not fit";
    if (taken - under_way_bytes + bytes <= options_.max_bytes) {
      return ComeBackLater(message + " beside the uploads under way", kComeBack);
    }
    return absl::ResourceExhaustedError(message + "; delete scenes");
  }
  std::sort(derived.begin(), derived.end());
  for (const auto& [use, digest] : derived) {
    if (size_bytes_ - own_bytes + bytes <= options_.max_bytes) break;
    files_->Unlink(Path(StoreKind::kDerived, digest));
    Forget(StoreKind::kDerived, digest);
  }
  std::sort(idle.begin(), idle.end());
  size_t left = idle.size();
  for (const auto& [use, other] : idle) {
    if (size_bytes_ - own_bytes + bytes <= options_.max_bytes && under_way + left < options_.max_unfinished) break;
    DropUnfinished(other);
    --left;
  }
  return absl::OkStatus();
}

void Store::DropUnfinished(const std::string& name) {
  const auto found = unfinished_.find(name);
  files_->Unlink(IncomingPath(name));
  size_bytes_ -= found->second.bytes;
  unfinished_.erase(found);
}

// Gives back what a writer had that is dropped without a commit.
void Store::Release(Writer& writer) {
  const std::string name = NameInIncoming(writer.kind_, writer.digest_);
  bool is_kept = writer.kind_ == StoreKind::kBlob && !writer.is_worthless_ && writer.file_ >= 0 &&
                 writer.size_bytes_ > 0 && writer.Begin().ok();
  // An append that failed half way left bytes that its digest does not have.
  is_kept = is_kept && files_->Truncate(writer.file_, off_t(writer.size_bytes_)) == 0 &&
            files_->Sync(writer.file_) == 0 && files_->SyncFolder(IncomingPath("")) == 0;
  if (writer.file_ >= 0) files_->Close(writer.file_);
  const std::lock_guard lock(mutex_);
  if (writer.is_replaced_) return;
  if (!is_kept) {
    DropUnfinished(name);
    return;
  }
  Unfinished& unfinished = unfinished_[name];
  size_bytes_ -= unfinished.bytes - writer.size_bytes_;
  unfinished = {writer.size_bytes_, writer.size_bytes_, next_use_++, nullptr};
}

Store::Writer::~Writer() {
  if (store_ != nullptr) store_->Release(*this);
}

absl::Status Store::Writer::Begin() {
  const std::lock_guard lock(store_->mutex_);
  if (is_replaced_) return absl::UnavailableError("another call goes on with this upload");
  is_busy_ = true;
  return absl::OkStatus();
}

void Store::Writer::End() {
  const std::lock_guard lock(store_->mutex_);
  is_busy_ = false;
  used_at_ = std::chrono::steady_clock::now();
}

absl::Status Store::Writer::Sync() {
  if (store_->files_->Sync(file_) != 0) {
    is_worthless_ = true;  // after a failed sync nobody knows what the file holds
    return FileError("syncing an upload");
  }
  const std::lock_guard lock(store_->mutex_);
  synced_bytes_ = size_bytes_;
  store_->unfinished_[NameInIncoming(kind_, digest_)].committed_bytes = size_bytes_;
  return absl::OkStatus();
}

absl::Status Store::Writer::Append(const std::string& bytes) {
  RETURN_IF_ERROR(Begin());
  absl::Status status;
  if (store_->files_->WriteAll(file_, bytes.data(), bytes.size(), off_t(size_bytes_)) != 0) {
    status = FileError("writing to the scene store");
  } else {
    sha_.Add(bytes.data(), bytes.size());
    size_bytes_ += bytes.size();
    if (size_bytes_ - synced_bytes_ >= store_->options_.sync_bytes) status = Sync();
  }
  End();
  return status;
}

absl::Status Store::Writer::Commit() {
  RETURN_IF_ERROR(Begin());
  if (const std::string actual = sha_.FinishHex(); kind_ != StoreKind::kDerived && actual != digest_) {
    is_worthless_ = true;
    return absl::InvalidArgumentError("digest: " + digest_ + "; the bytes have " + actual);
  }
  RETURN_IF_ERROR(Sync());
  FileOperations* files = store_->files_;
  const std::string name = NameInIncoming(kind_, digest_);
  const std::string target = store_->Path(kind_, digest_);
  if (files->Rename(store_->IncomingPath(name), target) != 0) return FileError("renaming an upload");
  if (files->SyncFolder(store_->Folder(kind_)) != 0) {
    absl::Status status = FileError("syncing the scene store");
    files->Unlink(target);
    is_worthless_ = true;
    return status;
  }
  files->Close(file_);
  const std::lock_guard lock(store_->mutex_);
  store_->Forget(kind_, digest_);
  store_->sizes_[int(kind_)][digest_] = size_bytes_;
  if (kind_ == StoreKind::kDerived) store_->derived_uses_[digest_] = store_->next_use_++;
  store_->size_bytes_ -= store_->unfinished_[name].bytes - size_bytes_;
  store_->unfinished_.erase(name);
  store_ = nullptr;  // nothing to give back
  return absl::OkStatus();
}

absl::Status Store::Put(StoreKind kind, const std::string& digest, const std::string& bytes) {
  const auto writer = Write(kind, digest, bytes.size());
  if (absl::IsAlreadyExists(writer.status())) return absl::OkStatus();
  RETURN_IF_ERROR(writer.status());
  RETURN_IF_ERROR((*writer)->Append(bytes));
  return (*writer)->Commit();
}

}  // namespace halfshade
