// Objects that stay on a context between calls, by key: the least recently used go first when their bytes pass a bound,
// but none that somebody holds.
#pragma once

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <list>
#include <map>
#include <memory>
#include <string>
#include <utility>

namespace halfshade::gl {

// `Object` has uint64_t SizeBytes() const. Like the objects, the cache lives on its context's thread. What is held from
// outside (any other copy of the pointer) counts, and may keep the bytes over the bound until the next Keep or Trim.
template <typename Object>
class ObjectCache {
 public:
  using Pointer = std::shared_ptr<Object>;

  explicit ObjectCache(uint64_t max_bytes) : max_bytes_(max_bytes) {}

  // Null if it is not here.
  Pointer Find(const std::string& key) {
    const auto found = by_key_.find(key);
    if (found == by_key_.end()) {
      ++misses_;
      return nullptr;
    }
    ++hits_;
    uses_.splice(uses_.begin(), uses_, found->second);
    return found->second->object;
  }

  // In place of what was there under this key. The object is measured now: keep it again when it has grown.
  void Keep(const std::string& key, Pointer object) {
    if (const auto found = by_key_.find(key); found != by_key_.end()) Drop(found->second);
    const uint64_t bytes = object->SizeBytes() + 2 * key.size();
    uses_.push_front({key, std::move(object), bytes});
    by_key_[key] = uses_.begin();
    bytes_ += bytes;
    Trim();
  }

  // Down to the bound, as far as nobody holds what must go.
  void Trim() { MakeRoom(0); }

  // Down to what leaves room for so many bytes more: before they are made, or both would be there for a while.
  void MakeRoom(uint64_t bytes) {
    const uint64_t most = max_bytes_ - std::min(max_bytes_, bytes);
    for (auto entry = uses_.end(); bytes_ > most && entry != uses_.begin();) {
      --entry;
      if (entry->object.use_count() == 1) entry = Drop(entry);
    }
  }

  // Everything whose key begins with `prefix`.
  void Forget(const std::string& prefix) {
    for (auto next = by_key_.lower_bound(prefix); next != by_key_.end() && next->first.starts_with(prefix);) {
      const auto entry = (next++)->second;
      Drop(entry);
    }
  }

  // As if newly made.
  void Clear() {
    Forget("");
    hits_ = misses_ = 0;
  }

  uint64_t max_bytes() const { return max_bytes_; }
  uint64_t bytes() const { return bytes_; }
  uint64_t hits() const { return hits_; }
  uint64_t misses() const { return misses_; }

 private:
  struct Entry {
    std::string key;
    Pointer object;
    uint64_t bytes = 0;
  };
  using Position = typename std::list<Entry>::iterator;

  Position Drop(Position entry) {
    bytes_ -= entry->bytes;
    by_key_.erase(entry->key);
    return uses_.erase(entry);
  }

  const uint64_t max_bytes_;
  std::list<Entry> uses_;  // most recent first
  std::map<std::string, Position> by_key_;
  uint64_t bytes_ = 0, hits_ = 0, misses_ = 0;
};

}  // namespace halfshade::gl
