// SPDX-License-Identifier: Apache-2.0
#include "uwv/trajectory/target_path.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace uwv {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr Size size{832, 480};
const Intrinsics intrinsics{700, 695, 410, 236};

PathContext still_source(const TrajectorySpec& spec, long source_frames = 81, double radius = 2,
                         bool is_photo = false) {
  const Rigid3 world_from_cam;
  return make_context(spec, intrinsics, size, {&world_from_cam, 1}, source_frames, radius, is_photo);
}

TargetPath path_of(std::string_view json, long source_frames = 81, double radius = 2) {
  const TrajectorySpec spec = parse_trajectory(json, "t.json");
  return build_path(spec, still_source(spec, source_frames, radius));
}

std::string build_error(std::string_view json, long source_frames = 81) {
  try {
    path_of(json, source_frames);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

const Rigid3& pose(const TargetPath& path, std::size_t k) { return path.frames.at(k).camera.world_from_cam; }

std::vector<long> source_frames(const TargetPath& path) {
  std::vector<long> list;
  for (const TargetFrame& frame : path.frames) list.push_back(frame.source_frame);
  return list;
}

double difference(const Rigid3& a, const Rigid3& b) { return (a.matrix() - b.matrix()).cwiseAbs().maxCoeff(); }

/// A source camera that walks and turns, far from the origin of its world.
std::vector<Rigid3> moving_source(long frames, const Eigen::Vector3d& origin) {
  std::vector<Rigid3> poses;
  for (long i = 0; i < frames; ++i) {
    const double t = static_cast<double>(i);
    const Eigen::Matrix3d turn =
        Eigen::AngleAxisd(0.3 + 0.01 * t, Eigen::Vector3d(1, 3, -1).normalized()).toRotationMatrix();
    poses.push_back({turn, origin + Eigen::Vector3d(0.02 * t, 0.01 * t, -0.03 * t)});
  }
  return poses;
}

TEST(BuildPath, keeps_principal_point_and_zooms_focal_lengths) {
  const TargetPath path = path_of(R"({"frames": 5, "free": {"focal": 2}})");
  const Intrinsics& last = path.frames.back().camera.intrinsics;
  EXPECT_DOUBLE_EQ(last.fx, 700 * 1.8);
  EXPECT_DOUBLE_EQ(last.fy, 695 * 1.8);
  EXPECT_EQ(last.cx, 410);
  EXPECT_EQ(last.cy, 236);
  EXPECT_EQ(path.frames.front().camera.intrinsics, intrinsics);
  EXPECT_EQ(path.frames.back().camera.size, size);
}

TEST(BuildPath, has_the_length_that_is_asked_for_or_implied) {
  EXPECT_EQ(path_of(R"({"frames": 7, "preset": "left"})").frames.size(), 7U);
  EXPECT_EQ(path_of(R"({"preset": "left"})", 33).frames.size(), 33U);
  EXPECT_EQ(path_of(R"({"preset": "left", "time": {"frames": [1, 2, 3]}})").frames.size(), 3U);
  TrajectorySpec spec = trajectory_from_preset("left");
  EXPECT_EQ(build_path(spec, still_source(spec, 1, 2, true)).frames.size(), 81U);
}

TEST(BuildPath, radius_scale_moves_offsets_of_videos_only) {
  const TrajectorySpec spec = parse_trajectory(R"({"frames": 5, "radius_scale": 0.5, "free": {"x": 1}})", "t");
  const auto x = [&](bool is_photo) {
    return pose(build_path(spec, still_source(spec, 5, 2, is_photo)), 4).translation.x();
  };
  EXPECT_DOUBLE_EQ(x(false), 2 * 0.5 * 0.8);
  EXPECT_DOUBLE_EQ(x(true), 2 * 0.8);
}

TEST(BuildPath, controls_time) {
  EXPECT_THAT(source_frames(path_of(R"({"frames": 5, "preset": "left"})", 3)), ElementsAre(0, 1, 2, 2, 2));
  EXPECT_THAT(source_frames(path_of(R"({"frames": 3, "preset": "left", "time": {"freeze": 7}})")),
              ElementsAre(7, 7, 7));
  EXPECT_THAT(source_frames(path_of(R"({"preset": "left", "time": {"frames": [4, 0, 4]}})")), ElementsAre(4, 0, 4));
  EXPECT_THAT(source_frames(path_of(R"({"frames": 5, "preset": "left", "time": {"from": 8, "to": 0}})")),
              ElementsAre(8, 6, 4, 2, 0));
  EXPECT_THAT(source_frames(path_of(R"({"frames": 1, "preset": "left", "time": {"from": 8, "to": 0}})")),
              ElementsAre(8));
  EXPECT_THAT(build_error(R"({"preset": "left", "time": {"freeze": 9}})", 9), HasSubstr("t.json: /time/freeze"));
  EXPECT_THAT(build_error(R"({"preset": "left", "time": {"frames": [0, 9]}})", 9), HasSubstr("/time/frames/1"));
  EXPECT_THAT(build_error(R"({"preset": "left", "time": {"from": 0, "to": 9}})", 9), HasSubstr("/time/to"));
}

TEST(BuildPath, follows_the_moving_source) {
  const auto source = moving_source(9, {5, 6, 7});
  const TrajectorySpec still = parse_trajectory(R"({"preset": "still", "follow_source": true})", "t");
  const PathContext context = make_context(still, intrinsics, size, source, 9, 2, false);
  const TargetPath follows = build_path(still, context);
  for (std::size_t k = 0; k < 9; ++k) EXPECT_EQ(pose(follows, k), context.subject_from_source[k]) << k;

  const TrajectorySpec left = parse_trajectory(R"({"preset": "left", "follow_source": true})", "t");
  const TargetPath moved = build_path(left, context);
  const TargetPath fixed = build_path(trajectory_from_preset("left"), context);
  for (std::size_t k = 0; k < 9; ++k) {
    const Rigid3 cam_from_target = context.subject_from_source[k].inverse() * pose(moved, k);
    const Rigid3 cam0_from_target = context.subject_from_source[0].inverse() * pose(fixed, k);
    EXPECT_LT(difference(cam_from_target, cam0_from_target), 1e-12) << k;
  }
}

TEST(BuildPath, explicit_source_cameras_are_the_source_cameras) {
  const auto source = moving_source(5, {1e7, -1e7, 1e7});
  TrajectorySpec spec;
  spec.elevation = 7;
  spec.frame_of_reference = FrameOfReference::source_world;
  CameraMotion motion;
  for (const Rigid3& world_from_cam : source) motion.cameras.push_back({world_from_cam, {}, {}, {}});
  motion.cameras[1].intrinsics = Intrinsics{350, 347.5, 205, 118};
  motion.cameras[1].size = Size{416, 240};
  motion.cameras[2].fov = 90;
  spec.motion = motion;
  const PathContext context = make_context(spec, intrinsics, size, source, 5, 2, false);
  const TargetPath path = build_path(spec, context);
  for (std::size_t k = 0; k < 5; ++k) EXPECT_EQ(pose(path, k), context.subject_from_source[k]) << k;
  EXPECT_EQ(path.frames[1].camera.intrinsics, intrinsics) << "scaled from half the size";
  EXPECT_NEAR(path.frames[2].camera.intrinsics.fx, 416, 1e-9) << "90 degrees over 832 pixels";
  EXPECT_NEAR((pose(path, 1).translation - pose(path, 0).translation).norm(),
              (source[1].translation - source[0].translation).norm(), 1e-8);
  spec.frames = 6;
  EXPECT_THROW(build_path(spec, context), Error);
  spec.motion = CameraMotion{{}, "cams.json"};
  EXPECT_THROW(build_path(spec, context), std::invalid_argument);
}

TEST(Keyframes, are_passed_exactly) {
  const TargetPath path = path_of(R"({"frames": 11, "keyframes": [
    {"frame": 0, "position": [0, 0, -2]},
    {"frame": 4, "position": [1, -1, -2], "look_at": [0, 0, 1], "roll": 10, "focal": 2},
    {"frame": 10, "world_from_cam": [0,0,1,3, 0,1,0,0.5, -1,0,0,1, 0,0,0,1], "fov": 60}]})");
  EXPECT_EQ(pose(path, 0), Rigid3({Eigen::Matrix3d::Identity(), {0, 0, -2}}));
  EXPECT_EQ(pose(path, 4).translation, Eigen::Vector3d(1, -1, -2));
  EXPECT_LT((pose(path, 4).rotation.col(2) - Eigen::Vector3d(-1, 1, 3).normalized()).norm(), 1e-12);
  EXPECT_NEAR(path.frames[4].camera.intrinsics.fx, 1400, 1e-9);
  EXPECT_EQ(pose(path, 10).translation, Eigen::Vector3d(3, 0.5, 1));
  EXPECT_EQ(pose(path, 10).rotation.col(2), Eigen::Vector3d(1, 0, 0));
  EXPECT_NEAR(path.frames[10].camera.intrinsics.fx, 416 / std::tan(M_PI / 6), 1e-9);
}

