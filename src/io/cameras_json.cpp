// SPDX-License-Identifier: Apache-2.0
// The two JSON formats: our own and nerfstudio's transforms.json.
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "io/cameras_formats.h"
#include "io/image_sequence.h"
#include "io/json_fields.h"
#include "io/printable.h"

namespace uwv::io {
namespace {

using nlohmann::json;
using nlohmann::ordered_json;

constexpr int max_side = 1 << 20;
constexpr const char* our_convention = "opencv, world_from_cam, pixel centres at +0.5";

/// Takes turns y and z: from OpenGL camera axes to OpenCV's, and back.
const Eigen::DiagonalMatrix<double, 4> gl_cam_from_cv_cam{1, -1, -1, 1};

/// Key of `frame` if it is there, else the file's global one.
std::optional<double> frame_or_global(const JsonPlace& frame, const JsonPlace& root, const char* key) {
  const auto own = frame.optional_number(key);
  return own ? own : root.optional_number(key);
}

Size nerfstudio_size(const JsonPlace& frame, const JsonPlace& root, const CamerasFileOptions& options) {
  const auto side = [&](const char* key, int otherwise) {
    const JsonPlace& place = frame.has(key) ? frame : root;
    return place.has(key) ? place.at(key).positive(max_side) : otherwise;
  };
  const Size size{side("w", options.size.width), side("h", options.size.height)};
  if (size.width == 0 || size.height == 0)
    fail(ErrorCode::value_invalid, "{} has no w and h; add them or state the pictures' size", root.where());
  return size;
}

Intrinsics nerfstudio_intrinsics(const JsonPlace& frame, const JsonPlace& root, Size size) {
  const auto focal = [&](const char* length_key, const char* angle_key, int side) -> std::optional<double> {
    if (const auto length = frame_or_global(frame, root, length_key)) return length;
    const auto angle = frame_or_global(frame, root, angle_key);
    if (!angle) return std::nullopt;
    if (!(*angle > 0 && *angle < M_PI))
      fail(ErrorCode::value_invalid, "{}: {} is {}; an angle between 0 and pi is wanted", frame.where(), angle_key,
           *angle);
    return 0.5 * side / std::tan(0.5 * *angle);
  };
  auto fx = focal("fl_x", "camera_angle_x", size.width), fy = focal("fl_y", "camera_angle_y", size.height);
  if (!fx && !fy)
    fail(ErrorCode::value_invalid, "{} has neither fl_x nor camera_angle_x, and the file no global one", frame.where());
  if (!fx) fx = fy;
  if (!fy) fy = fx;
  return {*fx, *fy, frame_or_global(frame, root, "cx").value_or(0.5 * size.width),
          frame_or_global(frame, root, "cy").value_or(0.5 * size.height)};
}

Rigid3 nerfstudio_pose(const JsonPlace& place) {
  Eigen::Matrix4d world_from_gl_cam = Eigen::Matrix4d::Identity();
  const std::size_t rows = place.require_array().value.size();
  if (rows != 3 && rows != 4)
    fail(ErrorCode::value_invalid, "{} has {} rows; a 4x4 matrix is wanted", place.where(), rows);
  for (std::size_t row = 0; row < rows; ++row) {
    const JsonPlace cells = place.at(row);
    if (cells.require_array().value.size() != 4)
      fail(ErrorCode::value_invalid, "{} has {} columns; a 4x4 matrix is wanted", cells.where(), cells.value.size());
    for (std::size_t column = 0; column < 4; ++column)
      world_from_gl_cam(static_cast<int>(row), static_cast<int>(column)) = cells.at(column).number();
  }
  return Rigid3::from_matrix(world_from_gl_cam * gl_cam_from_cv_cam, place.where());
}

void check_lens(const JsonPlace& place, bool& distorted) {
  for (const char* key : {"k1", "k2", "k3", "k4", "p1", "p2"}) distorted |= place.optional_number(key).value_or(0) != 0;
  if (!place.has("camera_model")) return;
  const std::string& model = place.at("camera_model").string();
  for (const char* pinhole : {"OPENCV", "PINHOLE", "SIMPLE_PINHOLE", "RADIAL", "SIMPLE_RADIAL", "PERSPECTIVE"})
    if (model == pinhole) return;
  fail(ErrorCode::value_invalid, "{}/camera_model is '{}'; a pinhole camera is wanted (undistort the pictures first)",
       place.where(), printable(model));
}

}  // namespace

CameraTrack read_uwv_cameras(const json& value, const std::string& path, const CamerasFileOptions& options) {
  const JsonPlace root{value, path, ""};
  if (root.at("uwv_cameras").number() != 1)
    fail(ErrorCode::value_invalid, "{} is {}; version 1 is the one known", root.at("uwv_cameras").where(),
         root.at("uwv_cameras").number());
  const JsonPlace convention = root.at("convention");
  if (convention.string() != our_convention)
    fail(ErrorCode::value_invalid, "{} is '{}'; '{}' is wanted", convention.where(), printable(convention.string()),
         our_convention);
  const Size size{root.at("width").positive(max_side), root.at("height").positive(max_side)};
  const JsonPlace frames = root.at("frames");
  CameraTrack track;
  for (std::size_t i = 0; i < frames.require_array().value.size(); ++i) {
    const JsonPlace frame = frames.at(i);
    if (frame.at("index").number() != static_cast<double>(i))
      fail(ErrorCode::value_invalid, "{} is {}; frames are numbered 0, 1, 2, ...", frame.at("index").where(),
           frame.at("index").number());
    const JsonPlace pose = frame.at("world_from_cam");
    if (pose.require_array().value.size() != 16)
      fail(ErrorCode::value_invalid, "{} has {} numbers; 16 are wanted, row by row", pose.where(), pose.value.size());
    Eigen::Matrix4d world_from_cam;
    for (std::size_t k = 0; k < 16; ++k)
      world_from_cam(static_cast<int>(k / 4), static_cast<int>(k % 4)) = pose.at(k).number();
    const Intrinsics intrinsics{frame.at("fx").number(), frame.at("fy").number(), frame.at("cx").number(),
                                frame.at("cy").number()};
    track.cameras.push_back(
        make_camera(intrinsics, size, Rigid3::from_matrix(world_from_cam, pose.where()), options, frame.where()));
    track.times.push_back(frame.at("time").number());
  }
  return track;
}

std::string format_uwv_cameras(const CameraTrack& track) {
  const Size size = track.cameras[0].size;
  ordered_json root = {
      {"uwv_cameras", 1}, {"convention", our_convention}, {"width", size.width}, {"height", size.height}};
  ordered_json& frames = root["frames"] = ordered_json::array();
  for (std::size_t i = 0; i < track.cameras.size(); ++i) {
    const Camera& camera = track.cameras[i];
    require(camera.size == size, "camera {} is for {}x{} pixels, the first for {}x{}; one size is wanted", i,
            camera.size.width, camera.size.height, size.width, size.height);
    const Eigen::Matrix<double, 4, 4, Eigen::RowMajor> m = camera.world_from_cam.matrix();
    frames.push_back({{"index", i},
                      {"time", track.times[i]},
                      {"fx", camera.intrinsics.fx},
                      {"fy", camera.intrinsics.fy},
                      {"cx", camera.intrinsics.cx},
                      {"cy", camera.intrinsics.cy},
                      {"world_from_cam", std::vector<double>(m.data(), m.data() + 16)}});
  }
  return root.dump(1) + "\n";
}

CameraTrack read_nerfstudio(const json& value, const std::string& path, const CamerasFileOptions& options,
                            Monitor& monitor) {
  const JsonPlace root{value, path, ""};
  const JsonPlace frames = root.at("frames");
  const std::size_t count = frames.require_array().value.size();
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::vector<std::string> names;
  for (std::size_t i = 0; i < count; ++i) names.push_back(frames.at(i).at("file_path").string());
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return natural_less(names[a], names[b]); });

  CameraTrack track;
  bool distorted = false;
  check_lens(root, distorted);
  for (const std::size_t i : order) {
    const JsonPlace frame = frames.at(i);
    check_lens(frame, distorted);
    const Size size = nerfstudio_size(frame, root, options);
    track.times.push_back(static_cast<double>(track.cameras.size()));
    track.cameras.push_back(make_camera(nerfstudio_intrinsics(frame, root, size), size,
                                        nerfstudio_pose(frame.at("transform_matrix")), options, frame.where()));
  }
  if (distorted)
    monitor.warn(
        fmt::format("{}: states lens distortion, which is ignored; undistort the pictures for exact results", path));
  return track;
}

std::string format_nerfstudio(const CameraTrack& track) {
  ordered_json root = {{"camera_model", "PINHOLE"}};
  ordered_json& frames = root["frames"] = ordered_json::array();
  for (std::size_t i = 0; i < track.cameras.size(); ++i) {
    const Camera& camera = track.cameras[i];
    const Eigen::Matrix4d world_from_gl_cam = camera.world_from_cam.matrix() * gl_cam_from_cv_cam;
    ordered_json rows = ordered_json::array();
    for (int row = 0; row < 4; ++row)
      rows.push_back(std::array{world_from_gl_cam(row, 0), world_from_gl_cam(row, 1), world_from_gl_cam(row, 2),
                                world_from_gl_cam(row, 3)});
    frames.push_back({{"file_path", fmt::format("images/{:05}.png", i)},
                      {"w", camera.size.width},
                      {"h", camera.size.height},
                      {"fl_x", camera.intrinsics.fx},
                      {"fl_y", camera.intrinsics.fy},
                      {"cx", camera.intrinsics.cx},
                      {"cy", camera.intrinsics.cy},
                      {"transform_matrix", rows}});
  }
  return root.dump(1) + "\n";
}

}  // namespace uwv::io
