// SPDX-License-Identifier: Apache-2.0
// Work for two threads, row by row.
#pragma once

#include <algorithm>
#include <atomic>

namespace uwv::detail {

/// Rows that two threads draw, one from the top and one from the bottom, until they meet: each has as many as it gets
/// done, and what each has is in one piece.
class SharedRows {
 public:
  SharedRows(int from, int to) : from_(from), to_(to), chunks_left_((to - from + chunk - 1) / chunk) {}
  // Only so that a vector can hold them; not while threads are at work.
  SharedRows(const SharedRows& other) : SharedRows(other.from_, other.to_) {}

  template <class Body>
  void for_rows(bool from_top, const Body& body) {
    for (int taken = 0; chunks_left_.fetch_sub(1, std::memory_order_relaxed) > 0; ++taken) {
      const int chunks = (to_ - from_ + chunk - 1) / chunk;
      const int first = from_ + (from_top ? taken : chunks - 1 - taken) * chunk;
      for (int y = first; y < std::min(first + chunk, to_); ++y) body(y);
    }
  }

 private:
  static constexpr int chunk = 8;
  int from_, to_;
  std::atomic<int> chunks_left_;
};

}  // namespace uwv::detail
