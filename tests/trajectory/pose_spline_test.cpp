// SPDX-License-Identifier: Apache-2.0
#include "uwv/trajectory/pose_spline.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

namespace uwv {
namespace {

Eigen::Matrix3d turn(double degrees, const Eigen::Vector3d& axis) {
  return Eigen::AngleAxisd(degrees * M_PI / 180, axis.normalized()).toRotationMatrix();
}

double angle_between(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
  const Eigen::Quaterniond q(Eigen::Matrix3d(a.transpose() * b));
  return 2 * std::atan2(q.vec().norm(), std::abs(q.w())) * 180 / M_PI;
}

struct RandomCurve {
  std::vector<double> times;
  Eigen::MatrixXd points{3, 0};
  std::vector<Eigen::Matrix3d> rotations;

  explicit RandomCurve(unsigned seed, int keys) : points(3, keys) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> step(0.05, 1), place(-3, 3), angle(0, 170);
    double time = 0;
    Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
    for (int i = 0; i < keys; ++i) {
      times.push_back(time += step(random));
      points.col(i) << place(random), place(random), place(random);
      const Eigen::Vector3d axis(place(random), place(random), place(random));
      rotations.push_back(rotation = rotation * turn(angle(random), axis));
    }
  }
};

TEST(PointSpline, passes_exactly_through_its_keys_and_holds_beyond) {
  const RandomCurve c(1, 7);
  const PointSpline curve(c.times, c.points);
  for (int i = 0; i < 7; ++i) EXPECT_EQ(curve(c.times[i]), c.points.col(i)) << i;
  EXPECT_EQ(curve(c.times.front() - 5), c.points.col(0));
  EXPECT_EQ(curve(c.times.back() + 5), c.points.col(6));
}

TEST(PointSpline, is_continuously_differentiable) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const RandomCurve c(seed, 6);
    const PointSpline curve(c.times, c.points);
    constexpr double h = 1e-6;
    for (int i = 1; i + 1 < 6; ++i) {
      const double t = c.times[i];
      const Eigen::VectorXd before = (curve(t) - curve(t - h)) / h;
      const Eigen::VectorXd after = (curve(t + h) - curve(t)) / h;
      EXPECT_LT((after - before).norm(), 2e-3 * (1 + before.norm())) << "seed " << seed << ", key " << i;
    }
  }
}

TEST(PointSpline, one_key_stays_and_two_make_a_line) {
  Eigen::MatrixXd point(2, 1);
  point << 3, 4;
  EXPECT_EQ(PointSpline(std::vector<double>{0.5}, point)(0.9), point.col(0));
  Eigen::MatrixXd pair(1, 2);
  pair << 1, 3;
  const PointSpline line(std::vector<double>{0, 1}, pair);
  for (const double t : {0.1, 0.25, 0.7}) EXPECT_NEAR(line(t)[0], 1 + 2 * t, 1e-15);
}

TEST(PointSpline, rests_between_equal_keys_and_stays_on_a_line) {
  Eigen::MatrixXd points(2, 5);
  points << 0, 1, 1, 4, 5, 0, 2, 2, 8, 10;
  const PointSpline curve(std::vector<double>{0, 1, 2, 2.5, 4}, points);
  for (const double t : {1.0, 1.2, 1.7, 2.0}) EXPECT_EQ(curve(t), points.col(1)) << t;
  double before = -1;
  for (double t = 0; t <= 4; t += 0.01) {
    const Eigen::VectorXd p = curve(t);
    EXPECT_NEAR(p[1], 2 * p[0], 1e-12) << "collinear keys give a straight path, t = " << t;
    EXPECT_GE(p[0], before - 1e-12) << "monotone keys give a monotone path, t = " << t;
    before = p[0];
  }
}

TEST(PointSpline, does_not_fling_itself_past_a_slow_piece) {
  Eigen::MatrixXd points(1, 3);
  points << 0, 100, 101;
  const PointSpline curve(std::vector<double>{0, 0.01, 1}, points);
  for (double t = 0.01; t <= 1; t += 0.01) EXPECT_LE(curve(t)[0], 101 + 1e-9) << t;
}

TEST(RotationSpline, passes_through_its_keys_and_stays_orthonormal) {
  const RandomCurve c(3, 8);
  const RotationSpline curve(c.times, c.rotations);
  for (std::size_t i = 0; i < c.rotations.size(); ++i) EXPECT_EQ(curve(c.times[i]), c.rotations[i]) << i;
  for (double t = c.times.front(); t < c.times.back(); t += 0.01)
    EXPECT_LT((curve(t).transpose() * curve(t) - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff(), 1e-14) << t;
}

TEST(RotationSpline, is_continuously_differentiable) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const RandomCurve c(seed, 6);
    const RotationSpline curve(c.times, c.rotations);
    constexpr double h = 1e-6;
    for (int i = 1; i + 1 < 6; ++i) {
      const double t = c.times[i];
      const Eigen::Matrix3d before = (curve(t) - curve(t - h)) / h;
      const Eigen::Matrix3d after = (curve(t + h) - curve(t)) / h;
      EXPECT_LT((after - before).norm(), 2e-3 * (1 + before.norm())) << "seed " << seed << ", key " << i;
    }
  }
}

