// SPDX-License-Identifier: Apache-2.0
// The most memory the process holds during some work, to compare estimates with.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#ifdef __GLIBC__
#include <malloc.h>
#endif

#include <cmath>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include "model/tensor_support.h"
#include "model/weights/freed_memory.h"
#include "uwv/core/peak_memory.h"

namespace uwv::testing {

/// Under a sanitizer memory is the sanitizer's, and where peaks cannot be counted anew it is another test's.
inline bool peaks_can_be_measured() {
#ifdef __SANITIZE_ADDRESS__
  return false;
#else
  model::give_back_freed_memory();
  constexpr std::size_t bytes = 64 << 20;
  { std::vector<char>(bytes, 1); }
  const std::uint64_t before = peak_memory();
  restart_peak_memory();
  return peak_memory() + bytes / 2 < before;
#endif
}

/// Bytes, libraries included. The gaps that the allocator leaves between tensors, which depend on what ran before, are
/// not: each large tensor gets pages of its own.
template <class Work>
double measured_peak(Work work) {
#ifdef __GLIBC__
  mallopt(M_MMAP_THRESHOLD, 1 << 20);
#endif
  model::give_back_freed_memory();
  restart_peak_memory();
  work();
  return static_cast<double>(peak_memory());
}

/// Bytes of the process in memory now; 0 where the system does not tell.
inline double resident_memory() {
  std::ifstream file("/proc/self/statm");
  double all = 0, resident = 0;
  file >> all >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE));
}

/// Memory that is free again but lies between blocks in use, where the allocator keeps it: what a stage of many tensors
/// leaves behind.
class FreedBetweenUsed {
 public:
  explicit FreedBetweenUsed(std::size_t bytes) {
    constexpr std::size_t block = 64 << 10;  // of the heap, whatever the threshold for pages of their own
    std::vector<std::vector<char>> all(2 * bytes / block);
    for (auto& one : all) one.assign(block, 1);
    for (std::size_t i = 0; i < all.size(); i += 2) used_.push_back(std::move(all[i]));
  }

 private:
  std::vector<std::vector<char>> used_;
};

/// Holds an estimate to within `share` of what was measured; both in the message.
inline ::testing::AssertionResult estimates(double estimate, double measured, double share) {
  if (std::abs(estimate - measured) <= share * measured) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << "estimated " << estimate / 1e6 << " MB, measured " << measured / 1e6
                                       << " MB (" << measured / estimate << " times)";
}

/// Random tensors of these shapes in one file, each row adding up to numbers of order one.
inline void write_random_weights(const std::string& path, const model::TensorShapes& shapes, at::ScalarType type) {
  std::map<std::string, at::Tensor> tensors;
  for (const auto& [name, shape] : shapes) {
    double reads = 1;
    for (std::size_t i = 1; i < shape.size(); ++i) reads *= static_cast<double>(shape[i]);
    tensors[name] = ((at::rand(shape) - 0.5) * std::sqrt(12 / reads)).to(type);
  }
  write_safetensors(path, tensors);
}

}  // namespace uwv::testing
