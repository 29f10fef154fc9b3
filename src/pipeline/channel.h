// SPDX-License-Identifier: Apache-2.0
// A bounded queue between two threads: what keeps decoding, rendering and encoding going at the same time without
// letting any of them run ahead and fill the memory.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <mutex>
#include <optional>
#include <utility>

namespace uwv::pipeline {

template <class T>
class Channel {
 public:
  /// Holds at most `capacity` items.
  explicit Channel(std::size_t capacity) : capacity_(capacity) {}

  /// Waits for room. False, and the item is dropped, once the channel is closed.
  bool push(T item) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return closed_ || items_.size() < capacity_; });
    if (closed_) return false;
    items_.push_back(std::move(item));
    changed_.notify_all();
    return true;
  }

  /// Waits for an item. Nothing once the channel is closed and empty.
  std::optional<T> pop() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return closed_ || !items_.empty(); });
    if (items_.empty()) return std::nullopt;
    std::optional<T> item(std::move(items_.front()));
    items_.pop_front();
    changed_.notify_all();
    return item;
  }

  /// No more items: the sender is through, or the receiver has given up. Wakes both.
  void close() {
    const std::lock_guard lock(mutex_);
    closed_ = true;
    changed_.notify_all();
  }

 private:
  const std::size_t capacity_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<T> items_;
  bool closed_ = false;
};

/// Closes a channel when the scope is left, by whichever way.
template <class T>
class ChannelCloser {
 public:
  explicit ChannelCloser(Channel<T>& channel) : channel_(channel) {}
  ~ChannelCloser() { channel_.close(); }
  ChannelCloser(const ChannelCloser&) = delete;
  ChannelCloser& operator=(const ChannelCloser&) = delete;

 private:
  Channel<T>& channel_;
};

}  // namespace uwv::pipeline
