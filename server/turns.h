// Fair queues: each principal has one of its own, and they take turns, so that one who asks for much delays another by
// one piece of its own at a time, not by all of it. Not thread-safe.
#pragma once

#include <algorithm>
#include <cstddef>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <utility>

namespace halfshade {

template <typename Item>
class Turns {
 public:
  using Queue = std::deque<Item>;

  bool empty() const { return turns_.empty(); }
  size_t size() const { return size_; }
  size_t CountOf(const std::string& principal) const {
    const auto found = queues_.find(principal);
    return found == queues_.end() ? 0 : found->second.size();
  }
  const std::map<std::string, Queue>& queues() const { return queues_; }  // none is empty

  void Push(const std::string& principal, Item item) {
    Queue& queue = queues_[principal];
    if (queue.empty()) turns_.push_back(principal);
    queue.push_back(std::move(item));
    ++size_;
  }

  // Of the principal whose turn it is the item that `choose` takes by its index in the queue; there must be one.
  template <typename Choose>
  Item Take(Choose choose) {
    const std::string principal = std::move(turns_.front());
    turns_.pop_front();
    Queue& queue = queues_.at(principal);
    Item item = Erase(queue, choose(queue));
    if (queue.empty()) {
      queues_.erase(principal);
    } else {
      turns_.push_back(principal);
    }
    return item;
  }
  Item Take() {
    return Take([](const Queue&) { return size_t(0); });
  }

  // The first item that `is_it` is true of, whoever's it is.
  template <typename IsIt>
  std::optional<Item> Remove(IsIt is_it) {
    for (auto& [principal, queue] : queues_) {
      const auto found = std::find_if(queue.begin(), queue.end(), is_it);
      if (found != queue.end()) return RemoveAt(principal, size_t(found - queue.begin()));
    }
    return std::nullopt;
  }

  Item RemoveNewest(const std::string& principal) { return RemoveAt(principal, queues_.at(principal).size() - 1); }

 private:
  Item RemoveAt(const std::string& principal, size_t index) {
    const auto found = queues_.find(principal);
    Item item = Erase(found->second, index);
    if (found->second.empty()) {
      turns_.erase(std::find(turns_.begin(), turns_.end(), principal));
      queues_.erase(found);
    }
    return item;
  }
  Item Erase(Queue& queue, size_t index) {
    Item item = std::move(queue[index]);
    queue.erase(queue.begin() + std::ptrdiff_t(index));
    --size_;
    return item;
  }

  std::map<std::string, Queue> queues_;  // of those who wait; none is empty
  std::deque<std::string> turns_;        // keys of queues_, the next one first
  size_t size_ = 0;
};

}  // namespace halfshade