TEST(RotationSpline, two_keys_turn_evenly_the_short_way) {
  const Eigen::Vector3d axis(1, 2, -1);
  for (const double degrees : {1e-7, 10.0, 120.0, 179.8}) {
    const RotationSpline curve(std::vector<double>{0, 1}, {turn(20, axis), turn(20 + degrees, axis)});
    for (const double t : {0.1, 0.5, 0.9})
      EXPECT_LT(angle_between(curve(t), turn(20 + t * degrees, axis)), 1e-6) << degrees << " degrees, t = " << t;
  }
  // The short way from 20 to 300 degrees leads backwards.
  const RotationSpline back(std::vector<double>{0, 1}, {turn(20, axis), turn(300, axis)});
  EXPECT_LT(angle_between(back(0.5), turn(-20, axis)), 1e-6);
}

TEST(RotationSpline, makes_a_full_turn_through_keys) {
  std::vector<double> times;
  std::vector<Eigen::Matrix3d> rotations;
  for (int i = 0; i <= 8; ++i) {
    times.push_back(i);
    rotations.push_back(turn(90 * i, {0, 1, 0}));  // two turns: the sign of a quaternion flips on the way
  }
  const RotationSpline curve(times, rotations);
  for (double t = 0; t <= 8; t += 0.125) EXPECT_LT(angle_between(curve(t), turn(90 * t, {0, 1, 0})), 1e-6) << t;
}

TEST(RotationSpline, rests_between_equal_keys) {
  const Eigen::Matrix3d a = turn(33, {1, 1, 0});
  const RotationSpline curve(std::vector<double>{0, 1, 2, 3}, {turn(0, {1, 0, 0}), a, a, turn(50, {0, 1, 0})});
  for (const double t : {1.0, 1.3, 1.9, 2.0}) EXPECT_EQ(curve(t), a) << t;
}

TEST(RotationSpline, refuses_half_a_turn) {
  const std::vector<Eigen::Matrix3d> rotations{turn(0, {1, 0, 0}), turn(90, {0, 1, 0}), turn(270, {0, 1, 0})};
  EXPECT_EQ(RotationSpline::first_ambiguous_turn(rotations), 2U);
  EXPECT_THROW(RotationSpline(std::vector<double>{0, 1, 2}, rotations), std::invalid_argument);
  EXPECT_THROW(RotationSpline(std::vector<double>{0, 0}, {rotations[0], rotations[1]}), std::invalid_argument);
}

TEST(LookAt, points_z_at_the_target_and_keeps_x_level) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> place(-10, 10);
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector3d position(place(random), place(random), place(random));
    const Eigen::Vector3d target(place(random), place(random), place(random));
    Eigen::Matrix3d r;
    ASSERT_EQ(look_at(position, target, 0, r), LookAt::good);
    EXPECT_LT((r.col(2) - (target - position).normalized()).norm(), 1e-12);
    EXPECT_NEAR(r(1, 0), 0, 1e-15) << "x has no vertical part";
    EXPECT_GT(r(1, 1), 0) << "y points down";
    EXPECT_NEAR(r.determinant(), 1, 1e-12);
  }
}

TEST(LookAt, rolls_clockwise) {
  Eigen::Matrix3d r;
  ASSERT_EQ(look_at({0, 0, -1}, {0, 0, 0}, 90, r), LookAt::good);
  EXPECT_LT((r.col(0) - Eigen::Vector3d(0, 1, 0)).norm(), 1e-15) << "the camera's right side points down";
}

TEST(LookAt, says_when_it_is_not_defined) {
  Eigen::Matrix3d r;
  EXPECT_EQ(look_at({1, 2, 3}, {1, 2, 3}, 0, r), LookAt::no_direction);
  EXPECT_EQ(look_at({0, 0, 0}, {0, 0, 0}, 0, r), LookAt::no_direction);
  EXPECT_EQ(look_at({0, -5, 0}, {0, 0, 0}, 0, r), LookAt::no_horizon);
  EXPECT_EQ(look_at({0, 5, 0}, {0, 0, 0}, 0, r), LookAt::no_horizon);
  EXPECT_EQ(look_at({0, -1e-6, -1e-6}, {0, 0, 0}, 0, r), LookAt::good) << "small scenes are scenes";
}

}  // namespace
}  // namespace uwv
