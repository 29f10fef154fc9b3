// SPDX-License-Identifier: Apache-2.0
#include "pipeline/channel.h"

#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <thread>

namespace uwv::pipeline {
namespace {

TEST(Channel, KeepsOrderAcrossThreads) {
  Channel<int> channel(3);
  std::thread sender([&] {
    for (int i = 0; i < 1000; ++i) channel.push(i);
    channel.close();
  });
  int expected = 0;
  while (const auto item = channel.pop()) EXPECT_EQ(*item, expected++);
  sender.join();
  EXPECT_EQ(expected, 1000);
}

TEST(Channel, SenderWaitsWhenFull) {
  Channel<int> channel(2);
  std::atomic<int> sent = 0;
  std::thread sender([&] {
    for (int i = 0; i < 5; ++i)
      if (channel.push(i)) ++sent;
  });
  for (int i = 0; i < 5; ++i) {
    ASSERT_EQ(channel.pop().value_or(-1), i);
    EXPECT_LE(sent, i + 4) << "more than two items were waiting";
  }
  sender.join();
}

TEST(Channel, ClosingWakesASenderThatWaits) {
  Channel<int> channel(1);
  ASSERT_TRUE(channel.push(1));
  std::thread closer([&] { channel.close(); });
  while (channel.push(2)) (void)channel.pop();
  closer.join();
}

TEST(Channel, ItemsSentBeforeClosingArrive) {
  Channel<std::unique_ptr<int>> channel(4);
  channel.push(std::make_unique<int>(7));
  channel.close();
  EXPECT_FALSE(channel.push(std::make_unique<int>(8)));
  EXPECT_EQ(**channel.pop(), 7);
  EXPECT_FALSE(channel.pop().has_value());
}

}  // namespace
}  // namespace uwv::pipeline
