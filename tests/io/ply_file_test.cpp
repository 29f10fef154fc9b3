// SPDX-License-Identifier: Apache-2.0
#include "uwv/io/ply_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "io/hostile.h"

namespace uwv {
namespace {

using test::expect_error;
using test::TempFolder;

PlyCloud sample_cloud(const Eigen::Vector3d& centre, bool with_colours = true, bool with_normals = true) {
  PlyCloud cloud;
  for (int i = 0; i < 20; ++i) {
    cloud.points.push_back(centre + Eigen::Vector3d(std::sin(i), 0.01 * i, std::cos(3 * i)));
    const auto level = static_cast<std::uint8_t>(12 * i);
    if (with_colours) cloud.colours.push_back({level, 255, static_cast<std::uint8_t>(255 - level)});
    if (with_normals) cloud.normals.push_back(Eigen::Vector3f(0, 0.6F, -0.8F));
  }
  return cloud;
}

void expect_same(const PlyCloud& got, const PlyCloud& wanted, double tolerance) {
  ASSERT_EQ(got.points.size(), wanted.points.size());
  for (std::size_t i = 0; i < got.points.size(); ++i)
    EXPECT_LE((got.points[i] - wanted.points[i]).cwiseAbs().maxCoeff(), tolerance) << "point " << i;
  EXPECT_EQ(got.colours, wanted.colours);
  EXPECT_EQ(got.normals, wanted.normals);
}

TEST(Ply, RoundTripsWithAndWithoutColoursAndNormals) {
  const TempFolder folder;
  for (const bool colours : {false, true})
    for (const bool normals : {false, true}) {
      const PlyCloud cloud = sample_cloud({0, 0, 5}, colours, normals);
      write_ply(folder.file("c.ply"), cloud);
      expect_same(read_ply(folder.file("c.ply")), cloud, 5e-7);
      write_ply(folder.file("c.ply"), cloud, {true});
      expect_same(read_ply(folder.file("c.ply")), cloud, 0);
    }
}

TEST(Ply, KeepsTheShapeOfCloudsFarAway) {
  const TempFolder folder;
  const PlyCloud cloud = sample_cloud({1e7, -3e8, 12.5});
  write_ply(folder.file("c.ply"), cloud);
  EXPECT_THAT(folder.read("c.ply").substr(0, 100), testing::HasSubstr("comment uwv_offset 10000000 -300000000 16\n"));
  expect_same(read_ply(folder.file("c.ply")), cloud, 5e-7);  // floats alone are 32 apart out there
}

TEST(Ply, KeepsExtremesAndTheEmptyCloud) {
  const TempFolder folder;
  PlyCloud cloud;
  write_ply(folder.file("c.ply"), cloud);
  expect_same(read_ply(folder.file("c.ply")), cloud, 0);
  cloud.points = {{1e-6, 1e9, 0}, {-1e9, 1e-6, -0.0}};
  write_ply(folder.file("c.ply"), cloud);
  EXPECT_NEAR(read_ply(folder.file("c.ply")).points[0].x(), 1e-6, 1e-12);
  EXPECT_EQ(read_ply(folder.file("c.ply")).points[0].y(), 1e9);
  cloud.points = {{7, 8, 9}};
  write_ply(folder.file("c.ply"), cloud);
  expect_same(read_ply(folder.file("c.ply")), cloud, 0);
}

TEST(Ply, ReadsAsciiAndSkipsWhatItDoesNotKnow) {
  const TempFolder folder;
  const std::string path =
      folder.write("a.ply",
                   "ply\r\nformat ascii 1.0\r\ncomment made by hand\r\nelement vertex 3\r\n"
                   "property float64 x\r\nproperty uint8 red\r\nproperty int quality\r\n"
                   "property float y\r\nproperty uchar green\r\nproperty uchar blue\r\n"
                   "property float z\r\nelement face 1\r\nproperty list uchar int vertex_indices\r\n"
                   "end_header\r\n1 10 99 2 20 30 3\r\nnan 0 0 0 0 0 0\r\n-1e9 255 0 1e-6 0 0 0.5\r\n"
                   "3 0 1 2\r\n");
  const PlyCloud cloud = read_ply(path);
  ASSERT_EQ(cloud.points.size(), 2U);  // the point with NaN is left out
  EXPECT_EQ(cloud.points[0], Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(cloud.points[1], Eigen::Vector3d(-1e9, 1e-6, 0.5));
  EXPECT_EQ(cloud.colours[0], (Rgb8{10, 20, 30}));
  EXPECT_TRUE(cloud.normals.empty());
}

TEST(Ply, ReadsBigEndianAndFloatColours) {
  const TempFolder folder;
  const std::string big =
      folder.write("b.ply",
                   "ply\nformat binary_big_endian 1.0\nelement vertex 1\nproperty float x\nproperty "
                   "float y\nproperty short z\nend_header\n" +
                       std::string("\x3F\x80\0\0\x40\0\0\0\xFF\xFD", 10));
  EXPECT_EQ(read_ply(big).points[0], Eigen::Vector3d(1, 2, -3));
  const std::string floats =
      folder.write("f.ply",
                   "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
                   "property float z\nproperty float r\nproperty float g\nproperty float b\n"
                   "end_header\n0 0 1 0.5 2 nan\n");
  EXPECT_EQ(read_ply(floats).colours[0], (Rgb8{128, 255, 0}));
}

TEST(Ply, RefusesLyingHeaders) {
  const TempFolder folder;
  const std::string xyz = "property float x\nproperty float y\nproperty float z\n";
  const std::string binary = "ply\nformat binary_little_endian 1.0\n", ascii = "ply\nformat ascii 1.0\n";
  const auto refused = [&](ErrorCode code, const std::string& text) {
    SCOPED_TRACE(text);
    const std::string path = folder.write("lie.ply", text);
    expect_error(code, path, [&] { (void)read_ply(path); });
  };
  using enum ErrorCode;
  refused(format_unknown, "");
  refused(format_unknown, "hello\n");
  refused(format_unknown, "ply");
  refused(file_damaged, "ply\n");
  refused(file_damaged, binary + "element vertex 1\n" + xyz);
  refused(file_damaged, "ply\nelement vertex 0\n" + xyz + "end_header\n");
  refused(file_damaged, "ply\nformat binary 2.0\nend_header\n");
  refused(file_damaged, binary + "element vertex 1000000000000\n" + xyz + "end_header\n" + std::string(12, 'x'));
  refused(file_damaged, binary + "element vertex 18446744073709551615\n" + xyz + "end_header\n" + std::string(12, 'x'));
  refused(file_damaged, binary + "element vertex 99999999999999999999\n" + xyz + "end_header\n");
  refused(file_damaged, binary + "element vertex -1\n" + xyz + "end_header\n");
  refused(file_damaged, ascii + "element vertex 1000000000000\n" + xyz + "end_header\n1 2 3\n");
  refused(file_damaged, ascii + "element vertex 2\n" + xyz + "end_header\n1.000 2.000 3.000\n4 5");
  refused(file_damaged, ascii + "element vertex 1\n" + xyz + "end_header\n1 two 3\n");
  refused(file_damaged, ascii + "element vertex 1\nproperty half x\nend_header\n1\n");
  refused(file_damaged, ascii + "element vertex 1\nproperty float x\nproperty float x\nend_header\n1 2\n");
  refused(file_damaged, ascii + "property float x\nend_header\n");
  refused(file_damaged, ascii + "comment uwv_offset 1 2 nan\nelement vertex 0\n" + xyz + "end_header\n");
  refused(format_unknown, ascii + "element vertex 1\nproperty float x\nend_header\n1\n");
  refused(format_unknown, ascii + "end_header\n");
  refused(format_unknown, ascii + "element face 1\nelement vertex 1\n" + xyz + "end_header\n1 2 3\n");
  refused(format_unknown, ascii + "element vertex 1\nproperty list uchar int i\n" + xyz + "end_header\n");
}

TEST(Ply, SurvivesTruncationAndRandomDamage) {
  const TempFolder folder;
  write_ply(folder.file("c.ply"), sample_cloud({1e7, 0, 0}));
  const auto read = [](const std::string& path) { (void)read_ply(path); };
  EXPECT_EQ(test::try_truncations(folder.read("c.ply"), "t.ply", read), 0);
  test::try_byte_flips(folder.read("c.ply"), "f.ply", read, 1000);
}

TEST(Ply, CallersMistakesAreRefused) {
  const TempFolder folder;
  PlyCloud cloud = sample_cloud({0, 0, 0});
  cloud.colours.pop_back();
  EXPECT_THROW(write_ply(folder.file("c.ply"), cloud), std::invalid_argument);
  cloud.colours.clear();
  cloud.points[3].y() = std::numeric_limits<double>::infinity();
  EXPECT_THROW(write_ply(folder.file("c.ply"), cloud), std::invalid_argument);
  expect_error(ErrorCode::output_failed, folder.file("no/c.ply"), [&] { write_ply(folder.file("no/c.ply"), {}); });
  expect_error(ErrorCode::file_not_found, folder.file("c.ply"), [&] { (void)read_ply(folder.file("c.ply")); });
}

}  // namespace
}  // namespace uwv
