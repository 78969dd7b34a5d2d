// Blobs and scene manifests on disk, content-addressed: the key's hex is the SHA-256 of the bytes. And what is derived
// of them (flat scenes, light data), under any key of that form: what comes back of it is checked by whoever made it,
// and it is what gives way: it takes what room the rest leaves, and where room is needed it goes first, the longest
// untouched before the rest.
//
// A value is written to a file in incoming/, synced, renamed, and its folder synced: it is whole under its key or not
// there, whatever dies when. What is read is checked against its key. A blob that is not whole yet stays in incoming/
// under its digest when its writer is dropped or the process is killed, and any later writer may go on with it.
// Unfinished blobs count against the bound; where room is needed, the longest untouched go first.
// Thread-safe. Write, Get, Remove and the writers block on the disk; the rest does not.
#pragma once

#include <absl/status/statusor.h>

#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "server/digest.h"
#include "server/file_operations.h"

namespace halfshade {

enum class StoreKind { kBlob, kScene, kDerived };
inline constexpr int kStoreKinds = 3;

struct StoreOptions {
  uint64_t max_bytes = 0;         // of all values and unfinished blobs together
  uint32_t max_unfinished = 256;  // unfinished blobs, so that tiny ones do not fill the folder
  uint64_t sync_bytes = 8 << 20;  // what a power cut may cost of an upload; each sync waits for the disk
  // A writer that took no bytes for this long yields to another one of the same value: its client may be gone without
  // a word.
  std::chrono::milliseconds yield_after = std::chrono::seconds(10);
  FileOperations* files = SystemFiles();  // outlives the store
};

class Store {
 public:
  // Opens, or makes, the folder, for this process alone. An empty `directory` is a private temporary folder, removed by
  // the destructor. FAILED_PRECONDITION with the reason.
  static absl::StatusOr<std::unique_ptr<Store>> Open(const std::string& directory, const StoreOptions& options);
  ~Store();

  // A value under way; one thread at a time. Dropped without Commit, a blob stays unfinished with every byte that
  // Append took; anything else leaves nothing behind.
  class Writer {
   public:
    ~Writer();
    // RESOURCE_EXHAUSTED when the disk is full; UNAVAILABLE when another writer took over; INTERNAL.
    absl::Status Append(const std::string& bytes);
    // INVALID_ARGUMENT "digest: ..." if the bytes are others; none of them are kept then. The value is on disk when
    // this returns OK, and invisible when it does not.
    absl::Status Commit();

   private:
    friend class Store;
    Writer() = default;
    absl::Status Begin();  // takes the value, or UNAVAILABLE
    void End();
    absl::Status Sync();

    Store* store_ = nullptr;
    StoreKind kind_ = StoreKind::kBlob;
    std::string digest_;
    int file_ = -1;
    uint64_t size_bytes_ = 0;  // so far
    Sha256 sha_;
    bool is_worthless_ = false;  // its bytes are not to be kept
    // Under the store's mutex.
    uint64_t synced_bytes_ = 0;
    bool is_busy_ = true;
    bool is_replaced_ = false;
    std::chrono::steady_clock::time_point used_at_;
  };

  // Begins a value of `size_bytes`, or goes on with an unfinished blob from `offset_bytes` on: what is unfinished
  // beyond that is dropped, so 0 starts over. INVALID_ARGUMENT: an offset that leaves a gap, a value that is larger
  // than the bound. ALREADY_EXISTS: it is here. RESOURCE_EXHAUSTED with the numbers: no room; with push-back where room
  // may come (status.h), as when another writer has the value.
  absl::StatusOr<std::unique_ptr<Writer>> Write(StoreKind kind, const std::string& digest, uint64_t size_bytes,
                                                uint64_t offset_bytes = 0);
  // Also OK if it is here; what is derived takes the place of what is.
  absl::Status Put(StoreKind kind, const std::string& digest, const std::string& bytes);

  struct Progress {
    uint64_t committed_bytes = 0;  // synced
    bool is_complete = false;
  };
  Progress Query(const std::string& blob_digest) const;

  bool Has(StoreKind kind, const std::string& digest) const;
  // Bytes of the value, 0 if it is not here.
  uint64_t SizeOf(StoreKind kind, const std::string& digest) const;
  // Reads no more than the value's size. NOT_FOUND; DATA_LOSS if the bytes do not fit the key, or of what
  // is derived its size (the file is removed).
  absl::StatusOr<std::string> Get(StoreKind kind, const std::string& digest);
  // Those that are here. INTERNAL: some are still here, or may be back after a power cut.
  absl::Status Remove(StoreKind kind, const std::vector<std::string>& digests);
  // Digests in order.
  std::vector<std::string> List(StoreKind kind) const;
  // What the bound is compared to.
  uint64_t size_bytes() const;

 private:
  // A file in incoming/.
  struct Unfinished {
    uint64_t bytes = 0;            // what it counts: announced while a writer has it, else held
    uint64_t committed_bytes = 0;  // synced
    uint64_t last_use = 0;         // larger is later
    Writer* writer = nullptr;
  };

  Store() = default;
  std::string Folder(StoreKind kind) const;
  std::string Path(StoreKind kind, const std::string& digest) const;
  std::string IncomingPath(const std::string& name) const;
  absl::Status Lock();
  absl::Status Scan();
  absl::Status ScanIncoming();
  absl::Status OpenIncoming(Writer& writer);
  void Discard(StoreKind kind, const std::string& digest, uint64_t inode);
  void Release(Writer& writer);
  // Under mutex_.
  absl::Status MakeRoom(StoreKind kind, const std::string& name, uint64_t bytes);
  void Forget(StoreKind kind, const std::string& digest);  // what is here; not its file
  void DropUnfinished(const std::string& name);

  std::string directory_;
  bool is_temporary_ = false;
  StoreOptions options_;
  FileOperations* files_ = nullptr;
  int lock_file_ = -1;
  mutable std::mutex mutex_;
  std::map<std::string, uint64_t> sizes_[kStoreKinds];  // digest -> bytes, by kind
  std::map<std::string, Unfinished> unfinished_;        // by name in incoming/
  std::map<std::string, uint64_t> derived_uses_;        // digest -> last use, larger is later
  uint64_t size_bytes_ = 0;                             // of all
  uint64_t next_use_ = 0;
};

}  // namespace halfshade
