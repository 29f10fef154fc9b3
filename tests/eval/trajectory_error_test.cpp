// SPDX-License-Identifier: Apache-2.0
#include "uwv/eval/trajectory_error.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>
#include <vector>

namespace uwv {
namespace {

using Eigen::Vector3d;

Eigen::Matrix3d turned(const Vector3d& axis, double angle) {
  return Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
}

std::vector<Rigid3> winding_track(int n) {
  std::vector<Rigid3> out;
  for (int i = 0; i < n; ++i) {
    const double s = 0.2 * i;
    out.push_back({turned({1, 2, 3}, 0.1 * s), {std::cos(s), 0.3 * s, std::sin(1.3 * s)}});
  }
  return out;
}

/// The same cameras in a world that is turned, scaled and moved.
std::vector<Rigid3> seen_from(const std::vector<Rigid3>& track, double scale, const Eigen::Matrix3d& rotation,
                              const Vector3d& translation) {
  std::vector<Rigid3> out;
  for (const Rigid3& pose : track)
    out.push_back({rotation * pose.rotation, scale * (rotation * pose.translation) + translation});
  return out;
}

TEST(TrajectoryError, IsZeroUpToASimilarity) {
  const auto truth = winding_track(20);
  const auto estimate = seen_from(truth, 0.01, turned({3, -1, 2}, 2.5), {100, -7, 3});
  const TrajectoryError e = trajectory_error(estimate, truth);
  EXPECT_LT(e.ate_rmse, 1e-9);
  EXPECT_LT(e.rotation_max, 1e-6);
  EXPECT_LT(e.relative_translation_rmse, 1e-9);
  EXPECT_NEAR(e.truth_from_estimate.scale, 100, 1e-6);
}

TEST(TrajectoryError, MeasuresAKnownDisplacementAndTurn) {
  const auto truth = winding_track(200);
  auto estimate = truth;
  estimate[100].translation += Vector3d(0.2, 0, 0);
  estimate[50].rotation = estimate[50].rotation * turned({0, 1, 0}, 0.1);
  const TrajectoryError e = trajectory_error(estimate, truth);
  EXPECT_NEAR(e.ate_rmse, 0.2 / std::sqrt(200.0), 2e-4);
  EXPECT_NEAR(e.ate_max, 0.2, 5e-3);
  EXPECT_NEAR(e.rotation_max, 0.1 * 180 / M_PI, 0.1);
}

TEST(TrajectoryError, IsTheSameFarFromTheOrigin) {
  const auto truth = winding_track(30);
  auto estimate = truth;
  std::mt19937_64 random(3);
  std::normal_distribution<double> noise(0, 0.01);
  for (Rigid3& pose : estimate) pose.translation += Vector3d(noise(random), noise(random), noise(random));
  const Vector3d far(1e7, -1e7, 1e7);
  const double near = trajectory_error(estimate, truth).ate_rmse;
  const double away = trajectory_error(seen_from(estimate, 1, Eigen::Matrix3d::Identity(), far),
                                       seen_from(truth, 1, Eigen::Matrix3d::Identity(), far))
                          .ate_rmse;
  EXPECT_NEAR(near, away, 1e-6 * near + 1e-8);  // positions of 1e7 are known to 2e-9
}

TEST(TrajectoryError, CoincidingCentresAreAlignedByHeadingsAlone) {
  std::vector<Rigid3> truth, estimate;
  const Eigen::Matrix3d world = turned({0, 0, 1}, 1);
  for (int i = 0; i < 5; ++i) {
    truth.push_back({turned({0, 1, 0}, 0.2 * i), {1, 2, 3}});
    estimate.push_back({world * truth.back().rotation, {0, 0, 0}});
  }
  const TrajectoryError e = trajectory_error(estimate, truth);
  EXPECT_LT(e.ate_rmse, 1e-12);
  EXPECT_LT(e.rotation_max, 1e-6);
  EXPECT_EQ(e.truth_from_estimate.scale, 1);
}

TEST(TrajectoryError, StraightTracksTakeTheirRollFromTheHeadings) {
  std::vector<Rigid3> truth;
  for (int i = 0; i < 8; ++i) truth.push_back({turned({1, 0, 0}, 0.3), {0.5 * i, 0, 0}});
  const Eigen::Matrix3d world = turned({1, 1, 0}, 0.8);
  const TrajectoryError e = trajectory_error(seen_from(truth, 3, world, {1, 1, 1}), truth);
  EXPECT_LT(e.ate_rmse, 1e-9);
  EXPECT_LT(rotation_angle(e.truth_from_estimate.rotation, world.transpose()), 1e-6);
}

TEST(TrajectoryError, OneAndTwoCamerasAreDefined) {
  const auto truth = winding_track(2);
  EXPECT_EQ(trajectory_error(std::span(truth).first(1), std::span(truth).first(1)).ate_rmse, 0);
  const auto estimate = seen_from(truth, 2, turned({1, 0, 1}, 0.4), {5, 5, 5});
  EXPECT_LT(trajectory_error(estimate, truth).ate_rmse, 1e-9);
}

TEST(TrajectoryError, RefusesWhatCannotBeCompared) {
  const auto track = winding_track(4);
  auto broken = track;
  broken[1].translation.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(trajectory_error({}, {}), std::invalid_argument);
  EXPECT_THROW(trajectory_error(track, std::span(track).first(3)), std::invalid_argument);
  EXPECT_THROW(trajectory_error(broken, track), std::invalid_argument);
  EXPECT_THROW(trajectory_error(track, track, 0), std::invalid_argument);
}

TEST(TrajectoryError, RotationAngleIsExactAtBothEnds) {
  const Eigen::Matrix3d i = Eigen::Matrix3d::Identity();
  EXPECT_EQ(rotation_angle(i, i), 0);
  EXPECT_NEAR(rotation_angle(i, turned({1, 2, 3}, 1e-9)), 1e-9 * 180 / M_PI, 1e-14);
  EXPECT_NEAR(rotation_angle(i, turned({1, 2, 3}, M_PI)), 180, 1e-6);
}

}  // namespace
}  // namespace uwv