TEST(Keyframes, on_the_sphere_follow_its_arc) {
  const TargetPath path = path_of(R"({"frames": 81, "keyframes": [{}, {"phi": 360, "theta": 0}]})");
  for (std::size_t k = 0; k < 81; ++k) EXPECT_NEAR(pose(path, k).translation.norm(), 2, 1e-12) << k;
  EXPECT_NEAR(pose(path, 40).translation.z(), 2, 1e-12);
  EXPECT_LT(pose(path, 20).translation.x(), -1.99) << "phi > 0 is left";
  // The same move as the official free path, whose turn has no lag.
  const TargetPath keys = path_of(R"({"frames": 81, "elevation": 5, "keyframes": [{}, {"phi": 50, "theta": -10}]})");
  const TargetPath free = path_of(R"({"frames": 81, "elevation": 5, "free": {"d_phi": 50, "d_theta": -10}})");
  for (std::size_t k = 0; k < 81; ++k) EXPECT_LT(difference(pose(keys, k), pose(free, k)), 1e-12) << k;
}

TEST(Keyframes, overhead_and_upside_down_are_fine_on_the_sphere) {
  const TargetPath path =
      path_of(R"({"frames": 5, "keyframes": [{}, {"theta": -90}, {"theta": -120}, {"position": [0, 0, -2]}]})");
  for (const TargetFrame& frame : path.frames) {
    const Rigid3& p = frame.camera.world_from_cam;
    EXPECT_LT((p.rotation.transpose() * p.rotation - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff(), 1e-12);
  }
}

TEST(Keyframes, keep_what_they_look_at_in_the_middle) {
  const TargetPath path = path_of(R"({"frames": 50, "keyframes": [
    {"position": [-2, 0, -2]}, {"position": [0, -1, -1.5], "look_at": "subject"}, {"position": [2, 0, -2]}]})");
  for (std::size_t k = 0; k < 50; ++k) {
    const Eigen::Vector3d subject_in_cam = pose(path, k).inverse() * Eigen::Vector3d::Zero();
    EXPECT_LT(subject_in_cam.head<2>().norm(), 1e-12) << k;
    EXPECT_GT(subject_in_cam.z(), 1) << k;
    EXPECT_NEAR(pose(path, k).rotation(1, 0), 0, 1e-15) << k;
  }
}

