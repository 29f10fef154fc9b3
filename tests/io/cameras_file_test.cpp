// SPDX-License-Identifier: Apache-2.0
#include "uwv/io/cameras_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "io/hostile.h"
#include "support/recording_monitor.h"

namespace uwv {
namespace {

using test::expect_error;
using test::RecordingMonitor;
using test::TempFolder;

/// A path far from the origin with rotations about all axes, one by nearly pi, and a mirrored focal length.
CameraTrack sample_track() {
  CameraTrack track;
  for (int i = 0; i < 12; ++i) {
    const double angle = i == 11 ? M_PI - 1e-9 : 0.3 * i;
    const Eigen::Vector3d axis = Eigen::Vector3d(1, 0.2 * i, -0.5).normalized();
    track.cameras.push_back({{500.25 + i, i == 3 ? -480. : 480, 320.5, 239.75},
                             {Eigen::AngleAxisd(angle, axis).toRotationMatrix(), {1e7 + i / 3., 1e-6 * i, -4}},
                             {640, 480}});
    track.times.push_back(1305031102.1753 + i / 30.);
  }
  return track;
}

CamerasFileOptions pictures_of_640x480() {
  CamerasFileOptions options;
  options.size = {640, 480};
  options.intrinsics = Intrinsics{500, 480, 320.5, 239.75};
  return options;
}

void expect_poses_near(const CameraTrack& got, const CameraTrack& wanted, double tolerance) {
  ASSERT_EQ(got.cameras.size(), wanted.cameras.size());
  for (std::size_t i = 0; i < got.cameras.size(); ++i) {
    const Rigid3 &a = got.cameras[i].world_from_cam, &b = wanted.cameras[i].world_from_cam;
    EXPECT_LE((a.rotation - b.rotation).cwiseAbs().maxCoeff(), tolerance) << "rotation of camera " << i;
    EXPECT_LE((a.translation - b.translation).cwiseAbs().maxCoeff(), tolerance) << "position of camera " << i;
  }
}

class CamerasRoundTrip : public testing::TestWithParam<CamerasFormat> {};

TEST_P(CamerasRoundTrip, GivesTheSameCameras) {
  const TempFolder folder;
  RecordingMonitor monitor;
  const CameraTrack track = sample_track();
  write_cameras(folder.file("c"), track, GetParam());
  const CameraTrack got = read_cameras(folder.file("c"), pictures_of_640x480(), monitor);
  expect_poses_near(got, track, 1e-9);
  EXPECT_TRUE(monitor.warnings.empty());
  const bool has_times = GetParam() == CamerasFormat::uwv || GetParam() == CamerasFormat::tum;
  const bool has_intrinsics = GetParam() == CamerasFormat::uwv || GetParam() == CamerasFormat::nerfstudio;
  for (std::size_t i = 0; i < track.cameras.size(); ++i) {
    EXPECT_EQ(got.times[i], has_times ? track.times[i] : static_cast<double>(i));
    EXPECT_EQ(got.cameras[i].intrinsics,
              has_intrinsics ? track.cameras[i].intrinsics : *pictures_of_640x480().intrinsics);
    EXPECT_EQ(got.cameras[i].size, (Size{640, 480}));
  }
}

TEST_P(CamerasRoundTrip, SurvivesTruncationAndRandomDamage) {
  const TempFolder folder;
  CameraTrack track = sample_track();
  track.cameras.resize(2);
  track.times.resize(2);
  write_cameras(folder.file("c"), track, GetParam());
  RecordingMonitor monitor;
  const auto read = [&](const std::string& path) { read_cameras(path, pictures_of_640x480(), monitor); };
  test::try_truncations(folder.read("c"), "t", read, 5);
  test::try_byte_flips(folder.read("c"), "f", read, 400);
}

INSTANTIATE_TEST_SUITE_P(Formats, CamerasRoundTrip,
                         testing::Values(CamerasFormat::uwv, CamerasFormat::nerfstudio, CamerasFormat::tum,
                                         CamerasFormat::redwood),
                         [](const auto& format) { return std::string(to_string(format.param)); });

TEST(CamerasFile, KnowsItsFormatsByName) {
  EXPECT_EQ(cameras_format_named("tum"), CamerasFormat::tum);
  EXPECT_THROW((void)cameras_format_named("colmap"), std::invalid_argument);
}

TEST(CamerasFile, TumHasTheRealPartLast) {
  const TempFolder folder;
  RecordingMonitor monitor;
  // a quarter turn about z: x_in_cam = (1, 0, 0) points along the world's y; the length is off by rounding
  const std::string path = folder.write("c.txt", "# comment\r\n\n 1.5  1 2 3  0 0 0.7071 0.7071 \r\n");
  const CameraTrack track = read_cameras(path, pictures_of_640x480(), monitor);
  ASSERT_EQ(track.cameras.size(), 1U);
  EXPECT_EQ(track.times[0], 1.5);
  const Rigid3& world_from_cam = track.cameras[0].world_from_cam;
  EXPECT_LE((world_from_cam * Eigen::Vector3d(1, 0, 0) - Eigen::Vector3d(1, 3, 3)).norm(), 1e-12);
}

TEST(CamerasFile, NerfstudioLooksAlongMinusZ) {
  const TempFolder folder;
  RecordingMonitor monitor;
  const std::string path = folder.write("transforms.json", R"({"fl_x": 500, "w": 640, "h": 480, "frames": [
    {"file_path": "f10.png", "transform_matrix": [[1,0,0,10],[0,1,0,0],[0,0,1,0],[0,0,0,1]]},
    {"file_path": "f9.png", "fl_x": 400, "transform_matrix": [[1,0,0,9],[0,1,0,0],[0,0,1,0]]}]})");
  const CameraTrack track = read_cameras(path, {}, monitor);
  ASSERT_EQ(track.cameras.size(), 2U);
  EXPECT_EQ(track.cameras[0].world_from_cam.translation.x(), 9);  // natural order of names
  EXPECT_EQ(track.cameras[0].intrinsics, (Intrinsics{400, 400, 320, 240}));
  EXPECT_EQ(track.cameras[1].intrinsics, (Intrinsics{500, 500, 320, 240}));
  const Eigen::Vector3d ahead = track.cameras[1].world_from_cam * Eigen::Vector3d(0, 1, 1);  // down and forward
  EXPECT_LE((ahead - Eigen::Vector3d(10, -1, -1)).norm(), 1e-15);
}

