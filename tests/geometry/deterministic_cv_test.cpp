// SPDX-License-Identifier: Apache-2.0
#include "geometry/deterministic_cv.h"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <optional>

namespace uwv {
namespace {

class DeterministicCvTest : public testing::Test {
 protected:
  void SetUp() override { cv::setNumThreads(3); }
  void TearDown() override { cv::setNumThreads(before_); }
  const int before_ = cv::getNumThreads();
};

TEST_F(DeterministicCvTest, one_thread_while_it_lives_and_the_same_random_numbers) {
  unsigned first = 0;
  {
    const DeterministicCv deterministic;
    EXPECT_EQ(cv::getNumThreads(), 1);
    first = cv::theRNG().next();
  }
  EXPECT_EQ(cv::getNumThreads(), 3);
  const DeterministicCv deterministic;
  EXPECT_EQ(cv::theRNG().next(), first);
}

TEST_F(DeterministicCvTest, several_may_end_in_any_order) {
  std::optional<DeterministicCv> a, b;
  a.emplace();
  b.emplace();
  a.reset();
  EXPECT_EQ(cv::getNumThreads(), 1);
  b.reset();
  EXPECT_EQ(cv::getNumThreads(), 3);
}

}  // namespace
}  // namespace uwv
