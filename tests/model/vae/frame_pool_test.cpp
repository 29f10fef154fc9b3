// SPDX-License-Identifier: Apache-2.0
#include "model/vae/frame_pool.h"

#include <ATen/ATen.h>
#include <gtest/gtest.h>

namespace uwv::model {
namespace {

TEST(FramePool, LendsFramesOfTheSizeAskedFor) {
  for (const at::ScalarType type : {at::kFloat, at::kBFloat16}) {
    const FramePool pool(type);
    const at::Tensor frame = pool.take(3, 5, 7);
    EXPECT_EQ(frame.sizes(), (std::vector<std::int64_t>{3, 5, 7}));
    EXPECT_EQ(frame.scalar_type(), type);
    EXPECT_TRUE(frame.is_contiguous());
    const at::Tensor source = at::randn({5, 3, 7}).permute({1, 0, 2});
    EXPECT_TRUE(at::equal(pool.copy_of(source), source.to(type)));
    EXPECT_EQ(pool.take(0, 5, 7).sizes(), (std::vector<std::int64_t>{0, 5, 7}));
  }
}

TEST(FramePool, MemoryComesBackWithTheLastTensorThatRefersToIt) {
  const FramePool pool(at::kFloat);
  at::Tensor first = pool.take(4, 4, 4);
  const void* const memory = first.data_ptr();
  at::Tensor part = first.narrow(0, 1, 2);
  first.reset();
  EXPECT_NE(pool.take(4, 4, 4).data_ptr(), memory) << "a part of it is still in use";
  part.reset();
  // Two lie idle now; both are lent before anything new.
  const at::Tensor a = pool.take(4, 4, 4), b = pool.take(4, 4, 4), c = pool.take(4, 4, 4);
  EXPECT_TRUE(a.data_ptr() == memory || b.data_ptr() == memory);
  EXPECT_NE(c.data_ptr(), memory);
}

TEST(FramePool, MemoryIsUsedAgainForNearlyTheSameSizeOnly) {
  const FramePool pool(at::kFloat);
  at::Tensor frame = pool.take(10, 10, 10);
  const void* const memory = frame.data_ptr();
  frame.reset();
  frame = pool.take(8, 10, 10);
  EXPECT_EQ(frame.data_ptr(), memory);
  EXPECT_EQ(frame.numel(), 800);
  frame.reset();
  EXPECT_NE(pool.take(7, 10, 10).data_ptr(), memory) << "three tenths of it would lie waste";
  EXPECT_NE(pool.take(11, 10, 10).data_ptr(), memory);
  EXPECT_EQ(pool.take(10, 10, 10).data_ptr(), memory);
}

TEST(FramePool, BriefMemoryIsUsedWhateverItsSizeAndReplacedWhereItIsTooSmall) {
  const FramePool pool(at::kFloat);
  const void* memory = pool.take_briefly(1000).data_ptr();
  EXPECT_EQ(pool.take_briefly(10).data_ptr(), memory);
  const at::Tensor large = pool.take_briefly(2000), small = pool.take_briefly(10);
  EXPECT_EQ(large.numel(), 2000);
  EXPECT_NE(small.data_ptr(), large.data_ptr());
  large.fill_(1);
  small.fill_(2);
  EXPECT_EQ(large.sum().item<float>(), 2000);
}

TEST(FramePool, FramesOutliveTheirPool) {
  at::Tensor frame;
  {
    const FramePool pool(at::kFloat);
    frame = pool.copy_of(at::ones({2, 3, 4}));
  }
  EXPECT_EQ(frame.sum().item<float>(), 24);
}

TEST(FrameHistory, KeepsTheNewest) {
  FrameHistory history;
  for (int i = 0; i < 5; ++i) history.push(at::full({1}, i));
  history.replace_newest(at::full({1}, 7));
  history.keep(2);
  ASSERT_EQ(history.size(), 2U);
  EXPECT_EQ(history.frame(0).item<int>(), 7);
  EXPECT_EQ(history.frame(1).item<int>(), 3);
  history.keep(3);
  EXPECT_EQ(history.size(), 2U);
}

}  // namespace
}  // namespace uwv::model