TEST(CamerasFile, NerfstudioAnglesAndDistortion) {
  const TempFolder folder;
  RecordingMonitor monitor;
  const std::string pose = R"("transform_matrix": [[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]])";
  const std::string path = folder.write("transforms.json", R"({"camera_angle_x": 1.5707963267948966, "k1": 0.01,
    "frames": [{"file_path": "a", )" + pose + "}]}");
  CamerasFileOptions options;
  options.size = {200, 100};
  const CameraTrack track = read_cameras(path, options, monitor);
  EXPECT_NEAR(track.cameras[0].intrinsics.fx, 100, 1e-12);
  EXPECT_NEAR(track.cameras[0].intrinsics.fy, 100, 1e-12);
  ASSERT_EQ(monitor.warnings.size(), 1U);
  EXPECT_THAT(monitor.warnings[0], testing::HasSubstr("distortion"));
  expect_error(ErrorCode::value_invalid, path, [&] { read_cameras(path, {}, monitor); });  // no size anywhere
  const std::string fisheye = folder.write("f.json", R"({"camera_model": "OPENCV_FISHEYE", "fl_x": 5, "w": 2, "h": 2,
    "frames": [{"file_path": "a", )" + pose + "}]}");
  expect_error(ErrorCode::value_invalid, fisheye, [&] { read_cameras(fisheye, {}, monitor); });
}

TEST(CamerasFile, ResizesIntrinsicsToThePictures) {
  const TempFolder folder;
  RecordingMonitor monitor;
  write_cameras(folder.file("c.json"), sample_track(), CamerasFormat::uwv);
  CamerasFileOptions half;
  half.size = {320, 240};
  const CameraTrack track = read_cameras(folder.file("c.json"), half, monitor);
  EXPECT_EQ(track.cameras[0].size, half.size);
  EXPECT_EQ(track.cameras[0].intrinsics, (Intrinsics{250.125, 240, 160.25, 119.875}));
}

