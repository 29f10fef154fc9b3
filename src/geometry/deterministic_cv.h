// SPDX-License-Identifier: Apache-2.0
// OpenCV made deterministic while something lives.
#pragma once

namespace uwv {

/// Some of OpenCV's algorithms (DIS flow above all) give results that depend on the number of its threads, and random
/// ones start from a generator per thread. While this lives, OpenCV uses the calling thread only, from a fixed seed;
/// other threads come from our pool. OpenCV's number of threads belongs to the process: the last of several that live
/// at once, in whatever order they end, gives back the number the first one found.
class DeterministicCv {
 public:
  DeterministicCv();
  ~DeterministicCv();
  DeterministicCv(const DeterministicCv&) = delete;
  DeterministicCv& operator=(const DeterministicCv&) = delete;
};

}  // namespace uwv
