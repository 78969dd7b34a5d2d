#include "server/result_cache.h"

#include <utility>

namespace halfshade {

bool ResultCache::Lead(const std::string& key, uint64_t waiter, OnReply on_reply) {
  Reply reply;
  {
    const std::lock_guard lock(mutex_);
    if (const auto kept = kept_.find(key); kept != kept_.end()) {
      ++counters_.hits;
      uses_.splice(uses_.begin(), uses_, kept->second.use);
      reply = kept->second.reply;
    } else if (const auto [waiters, is_first] = under_way_.try_emplace(key); is_first) {
      ++counters_.misses;
      return true;
    } else {
      waiters->second.push_back({waiter, std::move(on_reply)});
      return false;
    }
  }
  on_reply(std::move(reply));
  return false;
}

void ResultCache::Withdraw(const std::string& key, uint64_t waiter) {
  const std::lock_guard lock(mutex_);
  const auto waiters = under_way_.find(key);
  if (waiters == under_way_.end()) return;
  waiters->second.remove_if([waiter](const Waiter& one) { return one.id == waiter; });
}

bool ResultCache::IsAwaited(const std::string& key) const {
  const std::lock_guard lock(mutex_);
  const auto waiters = under_way_.find(key);
  return waiters != under_way_.end() && !waiters->second.empty();
}

bool ResultCache::Wants(const std::string& key, uint64_t bytes) const { return bytes <= max_bytes_ || IsAwaited(key); }

void ResultCache::Publish(const std::string& key, Reply reply) {
  std::list<Waiter> told;
  {
    const std::lock_guard lock(mutex_);
    const auto waiters = under_way_.find(key);
    if (waiters == under_way_.end()) return;
    if (reply != nullptr) {
      counters_.hits += waiters->second.size();
      told.swap(waiters->second);
      Keep(key, reply);
    } else if (!waiters->second.empty()) {
      ++counters_.misses;
      told.splice(told.begin(), waiters->second, waiters->second.begin());
    }
    if (reply != nullptr || told.empty()) under_way_.erase(waiters);
  }
  for (const Waiter& waiter : told) waiter.on_reply(reply);
}

void ResultCache::Keep(const std::string& key, const Reply& reply) {
  const uint64_t bytes = reply->ByteSizeLong() + key.size();
  if (bytes > max_bytes_ || kept_.contains(key)) return;
  while (counters_.bytes + bytes > max_bytes_) {
    const auto last = kept_.find(uses_.back());
    counters_.bytes -= last->second.bytes;
    kept_.erase(last);
    uses_.pop_back();
  }
  uses_.push_front(key);
  kept_[key] = {reply, bytes, uses_.begin()};
  counters_.bytes += bytes;
}

ResultCache::Counters ResultCache::counters() const {
  const std::lock_guard lock(mutex_);
  return counters_;
}

}  // namespace halfshade
