// SPDX-License-Identifier: Apache-2.0
// The two plain-text formats: TUM trajectories and Redwood (Open3D) logs.
#include <array>
#include <charconv>
#include <cmath>
#include <vector>

#include "io/cameras_formats.h"
#include "io/printable.h"

namespace uwv::io {
namespace {

/// The lines that hold something: no comments, no blanks.
class Lines {
 public:
  explicit Lines(const CamerasText& file) : file_(file), rest_(file.text) {}

  /// Moves to the next such line; false at the end.
  bool next() {
    while (!rest_.empty()) {
      const auto end = rest_.find('\n');
      line_ = rest_.substr(0, end);
      rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end + 1);
      ++number_;
      const auto first = line_.find_first_not_of(blanks);
      if (first != std::string_view::npos && line_[first] != '#') return true;
    }
    return false;
  }

  std::string where() const { return fmt::format("{}: line {}", file_.path, number_); }

  /// The line's numbers, exactly N of them and all finite.
  template <std::size_t N>
  std::array<double, N> numbers(std::string_view wanted) const {
    std::array<double, N> values{};
    std::size_t count = 0;
    for (std::string_view rest = line_;; ++count) {
      const auto first = rest.find_first_not_of(blanks);
      if (first == std::string_view::npos) break;
      rest.remove_prefix(first);
      const std::string_view word = rest.substr(0, rest.find_first_of(blanks));
      rest.remove_prefix(word.size());
      if (count < N) values[count] = number(word, wanted);
    }
    if (count != N) fail(ErrorCode::file_damaged, "{} has {} values; {} are wanted ({})", where(), count, N, wanted);
    return values;
  }

 private:
  static constexpr std::string_view blanks = " \t\r";

  double number(std::string_view word, std::string_view wanted) const {
    const std::string_view digits = word.starts_with('+') ? word.substr(1) : word;
    double value = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (error != std::errc{} || end != digits.data() + digits.size())
      fail(ErrorCode::file_damaged, "{} holds '{}' where a number is wanted ({})", where(), printable(word), wanted);
    if (!std::isfinite(value))
      fail(ErrorCode::value_invalid, "{} holds {}; finite numbers are wanted ({})", where(), printable(word), wanted);
    return value;
  }

  const CamerasText& file_;
  std::string_view rest_, line_;
  long number_ = 0;
};

Camera camera_from_options(const CamerasText& file, const Rigid3& world_from_cam, const std::string& where) {
  if (!file.options.intrinsics)
    fail(ErrorCode::value_invalid,
         "{}: this format holds poses only; state the intrinsics and the pictures' size beside it", file.path);
  return make_camera(*file.options.intrinsics, file.options.size, world_from_cam, file.options, where);
}

/// Not necessarily of unit length, as text is rounded; but far from it the numbers are something else.
Eigen::Matrix3d rotation_from(double qx, double qy, double qz, double qw, const std::string& where) {
  const Eigen::Quaterniond q(qw, qx, qy, qz);  // Eigen takes the real part first
  constexpr double tolerance = 0.01;
  const double norm = q.norm();
  if (!(std::abs(norm - 1) <= tolerance))
    fail(ErrorCode::value_invalid, "{}: the quaternion's length is {:.6g}; 1 is wanted (order: qx qy qz qw)", where,
         norm);
  return q.normalized().toRotationMatrix();
}

}  // namespace

CameraTrack read_tum(const CamerasText& file) {
  CameraTrack track;
  for (Lines lines(file); lines.next();) {
    const auto [t, x, y, z, qx, qy, qz, qw] = lines.numbers<8>("t x y z qx qy qz qw");
    const Rigid3 world_from_cam{rotation_from(qx, qy, qz, qw, lines.where()), {x, y, z}};
    track.cameras.push_back(camera_from_options(file, world_from_cam, lines.where()));
    track.times.push_back(t);
  }
  return track;
}

std::string format_tum(const CameraTrack& track) {
  std::string text = "# world_from_cam, OpenCV camera axes (x right, y down, z forward)\n# t x y z qx qy qz qw\n";
  for (std::size_t i = 0; i < track.cameras.size(); ++i) {
    const Rigid3& pose = track.cameras[i].world_from_cam;
    const Eigen::Quaterniond q = Eigen::Quaterniond(pose.rotation).normalized();
    text += fmt::format("{} {} {} {} {} {} {} {}\n", track.times[i], pose.translation.x(), pose.translation.y(),
                        pose.translation.z(), q.x(), q.y(), q.z(), q.w());
  }
  return text;
}

CameraTrack read_redwood(const CamerasText& file) {
  CameraTrack track;
  for (Lines lines(file); lines.next();) {
    (void)lines.numbers<3>("three whole numbers of metadata");
    const std::string where = fmt::format("{}: frame {}", lines.where(), track.cameras.size());
    Eigen::Matrix4d world_from_cam;
    for (int row = 0; row < 4; ++row) {
      if (!lines.next())
        fail(ErrorCode::file_damaged, "{} has {} of 4 matrix rows; the file was cut short", where, row);
      const auto values = lines.numbers<4>("a row of the 4x4 pose");
      world_from_cam.row(row) = Eigen::Map<const Eigen::RowVector4d>(values.data());
    }
    track.times.push_back(static_cast<double>(track.cameras.size()));
    track.cameras.push_back(camera_from_options(file, Rigid3::from_matrix(world_from_cam, where), where));
  }
  return track;
}

std::string format_redwood(const CameraTrack& track) {
  std::string text;
  for (std::size_t i = 0; i < track.cameras.size(); ++i) {
    text += fmt::format("{} {} {}\n", i, i, i + 1);
    const Eigen::Matrix4d m = track.cameras[i].world_from_cam.matrix();
    for (int row = 0; row < 4; ++row) text += fmt::format("{} {} {} {}\n", m(row, 0), m(row, 1), m(row, 2), m(row, 3));
  }
  return text;
}

}  // namespace uwv::io
