// SPDX-License-Identifier: Apache-2.0
#include "uwv/trajectory/orbit.h"

#include <gtest/gtest.h>

#include <cmath>

#include "uwv/trajectory/subject_world.h"

namespace uwv {
namespace {

double rotation_error(const Eigen::Matrix3d& r) {
  return (r.transpose() * r - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
}

void expect_finite_rigid(const CameraPath& path) {
  ASSERT_EQ(path.subject_from_cam.size(), path.zoom.size());
  for (std::size_t k = 0; k < path.zoom.size(); ++k) {
    const Rigid3& pose = path.subject_from_cam[k];
    ASSERT_TRUE(pose.translation.allFinite()) << "frame " << k;
    ASSERT_LT(rotation_error(pose.rotation), 1e-12) << "frame " << k;
    ASSERT_TRUE(std::isfinite(path.zoom[k]) && path.zoom[k] > 0) << "frame " << k;
  }
}

TEST(FreePath, moves_as_the_signs_say) {
  const Rigid3 start = initial_camera(0, 2);
  const auto end = [&](const FreeMove& move) { return free_path(move, start, 2, 81).subject_from_cam.back(); };
  EXPECT_LT(end({.d_phi = 30}).translation.x(), -0.9) << "d_phi > 0 is left";
  EXPECT_GT(end({.d_theta = 30}).translation.y(), 0.9) << "d_theta > 0 is down";
  EXPECT_GT(end({.x = 0.5}).translation.x(), 0.9) << "x > 0 is right";
  EXPECT_GT(end({.y = 0.5}).translation.y(), 0.9) << "y > 0 is down";
  EXPECT_GT(end({.z = 0.5}).translation.z(), -1.1) << "z > 0 is forward";
  EXPECT_DOUBLE_EQ(end({.d_r = 1.5}).translation.z(), -3) << "d_r > 1 is away";
}

// The check vectors of the reference sheet, section 3.
TEST(FreePath, matches_the_sheets_vectors) {
  const Rigid3 flat = free_path({.d_phi = 50}, initial_camera(0, 2), 2, 81).subject_from_cam[80];
  EXPECT_LT((flat.translation - Eigen::Vector3d(-1.532089, 0, -1.285575)).norm(), 1e-6);
  EXPECT_LT((flat.rotation.col(0) - Eigen::Vector3d(0.642788, 0, -0.766044)).norm(), 1e-6);
  const FreeMove move{.d_phi = 45, .d_theta = -15, .d_r = 1.6, .x = 0.1, .y = -0.05, .z = 0.2};
  const auto path = free_path(move, initial_camera(5, 2), 2, 81).subject_from_cam;
  EXPECT_LT((path[40].translation - Eigen::Vector3d(-0.842997, -0.626941, -2.088358)).norm(), 2e-6);
  EXPECT_LT((path[40].rotation.col(2) - Eigen::Vector3d(0.373612, 0.21644, 0.90198)).norm(), 2e-6);
  EXPECT_LT((path[80].translation - Eigen::Vector3d(-1.810232, -1.252489, -1.494183)).norm(), 2e-6);
}

TEST(FreePath, keeps_the_official_lag_of_offsets_and_zoom) {
  const CameraPath path = free_path({.x = 1, .focal = 3}, initial_camera(0, 1), 1, 5);
  EXPECT_DOUBLE_EQ(path.subject_from_cam.back().translation.x(), 0.8);
  EXPECT_DOUBLE_EQ(path.zoom.back(), 3 * 0.8 + 0.2);
  const CameraPath twice = free_path({.focal = 3, .zoom_twice = true}, initial_camera(0, 1), 1, 5);
  EXPECT_DOUBLE_EQ(twice.zoom.back(), path.zoom.back() * path.zoom.back());
}

TEST(Paths, start_with_the_start_camera_to_the_last_bit) {
  const Rigid3 start = initial_camera(7, 1.3);
  for (const PresetInfo& preset : presets())
    EXPECT_EQ(preset_path(preset.name, 1, start, 1.3, 9).subject_from_cam.front(), start) << preset.name;
}

TEST(Paths, work_at_every_length_and_scale) {
  for (const double radius : {1e-6, 1.0, 1e9})
    for (const long frames : {1L, 2L, 3L, 81L, 2000L})
      for (const PresetInfo& preset : presets()) {
        SCOPED_TRACE(fmt::format("{}, {} frames, radius {}", preset.name, frames, radius));
        const CameraPath path = preset_path(preset.name, 1, initial_camera(5, radius), radius, frames);
        ASSERT_EQ(std::ssize(path.zoom), frames);
        expect_finite_rigid(path);
        EXPECT_LT(path.subject_from_cam.back().translation.norm(), 4 * radius);
      }
}

TEST(Paths, scale_with_the_radius) {
  for (const PresetInfo& preset : presets()) {
    const auto small = preset_path(preset.name, 1, initial_camera(3, 1), 1, 21).subject_from_cam;
    const auto large = preset_path(preset.name, 1, initial_camera(3, 1e6), 1e6, 21).subject_from_cam;
    for (std::size_t k = 0; k < small.size(); ++k)
      EXPECT_LT((small[k].translation - large[k].translation * 1e-6).norm(), 1e-12) << preset.name << ", frame " << k;
  }
}

TEST(Paths, orbit_closes_its_circle) {
  const auto path = preset_path("orbit", 1, initial_camera(0, 2), 2, 81).subject_from_cam;
  EXPECT_LT((path.back().translation - path.front().translation).norm(), 1e-12);
  EXPECT_NEAR(path[40].translation.z(), 2, 1e-12);
  EXPECT_GT(path[20].translation.x(), 1.9) << "the orbit leaves to the right";
}

TEST(Presets, say_what_they_do) {
  const Rigid3 start = initial_camera(0, 1);
  const auto end = [&](std::string_view name) {
    return preset_path(name, 1, start, 1, 81).subject_from_cam.back().translation;
  };
  EXPECT_LT(end("left").x(), -0.4);
  EXPECT_GT(end("right").x(), 0.4);
  EXPECT_LT(end("up").y(), -0.3);
  EXPECT_GT(end("down").y(), 0.2);
  EXPECT_GT(end("forward").z(), -0.8);
  EXPECT_LT(end("backward").z(), -1.3);
  EXPECT_LT(end("truck_left").x(), -0.2);
  EXPECT_GT(end("truck_right").x(), 0.2);
  EXPECT_FALSE(is_preset("leftish"));
  EXPECT_THROW(preset_path("leftish", 1, start, 1, 5), std::invalid_argument);
}

TEST(ListsPath, follows_the_viewcrafter_signs) {
  const Rigid3 start = initial_camera(0, 2);
  const auto end = [&](const OrbitLists& lists) {
    return lists_path(lists, start, 25).subject_from_cam.back().translation;
  };
  EXPECT_GT(end({.phi = {0, 30}}).x(), 0.9) << "phi > 0 is right";
  EXPECT_GT(end({.theta = {0, 30}}).y(), 0.9) << "theta > 0 is down";
  EXPECT_DOUBLE_EQ(end({.r = {0, -0.25}}).z(), -1.5) << "r < 0 is forward";
}

TEST(ListsPath, agrees_with_the_free_path_on_straight_lists) {
  const Rigid3 start = initial_camera(4, 2);
  const auto lists = lists_path({.phi = {0, 20}, .theta = {0, -10}, .r = {0, 0.3}}, start, 33).subject_from_cam;
  const auto free = free_path({.d_phi = -20, .d_theta = -10, .d_r = 1.3}, start, 2, 33).subject_from_cam;
  for (std::size_t k = 0; k < free.size(); ++k)
    EXPECT_LT((lists[k].matrix() - free[k].matrix()).cwiseAbs().maxCoeff(), 1e-12) << "frame " << k;
}

TEST(RotationFromVectors, turns_one_direction_onto_the_other) {
  const Eigen::Vector3d from(1, -2, 0.5);
  for (const Eigen::Vector3d& to : {Eigen::Vector3d(3, 1, 2), Eigen::Vector3d(1e-9, 1e-9, 1e-9),
                                    Eigen::Vector3d(-1e200, 1e200, 0), Eigen::Vector3d(1, -2, 0.5 + 1e-9)}) {
    const Eigen::Matrix3d r = rotation_from_vectors(from, to);
    EXPECT_LT((r * from.normalized() - to.stableNormalized()).norm(), 1e-9) << to.transpose();
    EXPECT_LT(rotation_error(r), 1e-14);
    EXPECT_NEAR(r.determinant(), 1, 1e-14);
  }
  EXPECT_EQ(rotation_from_vectors(from, from), Eigen::Matrix3d::Identity());
  const Eigen::Vector3d z(0, 0, 1);
  EXPECT_LT((rotation_from_vectors(z, -z) * z + z).norm(), 1e-15);
  EXPECT_THROW(rotation_from_vectors(Eigen::Vector3d::Zero(), from), std::invalid_argument);
  EXPECT_THROW(rotation_from_vectors(from, Eigen::Vector3d(NAN, 0, 0)), std::invalid_argument);
}

TEST(SubjectWorld, puts_the_first_camera_above_the_subject) {
  const Rigid3 camera = initial_camera(30, 2);
  EXPECT_LT(camera.translation.y(), -0.9);
  const Eigen::Vector3d origin_in_cam = camera.inverse() * Eigen::Vector3d::Zero();
  EXPECT_LT((origin_in_cam - Eigen::Vector3d(0, 0, 2)).norm(), 1e-15);
}

TEST(SubjectWorld, keeps_centimetres_ten_million_units_from_the_origin) {
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  const Rigid3 cam0{turn, Eigen::Vector3d(1e7, -2e7, 3e6)};
  const SubjectWorld world(cam0, 10, 2.5);
  EXPECT_EQ(world.subject_from_cam(cam0), world.subject_from_cam0());
  Rigid3 moved = cam0;
  moved.translation += turn * Eigen::Vector3d(0.01, 0, 0);
  const Rigid3 in_subject = world.subject_from_cam(moved);
  const Eigen::Vector3d step = in_subject.translation - world.subject_from_cam0().translation;
  EXPECT_LT((step - Eigen::Vector3d(0.01, 0, 0)).norm(), 1e-8) << step.transpose();
  EXPECT_LT((world.world_from_cam(in_subject).translation - moved.translation).norm(), 1e-8);
  const Eigen::Vector3d subject = cam0 * Eigen::Vector3d(0, 0, 2.5);
  EXPECT_LT(world.point_in_subject(subject).norm(), 1e-7);
}

TEST(SubjectWorld, refuses_a_radius_that_is_none) {
  EXPECT_THROW(SubjectWorld({}, 0, 0), std::invalid_argument);
  EXPECT_THROW(SubjectWorld({}, 0, -1), std::invalid_argument);
  EXPECT_THROW(SubjectWorld({}, 0, NAN), std::invalid_argument);
  EXPECT_THROW(SubjectWorld({}, INFINITY, 1), std::invalid_argument);
}

TEST(Easing, is_monotone_and_keeps_its_ends) {
  for (const std::string_view name : easing_names()) {
    const Easing easing = *easing_from_string(name);
    EXPECT_EQ(to_string(easing), name);
    EXPECT_EQ(ease(easing, 0), 0) << name;
    EXPECT_EQ(ease(easing, 1), 1) << name;
    EXPECT_EQ(ease(easing, -3), 0) << name;
    EXPECT_EQ(ease(easing, 3), 1) << name;
    for (int i = 1; i <= 1000; ++i)
      EXPECT_GE(ease(easing, i / 1000.0), ease(easing, (i - 1) / 1000.0)) << name << ' ' << i;
  }
  EXPECT_FALSE(easing_from_string("bouncy"));
}

}  // namespace
}  // namespace uwv
