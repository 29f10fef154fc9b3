// SPDX-License-Identifier: Apache-2.0
#include "uwv/io/resize_policy.h"

#include <gtest/gtest.h>

#include <ostream>

namespace uwv {

void PrintTo(const Size& size, std::ostream* out) { *out << size.width << "x" << size.height; }

namespace {

struct Vector {
  Size source, wanted;
};

// Section 2 of the sheet on the official code.
constexpr Vector official[] = {
    {{1920, 1080}, {848, 480}}, {{1280, 720}, {848, 480}},   {{1024, 576}, {848, 480}}, {{832, 480}, {832, 480}},
    {{640, 480}, {736, 544}},   {{1024, 1024}, {624, 624}},  {{720, 1280}, {480, 832}}, {{1080, 1920}, {480, 832}},
    {{2560, 1080}, {976, 416}}, {{3840, 1080}, {1024, 288}},
};

TEST(TargetSize, official_vectors) {
  for (const auto& [source, wanted] : official)
    EXPECT_EQ(target_size(source, {}), wanted) << "source " << source.width << "x" << source.height;
}

TEST(TargetSize, any_source_gives_whole_tokens_within_max_side) {
  for (int width = 1; width < 5000; width = width * 3 / 2 + 1)
    for (int height = 1; height < 5000; height = height * 4 / 3 + 1) {
      const Size size = target_size({width, height}, {});
      ASSERT_EQ(size.width % token_side + size.height % token_side, 0) << width << "x" << height;
      ASSERT_GE(std::min(size.width, size.height), token_side) << width << "x" << height;
      ASSERT_LE(std::max(size.width, size.height), 1024) << width << "x" << height;
    }
}

TEST(TargetSize, exact_and_none_do_what_they_say) {
  ResizePolicy policy;
  policy.mode = ResizePolicy::Mode::exact;
  policy.exact = {33, 17};
  EXPECT_EQ(target_size({1920, 1080}, policy), (Size{33, 17}));
  policy.mode = ResizePolicy::Mode::none;
  EXPECT_EQ(target_size({641, 359}, policy), (Size{641, 359}));
  EXPECT_THROW(target_size({0, 359}, policy), std::invalid_argument);
}

TEST(TargetSize, nonsense_policies_are_refused) {
  ResizePolicy policy;
  policy.mode = ResizePolicy::Mode::exact;
  EXPECT_THROW(policy.check(), std::invalid_argument);
  policy.exact = {70000, 10};
  EXPECT_THROW(policy.check(), std::invalid_argument);
  policy = {};
  policy.budget = {8, 480};
  EXPECT_THROW(policy.check(), std::invalid_argument);
  policy = {};
  policy.max_side = -1;
  EXPECT_THROW(policy.check(), std::invalid_argument);
}

}  // namespace
}  // namespace uwv