TEST(Keyframes, one_and_two_and_repeated_ones_work) {
  for (const long frames : {1L, 2L, 3L, 2000L}) {
    SCOPED_TRACE(frames);
    const std::string n = std::to_string(frames);
    EXPECT_EQ(path_of(R"({"frames": )" + n + R"(, "keyframes": [{"position": [1, 0, -3]}]})").frames.size(), frames);
    const TargetPath two = path_of(R"({"frames": )" + n + R"(, "keyframes": [{}, {"phi": 20}]})");
    EXPECT_EQ(pose(two, 0).translation, Eigen::Vector3d(0, 0, -2));
    const double end = frames > 1 ? -2 * std::sin(M_PI / 9) : 0.0;
    EXPECT_NEAR(pose(two, two.frames.size() - 1).translation.x(), end, 1e-12);
  }
  const TargetPath pause = path_of(R"({"frames": 31, "keyframes": [{}, {"phi": 20}, {"phi": 20}, {"phi": 40}]})");
  for (std::size_t k = 10; k <= 20; ++k) EXPECT_EQ(pose(pause, k), pose(pause, 10)) << k;
}

TEST(Keyframes, wait_before_the_first_and_after_the_last) {
  const TargetPath path = path_of(R"({"frames": 11, "keyframes": [{"at": 0.3, "phi": 10}, {"at": 0.6, "phi": 20}]})");
  for (const std::size_t k : {0, 1, 2}) EXPECT_EQ(pose(path, k), pose(path, 3));
  for (const std::size_t k : {7, 8, 10}) EXPECT_EQ(pose(path, k), pose(path, 6));
}

