// SPDX-License-Identifier: Apache-2.0
#include "uwv/eval/path_truth.h"

#include <gtest/gtest.h>

#include <numbers>

namespace uwv::testing {
namespace {

constexpr double degree = std::numbers::pi / 180;

class PathTruthTest : public ::testing::Test {
 protected:
  ThreadPool pool_;
  StockScene scene_ = sphere_floor_wall({.size = {104, 60}});
};

TEST_F(PathTruthTest, OrbitEndsAtItsAngleInEqualSteps) {
  const std::vector<Camera> path = orbit_path(scene_, 40 * degree, 4);
  ASSERT_EQ(path.size(), 4U);
  EXPECT_EQ(path.back(), orbit_camera(scene_.source, scene_.subject_in_world, 40 * degree));
  EXPECT_EQ(path.front(), orbit_camera(scene_.source, scene_.subject_in_world, 10 * degree));
  EXPECT_THROW(orbit_path(scene_, 1, 0), std::invalid_argument);
}

TEST_F(PathTruthTest, OneCameraIsItsOwnPath) {
  const PathTruth truth = path_truth(scene_.scene, scene_.source, orbit_path(scene_, 0.5, 1), 0, pool_);
  EXPECT_EQ(truth.last.visible, truth.product.visible);
  EXPECT_EQ(truth.last.excluded, truth.product.excluded);
}

// There and back again: the end sees everything, the path doesn't.
TEST_F(PathTruthTest, ProductRemembersWhatWasHiddenOnTheWay) {
  std::vector<Camera> there_and_back = orbit_path(scene_, 30 * degree, 2);
  const PathTruth there = path_truth(scene_.scene, scene_.source, there_and_back, 0, pool_);
  there_and_back.push_back(scene_.source);
  const PathTruth back = path_truth(scene_.scene, scene_.source, there_and_back, 0, pool_);
  EXPECT_EQ(back.last.visible.count(), scene_.source.size.pixels());
  EXPECT_EQ(back.product.visible, there.product.visible);
  EXPECT_LT(back.product.visible.count(), back.last.visible.count());
}

TEST_F(PathTruthTest, RefusesAPathWithoutCameras) {
  EXPECT_THROW(path_truth(scene_.scene, scene_.source, {}, 0, pool_), std::invalid_argument);
}

}  // namespace
}  // namespace uwv::testing
