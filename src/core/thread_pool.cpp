// SPDX-License-Identifier: Apache-2.0
#include "uwv/core/thread_pool.h"

#include <sched.h>

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#include "uwv/core/error.h"

namespace uwv {
namespace {

thread_local bool inside_loop = false;

/// Processors this process may run on, which containers and taskset make fewer than the machine's.
int usable_processors() {
  cpu_set_t set;
  CPU_ZERO(&set);
  if (sched_getaffinity(0, sizeof set, &set) == 0) return std::max(1, CPU_COUNT(&set));
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

}  // namespace

struct ThreadPool::State {
  std::mutex loop_mutex;  // one loop at a time
  std::mutex mutex;
  std::condition_variable work_ready, work_done;
  const std::function<void(int)>* body = nullptr;
  std::atomic<int> next{0};
  int parts = 0;
  int active = 0;           // workers still inside the current loop
  unsigned generation = 0;  // counts loops, so that a worker joins each one once
  bool stop = false;
  std::exception_ptr error;
  std::vector<std::thread> workers;

  void drain() {
    inside_loop = true;
    for (int part; (part = next.fetch_add(1, std::memory_order_relaxed)) < parts;) {
      try {
        (*body)(part);
      } catch (...) {
        const std::lock_guard lock(mutex);
        if (!error) error = std::current_exception();
        next.store(parts, std::memory_order_relaxed);
      }
    }
    inside_loop = false;
  }

  void worker() {
    unsigned seen = 0;
    for (;;) {
      {
        std::unique_lock lock(mutex);
        work_ready.wait(lock, [&] { return stop || generation != seen; });
        if (stop) return;
        seen = generation;
      }
      drain();
      const std::lock_guard lock(mutex);
      if (--active == 0) work_done.notify_one();
    }
  }
};

ThreadPool::ThreadPool(int threads) : state_(std::make_unique<State>()) {
  require(threads >= 0, "a thread pool cannot have {} threads", threads);
  const int count = threads == 0 ? usable_processors() : threads;
  for (int i = 1; i < count; ++i) state_->workers.emplace_back([this] { state_->worker(); });
}

ThreadPool::~ThreadPool() {
  {
    const std::lock_guard lock(state_->mutex);
    state_->stop = true;
  }
  state_->work_ready.notify_all();
  for (std::thread& worker : state_->workers) worker.join();
}

int ThreadPool::size() const { return static_cast<int>(state_->workers.size()) + 1; }

void ThreadPool::run(int parts, const std::function<void(int)>& body) {
  if (parts <= 0) return;
  if (parts == 1 || state_->workers.empty() || inside_loop) {
    for (int part = 0; part < parts; ++part) body(part);
    return;
  }
  const std::lock_guard loop(state_->loop_mutex);
  {
    const std::lock_guard lock(state_->mutex);
    state_->body = &body;
    state_->parts = parts;
    state_->next.store(0, std::memory_order_relaxed);
    state_->active = static_cast<int>(state_->workers.size());
    state_->error = nullptr;
    ++state_->generation;
  }
  state_->work_ready.notify_all();
  state_->drain();
  std::unique_lock lock(state_->mutex);
  state_->work_done.wait(lock, [&] { return state_->active == 0; });
  if (state_->error) std::rethrow_exception(state_->error);
}

void ThreadPool::for_ranges(int begin, int end, int grain, const std::function<void(int, int)>& body) {
  const int count = end - begin;
  if (count <= 0) return;
  // Four ranges a thread even out work that differs from row to row without much overhead.
  const int parts = std::clamp(count / std::max(1, grain), 1, size() * 4);
  run(parts, [&](int part) {
    const auto at = [&](long p) { return begin + static_cast<int>(p * count / parts); };
    body(at(part), at(part + 1));
  });
}

}  // namespace uwv
