// SPDX-License-Identifier: Apache-2.0
#include "model/network_input.h"

#include <gtest/gtest.h>

namespace uwv::model {
namespace {

InputRule rule(SizeRule size_rule, int side, int multiple) {
  InputRule r;
  r.size_rule = size_rule;
  r.side = side;
  r.multiple_of = multiple;
  return r;
}

TEST(NetworkInput, sizes_follow_the_rules_of_the_published_networks) {
  // Depth Anything: shorter side 518, both multiples of 14, nearest.
  EXPECT_EQ(network_size(rule(SizeRule::shorter_side, 518, 14), {1920, 1080}), (Size{924, 518}));
  EXPECT_EQ(network_size(rule(SizeRule::shorter_side, 518, 14), {480, 832}), (Size{518, 896}));
  // VGGT: width 518.
  EXPECT_EQ(network_size(rule(SizeRule::width, 518, 14), {832, 480}), (Size{518, 294}));
  EXPECT_EQ(network_size(rule(SizeRule::longer_side, 518, 14), {480, 832}), (Size{294, 518}));
  // Video Depth Anything: a 21:9 picture gets a smaller side, int(518 * 1.777 / (7/3)) = 394, to 392.
  InputRule limited = rule(SizeRule::shorter_side, 518, 14);
  limited.limit_aspect = 1.777;
  EXPECT_EQ(network_size(limited, {2100, 900}), (Size{910, 392}));
  EXPECT_EQ(network_size(limited, {1600, 1200}), (Size{686, 518}));
  InputRule area = rule(SizeRule::area, 0, 14);
  area.pixels = 3600 * 14 * 14;
  EXPECT_EQ(network_size(area, {1000, 1000}), (Size{840, 840}));
  InputRule fixed;
  fixed.size_rule = SizeRule::fixed;
  fixed.size = {644, 476};
  EXPECT_EQ(network_size(fixed, {9, 9}), (Size{644, 476}));
}

TEST(NetworkInput, rounding_has_a_direction) {
  InputRule r = rule(SizeRule::longer_side, 100, 32);
  EXPECT_EQ(network_size(r, {100, 50}), (Size{96, 64}));
  r.rounding = Rounding::down;
  EXPECT_EQ(network_size(r, {100, 50}), (Size{96, 32}));
  r.rounding = Rounding::up;
  EXPECT_EQ(network_size(r, {100, 50}), (Size{128, 64}));
  EXPECT_EQ(network_size(r, {1, 1}), (Size{128, 128}));
  r.side = 96;
  EXPECT_EQ(network_size(r, {5, 5}), (Size{96, 96})) << "already a multiple";
}

TEST(NetworkInput, refuses_sizes_nobody_can_hold) {
  EXPECT_THROW(network_size(rule(SizeRule::shorter_side, 16384, 1), {16384, 1}), Error);
  EXPECT_THROW(network_size(rule(SizeRule::width, 16384, 1), {1, 60000}), Error);
  EXPECT_THROW(network_size(rule(SizeRule::width, 518, 14), {0, 0}), std::invalid_argument);
}

TEST(NetworkInput, normalises_as_written) {
  InputRule r;
  r.size_rule = SizeRule::fixed;
  r.size = {2, 1};
  r.mean = {0.5, 0.25, 0};
  r.std = {0.5, 2, 1};
  ImageRgb frame(2, 1);
  frame(0, 0) = {255, 0, 51};
  frame(1, 0) = {0, 255, 0};
  const FloatTensor rgb = prepared_frame(r, frame);
  EXPECT_EQ(rgb.values, (std::vector<float>{1, -1, -0.125F, 0.375F, 0.2F, 0}));
  r.bgr = true;
  EXPECT_FLOAT_EQ(prepared_frame(r, frame).values[0], (0.2F - 0.5F) / 0.5F);
  r = {};
  r.size_rule = SizeRule::fixed;
  r.size = {2, 1};
  r.range = {-1, 1};
  EXPECT_EQ(prepared_frame(r, frame).values[0], 1);
  EXPECT_EQ(prepared_frame(r, frame).values[1], -1);
}

TEST(NetworkInput, layouts_put_each_number_in_its_place) {
  FloatTensor first{{3, 2, 4}, std::vector<float>(24)}, second = first;
  for (std::size_t i = 0; i < 24; ++i) {
    first.values[i] = static_cast<float>(i);
    second.values[i] = static_cast<float>(100 + i);
  }
  const std::vector<const FloatTensor*> one{&first}, both{&first, &second};
  InputRule r;
  EXPECT_EQ(network_input(r, one).shape, (std::vector<std::int64_t>{1, 3, 2, 4}));
  EXPECT_EQ(network_input(r, one).values, first.values);
  r.layout = "NHWC";
  const FloatTensor last = network_input(r, one);
  EXPECT_EQ(last.shape, (std::vector<std::int64_t>{1, 2, 4, 3}));
  // y = 1, x = 2, c = 1
  EXPECT_EQ(last.values[(1 * 4 + 2) * 3 + 1], first.values[1 * 8 + 1 * 4 + 2]);
  EXPECT_THROW(network_input(r, both), std::invalid_argument);
  r.layout = "NTCHW";
  const FloatTensor clip = network_input(r, both);
  EXPECT_EQ(clip.shape, (std::vector<std::int64_t>{1, 2, 3, 2, 4}));
  EXPECT_EQ(clip.values[24], 100);
}

}  // namespace
}  // namespace uwv::model