TEST(Keyframes, easing_slows_the_ends_and_never_goes_back) {
  for (const std::string_view name : easing_names()) {
    const TargetPath path = path_of(fmt::format(
        R"({{"frames": 101, "keyframes": [{{"phi": 0, "easing": "{0}"}}, {{"phi": -40, "easing": "{0}"}}, {{"phi": -80}}]}})",
        name));
    for (std::size_t k = 1; k < 101; ++k)
      EXPECT_GE(pose(path, k).translation.x(), pose(path, k - 1).translation.x() - 1e-12) << name << ", frame " << k;
    EXPECT_NEAR(pose(path, 50).translation.x(), 2 * std::sin(40 * M_PI / 180), 1e-12) << name;
  }
}

TEST(Keyframes, refuse_what_has_no_answer) {
  EXPECT_THAT(build_error(R"({"keyframes": [{}, {"position": [0, 0, 0]}]})"), HasSubstr("/keyframes/1/position"));
  EXPECT_THAT(build_error(R"({"keyframes": [{"position": [1, 1, 1], "look_at": [1, 1, 1]}]})"),
              HasSubstr("/keyframes/0/look_at"));
  EXPECT_THAT(build_error(R"({"keyframes": [{"position": [0, -3, 0], "look_at": "subject"}]})"),
              HasSubstr("straight up or down"));
  EXPECT_THAT(build_error(R"({"frames": 5, "keyframes": [{"position": [0, 0, -2]}, {"position": [0, 0, 2]}]})"),
              HasSubstr("/keyframes/0: between this keyframe and the next, in frame 2"));
  EXPECT_THAT(build_error(R"({"keyframes": [{"position": [0, 0, 0], "rotation": [1, 0, 0, 0]},
                                            {"position": [0, 0, 1], "rotation": [0, 0, 1, 0]}]})"),
              HasSubstr("/keyframes/1: the camera is turned by half a turn"));
  EXPECT_THAT(build_error(R"({"frames": 10, "keyframes": [{"frame": 0}, {"frame": 10}]})"),
              HasSubstr("/keyframes/1/frame"));
  EXPECT_THAT(build_error(R"({"frames": 11, "keyframes": [{"at": 0.5}, {"frame": 5}]})"), HasSubstr("/keyframes/1"));
}

TEST(Keyframes, use_the_source_world_and_units) {
  const auto source = moving_source(3, {1e7, 2e7, -3e7});
  const PathContext context = make_context({}, intrinsics, size, source, 3, 2, false);
  TrajectorySpec spec;
  spec.frame_of_reference = FrameOfReference::source_world;
  const Eigen::Vector3d ahead = source[1] * Eigen::Vector3d(0, 0, 4);
  spec.motion = KeyframeMotion{{{.place = source[0]},
                                {.place = source[1].translation, .aim = ahead},
                                {.place = source[2].translation, .aim = source[2].rotation}}};
  const TargetPath path = build_path(spec, context);
  EXPECT_EQ(pose(path, 0), context.subject_from_source[0]);
  EXPECT_LT((pose(path, 1).rotation.col(2) - context.subject_from_source[1].rotation.col(2)).norm(), 1e-8);
  EXPECT_LT(difference(pose(path, 2), context.subject_from_source[2]), 1e-8);

  const TargetPath radii =
      path_of(R"({"frames": 2, "units": "radius", "keyframes": [{"position": [0, 0, -1]}, {"position": [1, 0, -1]}]})");
  EXPECT_EQ(pose(radii, 1).translation, Eigen::Vector3d(2, 0, -2));
}

