// Rendered replies by content key: what was rendered before is not rendered again, and identical requests under way are
// one. Thread-safe.
//
// Of calls with one key the first leads: it draws, and then publishes or abandons. Those that come meanwhile wait.
// Where the leader gives up, the one that waits longest leads in its place.
#pragma once

#include <cstdint>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "halfshade/v1/render.pb.h"

namespace halfshade {

class ResultCache {
 public:
  using Reply = std::shared_ptr<const v1::RenderResponse>;
  // Called once, without a lock of the cache: the reply of another, or null: lead.
  using OnReply = std::function<void(Reply)>;

  // Bound of the replies kept, least recently used go first; 0 keeps none. Identical requests under way are one all the
  // same.
  explicit ResultCache(uint64_t max_bytes) : max_bytes_(max_bytes) {}

  // True: lead. False: `on_reply` is called, now or later, unless `waiter` withdraws before.
  bool Lead(const std::string& key, uint64_t waiter, OnReply on_reply);
  void Withdraw(const std::string& key, uint64_t waiter);
  // Whether others wait for the leader of the key.
  bool IsAwaited(const std::string& key) const;
  // Whether a reply of so many bytes is wanted by Publish, for the next or by those that wait: else null will do there.
  bool Wants(const std::string& key, uint64_t bytes) const;

  // The leader ends. Without a reply the next leads.
  void Publish(const std::string& key, Reply reply);
  void Abandon(const std::string& key) { Publish(key, nullptr); }

  struct Counters {
    uint64_t hits = 0;  // those that waited included
    uint64_t misses = 0;
    uint64_t bytes = 0;
  };
  Counters counters() const;

 private:
  struct Waiter {
    uint64_t id = 0;
    OnReply on_reply;
  };
  struct Kept {
    Reply reply;
    uint64_t bytes = 0;
    std::list<std::string>::iterator use;
  };
  void Keep(const std::string& key, const Reply& reply);  // under mutex_

  const uint64_t max_bytes_;
  mutable std::mutex mutex_;
  std::map<std::string, std::list<Waiter>> under_way_;  // in the order they came
  std::map<std::string, Kept> kept_;
  std::list<std::string> uses_;  // most recent first
  Counters counters_;
};

}  // namespace halfshade
