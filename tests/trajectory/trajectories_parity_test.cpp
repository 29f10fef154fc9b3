// SPDX-License-Identifier: Apache-2.0
// Compares the official paths with what the official code returned. UWV_FIXTURES=DIR reads DIR/trajectories instead of
// the copy in tests/data. Which cases there are is read from the folder's own tables.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "uwv/io/safetensors.h"
#include "uwv/trajectory/orbit.h"
#include "uwv/trajectory/smoothing_spline.h"
#include "uwv/trajectory/subject_world.h"

namespace uwv {
namespace {

using nlohmann::json;

constexpr double camera_tolerance = 5e-6;  // relative to 1 + |t|: the reference builds float32 matrices
constexpr double spline_tolerance = 1e-9;  // float64

std::filesystem::path folder() {
  const char* set = std::getenv("UWV_FIXTURES");
  return std::filesystem::path(set != nullptr ? set : UWV_TEST_DATA) / "trajectories";
}

json read_json(const std::string& file) {
  std::ifstream stream(folder() / file);
  EXPECT_TRUE(stream.good()) << "cannot open " << folder() / file;
  return json::parse(stream);
}

SafeTensors open(const std::string& file) { return SafeTensors::open((folder() / file).string()); }

/// The largest deviation of a run of matrices from row-major golden ones, and where it is.
struct Worst {
  double value = 0;
  std::string place = "nowhere";
  void see(double deviation, const std::string& where) {
    if (deviation <= value) return;
    value = deviation;
    place = where;
  }
};

void compare_poses(const std::vector<Rigid3>& poses, const std::vector<double>& golden) {
  ASSERT_EQ(golden.size(), poses.size() * 16);
  Worst worst;
  for (std::size_t k = 0; k < poses.size(); ++k) {
    const Eigen::Matrix4d m = poses[k].matrix();
    const double scale = 1 + poses[k].translation.norm();
    for (int row = 0; row < 4; ++row)
      for (int column = 0; column < 4; ++column)
        worst.see(std::abs(m(row, column) - golden[16 * k + 4 * row + column]) / scale,
                  fmt::format("frame {}, row {}, column {}", k, row, column));
  }
  EXPECT_LE(worst.value, camera_tolerance) << "worst at " << worst.place;
}

void compare_intrinsics(const Eigen::Matrix3d& base, const std::vector<double>& zoom,
                        const std::vector<double>& golden) {
  ASSERT_EQ(golden.size(), zoom.size() * 9);
  Worst worst;
  for (std::size_t k = 0; k < zoom.size(); ++k) {
    Eigen::Matrix3d expected = base;
    expected.topLeftCorner<2, 2>() *= zoom[k];
    for (int row = 0; row < 3; ++row)
      for (int column = 0; column < 3; ++column)
        worst.see(
            std::abs(expected(row, column) - golden[9 * k + 3 * row + column]) / (1 + std::abs(expected(row, column))),
            fmt::format("frame {}, row {}, column {}", k, row, column));
  }
  EXPECT_LE(worst.value, camera_tolerance) << "worst at " << worst.place;
}

Eigen::Matrix3d matrix3(const json& rows) {
  Eigen::Matrix3d m;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column) m(row, column) = rows[row][column];
  return m;
}

Rigid3 pose(const std::vector<double>& golden) {
  return Rigid3::from_matrix(Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(golden.data()), "golden");
}

CameraPath official_path(const json& call, bool zoom_twice) {
  const Rigid3 start = initial_camera(call.at("elevation"), call.at("radius"));
  const double offset_radius = call.at("radius").get<double>() * call.value("radius_scale", 1.0);
  const std::string kind = call.at("traj_type");
  if (kind != "custom") return preset_path(kind, call.at("focal_length"), start, offset_radius, call.at("nframe"));
  const FreeMove move{.d_phi = call.at("d_phi"),
                      .d_theta = call.at("d_theta"),
                      .d_r = call.at("d_r"),
                      .x = call.at("x_offset"),
                      .y = call.at("y_offset"),
                      .z = call.at("z_offset"),
                      .focal = call.at("focal_length"),
                      .zoom_twice = zoom_twice};
  return free_path(move, start, offset_radius, call.at("nframe"));
}

TEST(trajectories, build_cameras) {
  const json table = read_json("build_cameras/calls.json");
  const SafeTensors golden = open("build_cameras/cameras.safetensors");
  ASSERT_FALSE(table.at("calls").empty());
  for (const auto& [name, call] : table.at("calls").items()) {
    SCOPED_TRACE(name);
    const CameraPath path = official_path(call, false);
    const Rigid3& start = path.subject_from_cam.front();
    compare_poses({start}, golden.as_double(name + ".c2w_0"));
    compare_poses({start.inverse()}, golden.as_double(name + ".w2c_0"));
    compare_poses(path.subject_from_cam, golden.as_double(name + ".c2ws"));
    std::vector<Rigid3> inverse;
    for (const Rigid3& subject_from_cam : path.subject_from_cam) inverse.push_back(subject_from_cam.inverse());
    compare_poses(inverse, golden.as_double(name + ".w2cs"));
    compare_intrinsics(matrix3(table.at("intrinsic")), path.zoom, golden.as_double(name + ".intrinsics"));
  }
}

TEST(trajectories, photo_mode_zooms_twice) {
  const json pair = read_json("build_cameras/single_view_pair.json");
  const json table = read_json("build_cameras/calls.json");
  const SafeTensors golden = open("build_cameras/single_view_pair.safetensors");
  const CameraPath once = official_path(pair.at("forward"), false);
  const CameraPath twice = official_path(pair.at("forward"), true);
  const CameraPath reverse = official_path(pair.at("reverse"), true);
  const Eigen::Matrix3d base = matrix3(table.at("intrinsic"));
  compare_poses(twice.subject_from_cam, golden.as_double("c2ws"));
  compare_poses(reverse.subject_from_cam, golden.as_double("c2ws_reverse"));
  compare_intrinsics(base, once.zoom, golden.as_double("intrinsics_after_first"));
  compare_intrinsics(base, twice.zoom, golden.as_double("intrinsics_used"));
}

TEST(trajectories, txt) {
  const json table = read_json("txt/calls.json");
  const SafeTensors golden = open("txt/cameras.safetensors");
  int cases = 0;
  for (const std::string& name : golden.names()) {
    SCOPED_TRACE(name);
    const std::string anchor_name = name.substr(name.rfind('_') + 1);
    const std::string call = name.substr(0, name.rfind('_'));
    if (call == "anchor") continue;
    const Rigid3 anchor = pose(golden.as_double("anchor_" + anchor_name));
    ++cases;
    if (call == "specified") {
      const json& c = table.at("specified");
      compare_poses(
          sphere_path(anchor, c.at("theta"), c.at("phi"), c.at("d_r"), c.at("d_x"), c.at("d_y"), c.at("frame")),
          golden.as_double(name));
      continue;
    }
    const auto frames = static_cast<long>(golden.info(name).shape.at(0));
    const json& lists = table.at("files").at(call.substr(0, call.rfind("_n")));
    compare_poses(sphere_path(anchor, OrbitLists{lists.at("phi"), lists.at("theta"), lists.at("r")}, frames),
                  golden.as_double(name));
  }
  EXPECT_GT(cases, 0);
}

std::vector<double> linspace(std::size_t n) {
  std::vector<double> x(n);
  for (std::size_t i = 0; i < n; ++i) x[i] = static_cast<double>(i) / static_cast<double>(n - 1);
  return x;
}

TEST(trajectories, splines) {
  const json table = read_json("txt/splines.json");
  const SafeTensors golden = open("txt/splines.safetensors");
  ASSERT_FALSE(table.empty());
  for (const auto& [name, facts] : table.items()) {
    SCOPED_TRACE(name);
    const std::vector<double> keys = golden.as_double(name + ".in");
    ASSERT_EQ(keys.size(), facts.at("points").get<std::size_t>());
    const CubicSpline spline = smoothing_spline(linspace(keys.size()), keys);

    const std::vector<double> knots = golden.as_double(name + ".knots");
    ASSERT_EQ(spline.interior_knots().size(), facts.at("interior_knots").get<std::size_t>());
    for (std::size_t i = 0; i < spline.interior_knots().size(); ++i)
      EXPECT_NEAR(spline.interior_knots()[i], knots.at(i + 1), spline_tolerance) << "interior knot " << i;
    EXPECT_NEAR(spline.residual, facts.at("residual").get<double>(), spline_tolerance * (1 + spline.residual));

    const std::vector<double> smooth = golden.as_double(name + ".smooth40");
    const std::vector<double> x = linspace(smooth.size());
    Worst worst;
    for (std::size_t i = 0; i < smooth.size(); ++i)
      worst.see(std::abs(spline(x[i]) - smooth[i]), fmt::format("x = {}", x[i]));
    EXPECT_LE(worst.value, spline_tolerance) << "worst at " << worst.place;

    const std::vector<double> spread = spread_keys(keys, static_cast<long>(smooth.size()));
    EXPECT_EQ(spread.front(), keys.front());
    EXPECT_EQ(spread.back(), keys.back());
    for (std::size_t i = 1; i + 1 < smooth.size(); ++i) EXPECT_NEAR(spread[i], smooth[i], spline_tolerance) << i;
  }
}

TEST(trajectories, rotation_from_vectors) {
  const SafeTensors golden = open("rotation_from_vectors.safetensors");
  const std::vector<double> from = golden.as_double("v1");
  const std::vector<double> to = golden.as_double("v2");
  const std::vector<double> expected = golden.as_double("R");
  ASSERT_GT(from.size(), 0U);
  for (std::size_t i = 0; i < from.size() / 3; ++i) {
    const Eigen::Matrix3d r = rotation_from_vectors(Eigen::Vector3d(&from[3 * i]), Eigen::Vector3d(&to[3 * i]));
    const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> wanted(&expected[9 * i]);
    EXPECT_LE((r - wanted).cwiseAbs().maxCoeff(), 1e-12) << "pair " << i << "\n" << r << "\nwanted\n" << wanted;
  }
}

}  // namespace
}  // namespace uwv