TEST(Keyframes, work_at_extreme_scales_and_fields_of_view) {
  for (const double radius : {1e-6, 1.0, 1e9}) {
    const TargetPath path = path_of(R"({"frames": 9, "units": "radius", "keyframes": [
      {"position": [0, 0, -1], "fov": 1}, {"position": [0.5, 0.1, -1], "fov": 170}, {"phi": -40}]})",
                                    9, radius);
    for (const TargetFrame& frame : path.frames) {
      EXPECT_TRUE(frame.camera.world_from_cam.matrix().allFinite());
      EXPECT_GT(frame.camera.intrinsics.fx, 0);
      EXPECT_NEAR(frame.camera.world_from_cam.translation.norm() / radius, 1, 0.3);
    }
    EXPECT_NEAR(path.frames[0].camera.intrinsics.fx, 416 / std::tan(0.5 * M_PI / 180), 1e-6);
    EXPECT_NEAR(path.frames[4].camera.intrinsics.fx, 416 / std::tan(85 * M_PI / 180), 1e-9);
  }
}

TEST(MakeContext, needs_a_radius) {
  const Rigid3 still;
  const auto context = [&](const TrajectorySpec& spec, double depth) {
    return make_context(spec, intrinsics, size, {&still, 1}, 3, depth, false);
  };
  EXPECT_EQ(context({}, 2.5).world.radius(), 2.5);
  EXPECT_THROW(context({}, 0), Error);
  EXPECT_THROW(context({}, NAN), Error);
  TrajectorySpec spec;
  spec.radius = 7;
  EXPECT_EQ(context(spec, 0).world.radius(), 7);
  const std::vector<Rigid3> two(2);
  EXPECT_THROW(make_context({}, intrinsics, size, two, 3, 1, false), std::invalid_argument);
  EXPECT_THROW(make_context({}, {0, 1, 0, 0}, size, {&still, 1}, 3, 1, false), std::invalid_argument);
  EXPECT_THROW(make_context({}, intrinsics, {0, 1}, {&still, 1}, 3, 1, false), std::invalid_argument);
}

TEST(Summarize, tells_departing_paths_from_returning_ones) {
  const auto summary = [](std::string_view json) {
    const TrajectorySpec spec = parse_trajectory(json, "t");
    const PathContext context = still_source(spec);
    return summarize(build_path(spec, context), context);
  };
  const PathSummary left = summary(R"({"preset": "left"})");
  EXPECT_TRUE(left.monotone());
  EXPECT_NEAR(left.max_rotation_deg, 30, 1e-9);
  EXPECT_NEAR(left.max_translation, 2 * std::sin(15 * M_PI / 180), 1e-12);
  const PathSummary orbit = summary(R"({"frames": 81, "preset": "orbit"})");
  EXPECT_FALSE(orbit.monotone());
  EXPECT_NEAR(static_cast<double>(orbit.first_return), 41, 3);
  EXPECT_NEAR(orbit.max_rotation_deg, 180, 1e-9);
  EXPECT_FALSE(summary(R"({"preset": "swing1"})").monotone());
  EXPECT_TRUE(summary(R"({"preset": "still"})").monotone());
  EXPECT_TRUE(summary(R"({"preset": "zoom_in"})").monotone());
  EXPECT_NEAR(summary(R"({"frames": 81, "keyframes": [{}, {"focal": 2}]})").max_zoom, 2, 1e-12);
  EXPECT_EQ(summary(R"({"preset": "still"})").max_translation, 0);
}

}  // namespace
}  // namespace uwv
