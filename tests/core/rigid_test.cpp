// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "uwv/core/camera.h"

namespace uwv {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

Eigen::Matrix3d random_rotation(std::mt19937& rng) {
  std::normal_distribution<double> normal;
  const Eigen::Quaterniond q(normal(rng), normal(rng), normal(rng), normal(rng));
  return q.normalized().toRotationMatrix();
}

Eigen::Vector3d random_vector(std::mt19937& rng, double scale) {
  std::uniform_real_distribution<double> uniform(-scale, scale);
  return {uniform(rng), uniform(rng), uniform(rng)};
}

Rigid3 random_rigid(std::mt19937& rng) { return {random_rotation(rng), random_vector(rng, 10)}; }

double distance(const Rigid3& a, const Rigid3& b) { return (a.matrix() - b.matrix()).cwiseAbs().maxCoeff(); }

TEST(Rigid3, DefaultIsIdentity) { EXPECT_EQ(Rigid3{}.matrix(), Eigen::Matrix4d::Identity()); }

TEST(Rigid3, InverseUndoes) {
  std::mt19937 rng(1);
  for (int i = 0; i < 1000; ++i) {
    const Rigid3 a_from_b = random_rigid(rng);
    ASSERT_LT(distance(a_from_b * a_from_b.inverse(), Rigid3{}), 1e-14 * 30) << i;
    ASSERT_LT(distance(a_from_b.inverse().inverse(), a_from_b), 1e-14 * 30) << i;
  }
}

TEST(Rigid3, ProductAppliesRightFactorFirst) {
  std::mt19937 rng(2);
  for (int i = 0; i < 1000; ++i) {
    const Rigid3 a_from_b = random_rigid(rng), b_from_c = random_rigid(rng);
    const Eigen::Vector3d x_in_c = random_vector(rng, 10);
    ASSERT_LT(((a_from_b * b_from_c) * x_in_c - a_from_b * (b_from_c * x_in_c)).norm(), 1e-12) << i;
    ASSERT_LT(((a_from_b * b_from_c).matrix() - a_from_b.matrix() * b_from_c.matrix()).norm(), 1e-12) << i;
  }
}

TEST(Rigid3, MatrixRoundTripIsExact) {
  std::mt19937 rng(3);
  for (int i = 0; i < 1000; ++i) {
    const Rigid3 pose = random_rigid(rng);
    ASSERT_EQ(Rigid3::from_matrix(pose.matrix(), "pose"), pose) << i;
  }
}

TEST(Rigid3, SmallDeviationIsProjectedOntoTheNearestRotation) {
  std::mt19937 rng(4);
  for (int i = 0; i < 1000; ++i) {
    const Rigid3 pose = random_rigid(rng);
    Eigen::Matrix4d rounded = pose.matrix();
    for (int k = 0; k < 3; ++k) rounded.block<3, 1>(0, k) += random_vector(rng, 1e-5);
    const Rigid3 read = Rigid3::from_matrix(rounded, "pose");
    ASSERT_LT((read.rotation.transpose() * read.rotation - Eigen::Matrix3d::Identity()).norm(), 1e-13) << i;
    ASSERT_LT((read.rotation - pose.rotation).cwiseAbs().maxCoeff(), 5e-5) << i;
    ASSERT_EQ(read.translation, rounded.topRightCorner(3, 1)) << i;
  }
}

/// The refusal's sentence; fails the test when the matrix is accepted.
std::string refusal(const Eigen::Matrix4d& matrix, double tolerance = 1e-3) {
  try {
    Rigid3::from_matrix(matrix, "poses.json /frames/3", tolerance);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::value_invalid);
    EXPECT_THAT(error.what(), HasSubstr("poses.json /frames/3"));
    EXPECT_THAT(error.what(), Not(HasSubstr("\n")));
    return error.what();
  }
  ADD_FAILURE() << "accepted:\n" << matrix;
  return "";
}

TEST(Rigid3, FromMatrixRefusesWhatIsNotFinite) {
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    for (int i = 0; i < 16; ++i) {
      Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
      m(i / 4, i % 4) = bad;
      EXPECT_THAT(refusal(m), HasSubstr("NaN or Inf")) << "element " << i;
    }
  }
}

TEST(Rigid3, FromMatrixRefusesTransposedPose) {
  std::mt19937 rng(5);
  EXPECT_THAT(refusal(random_rigid(rng).matrix().transpose()), HasSubstr("transposed"));
}

TEST(Rigid3, FromMatrixRefusesWhatIsNotARotation) {
  std::mt19937 rng(6);
  Eigen::Matrix4d pose = random_rigid(rng).matrix();

  Eigen::Matrix4d scaled = pose;
  scaled.topLeftCorner<3, 3>() *= 1.01;
  EXPECT_THAT(refusal(scaled), HasSubstr("not orthonormal"));

  Eigen::Matrix4d singular = pose;
  singular.col(1) = singular.col(0);
  EXPECT_THAT(refusal(singular), HasSubstr("not orthonormal"));

  EXPECT_THAT(refusal(Eigen::Vector4d(0, 0, 0, 1).asDiagonal()), HasSubstr("not orthonormal"));

  Eigen::Matrix4d huge = pose;
  huge.topLeftCorner<3, 3>() *= 1e200;  // R^T R overflows to infinity
  EXPECT_THAT(refusal(huge), HasSubstr("not orthonormal"));

  Eigen::Matrix4d mirrored = pose;
  mirrored.col(0) *= -1;
  EXPECT_THAT(refusal(mirrored), HasSubstr("mirrors"));
}

TEST(Rigid3, FromMatrixHonoursTolerance) {
  Eigen::Matrix4d skewed = Eigen::Matrix4d::Identity();
  skewed(0, 1) = 0.01;
  EXPECT_THAT(refusal(skewed, 0.009), HasSubstr("not orthonormal"));
  EXPECT_NO_THROW(Rigid3::from_matrix(skewed, "pose", 0.011));
}

}  // namespace
}  // namespace uwv
