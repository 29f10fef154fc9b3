// SPDX-License-Identifier: Apache-2.0
// A small pool of worker threads for loops of a few milliseconds.
#pragma once

#include <functional>
#include <memory>

namespace uwv {

/// Runs loops on a fixed number of threads, the calling one included. One pool may be shared by everything a program
/// does; only one loop runs at a time, others wait. A loop started from inside a loop runs on the calling thread alone.
class ThreadPool {
 public:
  /// `threads` >= 1; 0 means one per processor the system lets us use.
  explicit ThreadPool(int threads = 0);
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  int size() const;

  /// Calls body(part) for part = 0 .. parts-1, each exactly once, in any order and on any thread, and returns when all
  /// are done. The first exception thrown by a body is rethrown here after the others have ended.
  void run(int parts, const std::function<void(int part)>& body);

  /// Splits [begin, end) into contiguous ranges, a few per thread, of at least `grain` items, and calls body(from, to).
  void for_ranges(int begin, int end, int grain, const std::function<void(int from, int to)>& body);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace uwv
