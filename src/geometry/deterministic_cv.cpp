// SPDX-License-Identifier: Apache-2.0
#include "geometry/deterministic_cv.h"

#include <mutex>
#include <opencv2/core.hpp>

namespace uwv {
namespace {

struct Holders {
  std::mutex mutex;
  int count = 0;
  int threads = 0;  ///< OpenCV's, before the first holder came.
};

/// One for the process, as what it guards is.
Holders& holders() {
  static Holders all;
  return all;
}

}  // namespace

DeterministicCv::DeterministicCv() {
  Holders& all = holders();
  const std::lock_guard lock(all.mutex);
  if (all.count++ == 0) {
    all.threads = cv::getNumThreads();
    cv::setNumThreads(1);
  }
  cv::theRNG().state = 0x5eed;
}

DeterministicCv::~DeterministicCv() {
  Holders& all = holders();
  const std::lock_guard lock(all.mutex);
  if (--all.count == 0) cv::setNumThreads(all.threads);
}

}  // namespace uwv
