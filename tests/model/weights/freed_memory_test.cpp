// SPDX-License-Identifier: Apache-2.0
#include "model/weights/freed_memory.h"

#include <gtest/gtest.h>

#include "model/measured_peak.h"

namespace uwv::model {
namespace {

using uwv::testing::FreedBetweenUsed;
using uwv::testing::resident_memory;

TEST(FreedMemory, IsGivenBackBetweenBlocksInUse) {
  if (!uwv::testing::peaks_can_be_measured()) GTEST_SKIP() << "memory cannot be measured here";
  constexpr std::size_t bytes = 128 << 20;
  const double before = resident_memory();
  const FreedBetweenUsed gaps(bytes);
  const double kept = resident_memory();
  EXPECT_GT(kept - before, 1.8 * bytes) << "the allocator gave it back by itself";
  give_back_freed_memory();
  EXPECT_LT(resident_memory(), kept - 0.8 * bytes);
}

}  // namespace
}  // namespace uwv::model
