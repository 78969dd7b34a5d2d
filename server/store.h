// Blobs and scene manifests on disk, content-addressed: the key's hex is the SHA-256 of the bytes.
//
// A value is written to a temporary file, synced and renamed: it is whole under its key or not there, whatever dies
// when. What is read is checked against its key. Thread-safe.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "server/digest.h"

namespace halfshade {

enum class StoreKind { kBlob, kScene };

class Store {
 public:
  // Opens, or makes, the folder; removes what a crash left half written. An empty `directory` is a private temporary
  // folder, removed by the destructor. FAILED_PRECONDITION with the reason.
  static absl::StatusOr<std::unique_ptr<Store>> Open(const std::string& directory, uint64_t max_bytes);
  ~Store();

  // A value under way. Dropped without Commit it leaves nothing behind.
  class Writer {
   public:
    ~Writer();
    absl::Status Append(const std::string& bytes);
    // INVALID_ARGUMENT "digest: ..." if the bytes are others. The value is on disk when this returns OK.
    absl::Status Commit();
    uint64_t size_bytes() const { return size_bytes_; }

   private:
    friend class Store;
    Writer() = default;
    Store* store_ = nullptr;
    StoreKind kind_ = StoreKind::kBlob;
    std::string digest_;
    std::string path_;
    int file_ = -1;
    uint64_t size_bytes_ = 0;
    Sha256 sha_;
  };

  // RESOURCE_EXHAUSTED with the numbers if size_bytes more do not fit.
  absl::StatusOr<std::unique_ptr<Writer>> Write(StoreKind kind, const std::string& digest, uint64_t size_bytes);
  absl::Status Put(StoreKind kind, const std::string& digest, const std::string& bytes);

  bool Has(StoreKind kind, const std::string& digest) const;
  // NOT_FOUND; DATA_LOSS if the file does not fit its key (it is then removed).
  absl::StatusOr<std::string> Get(StoreKind kind, const std::string& digest);
  void Remove(StoreKind kind, const std::string& digest);
  // Digests in order.
  std::vector<std::string> List(StoreKind kind) const;
  uint64_t size_bytes() const;

 private:
  Store() = default;
  std::string Path(StoreKind kind, const std::string& digest) const;
  absl::Status Scan();

  std::string directory_;
  bool is_temporary_ = false;
  uint64_t max_bytes_ = 0;
  mutable std::mutex mutex_;
  std::map<std::string, uint64_t> sizes_[2];  // digest -> bytes, by kind
  uint64_t size_bytes_ = 0;
  uint64_t next_temporary_ = 0;
};

}  // namespace halfshade
