// SPDX-License-Identifier: Apache-2.0
#include "uwv/core/thread_pool.h"

#include <gtest/gtest.h>
#include <sched.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <limits>
#include <mutex>
#include <numeric>
#include <set>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace uwv {
namespace {

class ThreadPoolOf : public testing::TestWithParam<int> {
 protected:
  ThreadPool pool_{GetParam()};
};
INSTANTIATE_TEST_SUITE_P(Threads, ThreadPoolOf, testing::Values(1, 2, 3, 8));

TEST_P(ThreadPoolOf, HasTheThreadsAskedFor) { EXPECT_EQ(pool_.size(), GetParam()); }

TEST_P(ThreadPoolOf, RunsEachPartExactlyOnce) {
  for (const int parts : {0, 1, 2, 7, 1000}) {
    std::vector<std::atomic<int>> calls(static_cast<std::size_t>(parts));
    pool_.run(parts, [&](int part) { ++calls.at(static_cast<std::size_t>(part)); });
    for (std::size_t part = 0; part < calls.size(); ++part) EXPECT_EQ(calls[part], 1) << part << " of " << parts;
  }
}

TEST_P(ThreadPoolOf, NegativeNumberOfPartsIsNoWork) {
  pool_.run(-5, [](int) { FAIL(); });
  pool_.for_ranges(5, 2, 1, [](int, int) { FAIL(); });
}

TEST_P(ThreadPoolOf, WhatBodiesWroteIsVisibleAfterwards) {
  std::vector<int> plain(10000);  // not atomic: ThreadSanitizer or a wrong sum would tell
  pool_.run(10000, [&](int part) { plain[static_cast<std::size_t>(part)] = part; });
  EXPECT_EQ(std::accumulate(plain.begin(), plain.end(), 0L), 10000L * 9999 / 2);
}

TEST_P(ThreadPoolOf, RethrowsAndStaysUsable) {
  for (int round = 0; round < 50; ++round) {
    try {
      pool_.run(100, [](int part) {
        if (part == 37) throw std::runtime_error("part 37");
      });
      FAIL() << "the exception got lost";
    } catch (const std::runtime_error& error) {
      ASSERT_STREQ(error.what(), "part 37");
    }
    std::atomic<int> calls = 0;
    ASSERT_NO_THROW(pool_.run(100, [&](int) { ++calls; })) << "an old exception came back";
    ASSERT_EQ(calls, 100);
  }
}

TEST_P(ThreadPoolOf, NoBodyRunsOnAfterAnException) {
  std::atomic<int> running = 0;
  const auto body = [&](int part) {
    ++running;
    std::this_thread::sleep_for(std::chrono::milliseconds(part == 0 ? 0 : 20));
    --running;
    if (part == 0) throw std::runtime_error("early");
  };
  EXPECT_THROW(pool_.run(16, body), std::runtime_error);
  EXPECT_EQ(running, 0);
}

TEST_P(ThreadPoolOf, WhenAllThrowOneArrives) {
  EXPECT_THROW(pool_.run(64, [](int part) { throw std::out_of_range(std::to_string(part)); }), std::out_of_range);
}

TEST_P(ThreadPoolOf, NestedLoopRunsOnItsOwnThread) {
  std::atomic<int> inner_calls = 0;
  std::atomic<bool> moved = false;
  pool_.run(16, [&](int) {
    const auto outer = std::this_thread::get_id();
    pool_.run(16, [&](int) {
      ++inner_calls;
      if (pool_.size() > 1 && std::this_thread::get_id() != outer) moved = true;
    });
  });
  EXPECT_EQ(inner_calls, 256);
  EXPECT_FALSE(moved);
}

TEST_P(ThreadPoolOf, NestedLoopOnAnotherPoolEnds) {
  ThreadPool other(2);
  std::atomic<int> calls = 0;
  pool_.run(8, [&](int) { other.run(8, [&](int) { ++calls; }); });
  EXPECT_EQ(calls, 64);
}

TEST_P(ThreadPoolOf, ExceptionOfANestedLoopComesOut) {
  EXPECT_THROW(pool_.run(4, [&](int) { pool_.run(4, [](int) { throw std::runtime_error("inner"); }); }),
               std::runtime_error);
  // A thread that forgot it has left the loop would run everything alone from here on; counting still has to hold.
  std::atomic<int> calls = 0;
  pool_.run(100, [&](int) { ++calls; });
  EXPECT_EQ(calls, 100);
}

TEST_P(ThreadPoolOf, ManyShortLoops) {
  constexpr int loops = 5000;
  long total = 0;
  for (int loop = 0; loop < loops; ++loop) {
    std::atomic<int> sum = 0;
    pool_.run(4, [&](int part) { sum += part; });
    total += sum;
  }
  EXPECT_EQ(total, 6L * loops);
}

TEST_P(ThreadPoolOf, SeveralCallersTakeTurns) {
  std::atomic<int> calls = 0;
  std::vector<std::thread> callers;
  for (int caller = 0; caller < 4; ++caller)
    callers.emplace_back([&] {
      for (int loop = 0; loop < 100; ++loop) pool_.run(5, [&](int) { ++calls; });
    });
  for (std::thread& caller : callers) caller.join();
  EXPECT_EQ(calls, 4 * 100 * 5);
}

TEST_P(ThreadPoolOf, RangesTileTheInterval) {
  const std::pair<int, int> intervals[] = {{0, 1}, {0, 1000}, {-37, 5}, {7, 8}, {0, 2'000'000'000}};
  for (const auto& [begin, end] : intervals) {
    for (const int grain : {1, 10, 100000, 0}) {
      std::mutex mutex;
      std::vector<std::pair<int, int>> ranges;
      pool_.for_ranges(begin, end, grain, [&](int from, int to) {
        const std::lock_guard lock(mutex);
        ranges.emplace_back(from, to);
      });
      std::sort(ranges.begin(), ranges.end());
      int reached = begin;
      for (const auto& [from, to] : ranges) {
        EXPECT_EQ(from, reached);
        EXPECT_LT(from, to) << "no range is empty";
        if (ranges.size() > 1) {
          EXPECT_GE(to - from, grain);
        }
        reached = to;
      }
      EXPECT_EQ(reached, end);
      EXPECT_LE(ranges.size(), static_cast<std::size_t>(4 * pool_.size()));
    }
  }
}

TEST(ThreadPool, WorkIsShared) {
  // With two threads both are needed to get past a rendezvous; one alone would wait until the deadline.
  ThreadPool pool(2);
  std::atomic<int> arrived = 0;
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  pool.run(2, [&](int) {
    ++arrived;
    while (arrived < 2 && std::chrono::steady_clock::now() < deadline) std::this_thread::yield();
  });
  EXPECT_LT(std::chrono::steady_clock::now(), deadline);
}

TEST(ThreadPool, NegativeCountIsRefused) { EXPECT_THROW(ThreadPool(-1), std::invalid_argument); }

TEST(ThreadPool, DefaultIsTheProcessorsWeMayUse) {
  cpu_set_t all, one;
  CPU_ZERO(&all);
  ASSERT_EQ(sched_getaffinity(0, sizeof all, &all), 0);
  EXPECT_EQ(ThreadPool().size(), CPU_COUNT(&all));
  int first = 0;
  while (!CPU_ISSET(first, &all)) ++first;
  CPU_ZERO(&one);
  CPU_SET(first, &one);
  ASSERT_EQ(sched_setaffinity(0, sizeof one, &one), 0);
  const int restricted = ThreadPool().size();
  ASSERT_EQ(sched_setaffinity(0, sizeof all, &all), 0);
  EXPECT_EQ(restricted, 1);
}

TEST(ThreadPool, EndsAtOnceWhenUnused) {
  for (int i = 0; i < 200; ++i) const ThreadPool pool(4);
}

}  // namespace
}  // namespace uwv
