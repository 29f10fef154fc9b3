// SPDX-License-Identifier: Apache-2.0
#include "geometry/moving/grouping.h"

#include <gtest/gtest.h>

namespace uwv::testing {
namespace {

using moving::Piece;
using moving::PieceRelations;

/// Two things over `frames` frames, followed without fail, near each other in the first `near` of them.
std::vector<PieceRelations> two_things(int frames, int near, const cv::Vec2f& one_step, const cv::Vec2f& other_step) {
  std::vector<PieceRelations> relations;
  for (int i = 0; i < frames; ++i) {
    PieceRelations& now = relations.emplace_back();
    now.becomes = i + 1 < frames ? std::vector<int>{0, 1} : std::vector<int>{-1, -1};
    now.steps = {one_step, other_step};
    if (i < near) now.nearby = {{0, 1}};
  }
  return relations;
}

std::vector<std::vector<int>> group(const std::vector<PieceRelations>& relations) {
  return moving::group_pieces(std::vector<std::size_t>(relations.size(), 2), relations);
}

TEST(GroupingTest, WhatStaysTogetherIsOne) {
  for (const auto& frame : group(two_things(10, 8, {0.01F, 0}, {0.02F, 0}))) EXPECT_EQ(frame, (std::vector<int>{0, 0}));
}

TEST(GroupingTest, WhatPassesEachOtherIsTwo) {
  for (const auto& frame : group(two_things(10, 3, {0.01F, 0}, {0.01F, 0}))) EXPECT_EQ(frame, (std::vector<int>{0, 1}));
}

TEST(GroupingTest, WhatGoesDifferentWaysSideBySideIsTwo) {
  for (const auto& frame : group(two_things(10, 10, {0.03F, 0}, {-0.03F, 0})))
    EXPECT_EQ(frame, (std::vector<int>{0, 1}));
}

TEST(GroupingTest, ASplinterBelongsToWhatItIsNear) {
  std::vector<PieceRelations> relations = two_things(10, 0, {0, 0}, {0, 0});
  std::vector<std::size_t> pieces(10, 1);
  for (std::size_t i = 0; i < 10; ++i) relations[i].becomes = {i < 9 ? 0 : -1}, relations[i].steps = {{0, 0}};
  pieces[4] = 2;
  relations[4].becomes = {0, -1};
  relations[4].steps = {{0, 0}, {0.1F, 0}};
  relations[4].nearby = {{0, 1}};
  EXPECT_EQ(moving::group_pieces(pieces, relations)[4], (std::vector<int>{0, 0}));
}

TEST(GroupingTest, NothingGroupsToNothing) {
  EXPECT_TRUE(moving::group_pieces({}, {}).empty());
  EXPECT_EQ(moving::group_pieces({0, 0}, std::vector<PieceRelations>(2)).size(), 2U);
}

TEST(GroupingTest, RelationsAreSeenInPictures) {
  ValidityMask mask(160, 160, std::uint8_t{1});
  const auto block = [&](int x0) {
    for (int y = 60; y < 100; ++y)
      for (int x = x0; x < x0 + 20; ++x) mask(x, y) = 0;
  };
  block(10), block(36), block(120);  // gaps of 6 and 64 pixels; near is up to 10
  cv::Mat labels;
  const std::vector<Piece> pieces = moving::find_pieces(mask, labels);
  const cv::Mat flow(80, 80, CV_32FC2, cv::Scalar(0.8, 0));
  const PieceRelations relations = moving::relate_pieces(pieces, labels, flow, pieces, labels);
  EXPECT_EQ(relations.nearby, (std::vector<std::pair<int, int>>{{0, 1}}));
  EXPECT_EQ(relations.becomes, (std::vector<int>{0, 1, 2}));
  EXPECT_NEAR(relations.steps[2][0], 0.01, 1e-6);
  EXPECT_EQ(moving::relate_pieces(pieces, labels, {}, {}, {}).becomes, (std::vector<int>{-1, -1, -1}));
}

}  // namespace
}  // namespace uwv::testing
