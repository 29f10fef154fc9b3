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

void pause_processor() {
#if defined(__x86_64__)
  __builtin_ia32_pause();
#endif
}

/// The loops of one frame follow each other within microseconds, and waking a sleeping thread takes as long as a short
/// loop: look a moment before sleeping.
template <class Condition>
void spin_until(const Condition& condition) {
  for (int i = 0; i < 1000 && !condition(); ++i) pause_processor();
}

}  // namespace

struct ThreadPool::State {
  std::mutex loop_mutex;  // one loop at a time
  std::mutex mutex;       // guards everything below that is not atomic
  std::condition_variable work_ready, work_done;
  const std::function<void(int)>* body = nullptr;
  std::atomic<int> next{0};
  int parts = 0;
  bool open = false;                    // workers may still join the current loop
  std::atomic<int> inside{0};           // workers in the current loop
  std::atomic<unsigned> generation{0};  // counts loops, so that a worker joins each one at most once
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

  /// Waits for a loop not seen yet and joins it. False when the pool is closing.
  bool join(unsigned& seen) {
    spin_until([&] { return generation.load(std::memory_order_relaxed) != seen; });
    std::unique_lock lock(mutex);
    // A loop that ended before this worker woke up is not waited for by anybody.
    work_ready.wait(lock, [&] { return stop || (open && generation.load(std::memory_order_relaxed) != seen); });
    seen = generation.load(std::memory_order_relaxed);
    if (!stop) inside.fetch_add(1, std::memory_order_relaxed);
    return !stop;
  }

  void worker() {
    for (unsigned seen = 0; join(seen);) {
      drain();
      const std::lock_guard lock(mutex);
      if (inside.fetch_sub(1, std::memory_order_release) == 1) work_done.notify_one();
    }
  }

  void open_loop(int count, const std::function<void(int)>& work) {
    const std::lock_guard lock(mutex);
    body = &work;
    parts = count;
    next.store(0, std::memory_order_relaxed);
    error = nullptr;
    open = true;
    generation.fetch_add(1, std::memory_order_relaxed);
  }

  /// Waits for the workers that joined; those that did not are too late.
  void close_loop() {
    {
      const std::lock_guard lock(mutex);
      open = false;
    }
    spin_until([&] { return inside.load(std::memory_order_relaxed) == 0; });
    std::unique_lock lock(mutex);
    work_done.wait(lock, [&] { return inside.load(std::memory_order_acquire) == 0; });
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
  state_->open_loop(parts, body);
  state_->work_ready.notify_all();
  state_->drain();
  state_->close_loop();
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