TEST(CamerasFile, NamesThePlaceOfBadValues) {
  const TempFolder folder;
  RecordingMonitor monitor;
  const auto refused = [&](ErrorCode code, const std::string& text, const std::string& place) {
    SCOPED_TRACE(text);
    const std::string path = folder.write("c", text);
    expect_error(code, path, [&] { read_cameras(path, pictures_of_640x480(), monitor); });
    try {
      read_cameras(path, pictures_of_640x480(), monitor);
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr(place));
    }
  };
  using enum ErrorCode;
  const auto uwv = [](const std::string& frame) {
    return R"({"uwv_cameras":1,"convention":"opencv, world_from_cam, pixel centres at +0.5","width":4,"height":3,)"
           R"("frames":[{"index":0,"time":0,"fx":5,"fy":5,"cx":2,"cy":1.5,)" +
           frame + "}]}";
  };
  const std::string identity = R"("world_from_cam":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1])";
  refused(value_invalid, uwv(R"("world_from_cam":[1,0,0,0,0,1,0,0,0,0,0,0,0,0,0,1])"), "/frames/0/world_from_cam");
  refused(value_invalid, uwv(R"("world_from_cam":[1,0,0,0,0,1,0,0,0,0,-1,0,0,0,0,1])"), "mirrors");
  refused(value_invalid, uwv(R"("world_from_cam":[1,0,0,0])"), "16 are wanted");
  refused(value_invalid, uwv(R"("world_from_cam":[1,0,0,"x",0,1,0,0,0,0,1,0,0,0,0,1])"), "/frames/0/world_from_cam/3");
  refused(value_invalid, uwv("\"poes\":0"), "/frames/0/world_from_cam is missing");
  refused(file_damaged, uwv("\"fx\":0," + identity), "'fx' twice");
  std::string zero_focal = uwv(identity);
  zero_focal.replace(zero_focal.find("\"fx\":5"), 6, "\"fx\":0");
  refused(value_invalid, zero_focal, "/frames/0");
  std::string huge = uwv(identity);
  huge.replace(huge.find("\"fx\":5"), 6, "\"fx\":1e999");
  refused(file_damaged, huge, "JSON");
  refused(value_invalid, R"({"uwv_cameras":2,"frames":[]})", "/uwv_cameras");
  refused(value_invalid, R"({"frames":[]})", "no camera");
  refused(value_invalid, R"({"frames":3})", "/frames must be an array");
  refused(value_invalid, R"({"frames":[{"file_path":"a","transform_matrix":[[1]]}], "fl_x":1})", "/transform_matrix");
  refused(format_unknown, R"({"cameras":[]})", "uwv_cameras");
  refused(file_damaged, "{", "JSON");
  refused(format_unknown, "", "no cameras");
  refused(format_unknown, "some words that are no cameras", "no cameras");
  refused(value_invalid, "0 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 0\n", "line 2");
  refused(value_invalid, "0 0 0 nan 0 0 0 1\n", "line 1");
  refused(file_damaged, "0 0 0 0 0 0 0 1\n0 0 0 0 0 0 0\n", "line 2");
  refused(file_damaged, "0 0 0 0 0 0 0 x\n", "'x'");
  refused(file_damaged, "0 0 1\n1 0 0 0\n0 1 0 0\n", "2 of 4");
  refused(value_invalid, "0 0 1\n1 0 0 0\n0 1 0 0\n0 0 2 0\n0 0 0 1\n", "frame 0");
}

TEST(CamerasFile, TextFormatsNeedIntrinsics) {
  const TempFolder folder;
  RecordingMonitor monitor;
  const std::string path = folder.write("c.txt", "0 0 0 0 0 0 0 1\n");
  expect_error(ErrorCode::value_invalid, path, [&] { read_cameras(path, {}, monitor); });
  CamerasFileOptions no_size;
  no_size.intrinsics = Intrinsics{1, 1, 0, 0};
  EXPECT_THROW(read_cameras(path, no_size, monitor), std::invalid_argument);
  EXPECT_THROW(write_cameras(folder.file("o"), {}, CamerasFormat::tum), std::invalid_argument);
  expect_error(ErrorCode::output_failed, folder.file("none/o"),
               [&] { write_cameras(folder.file("none/o"), sample_track(), CamerasFormat::tum); });
}

}  // namespace
}  // namespace uwv
