// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstring>

#include "io/disk_file.h"
#include "uwv/io/ply_file.h"

namespace uwv {
namespace {

/// Zero while floats hold the points well enough: their spacing grows with the distance from the origin, and where it
/// is coarser than about a millionth of the cloud the points are moved close to it.
Eigen::Vector3d choose_offset(const PlyCloud& cloud, bool double_precision) {
  if (double_precision || cloud.points.empty()) return Eigen::Vector3d::Zero();
  Eigen::Vector3d low = cloud.points[0], high = cloud.points[0];
  for (const Eigen::Vector3d& p : cloud.points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  constexpr double far = 16;  // 2^-24 * 16 is a millionth
  const double reach = low.cwiseAbs().cwiseMax(high.cwiseAbs()).maxCoeff();
  const double extent = (high - low).maxCoeff();
  if (reach <= far * extent) return Eigen::Vector3d::Zero();
  const Eigen::Vector3d middle = 0.5 * low + 0.5 * high;
  if (extent == 0) return middle;
  // On a grid a few clouds wide, so that the frames of one scene mostly share an offset.
  const double grid = std::exp2(std::ceil(std::log2(4 * extent)));
  return (middle / grid).array().round() * grid;
}

std::string header_of(const PlyCloud& cloud, bool double_precision, const Eigen::Vector3d& offset) {
  std::string header = "ply\nformat binary_little_endian 1.0\n";
  if (!offset.isZero(0)) header += fmt::format("comment uwv_offset {} {} {}\n", offset[0], offset[1], offset[2]);
  header += fmt::format("element vertex {}\n", cloud.points.size());
  const char* type = double_precision ? "double" : "float";
  for (const char* name : {"x", "y", "z"}) header += fmt::format("property {} {}\n", type, name);
  if (!cloud.normals.empty())
    for (const char* name : {"nx", "ny", "nz"}) header += fmt::format("property float {}\n", name);
  if (!cloud.colours.empty())
    for (const char* name : {"red", "green", "blue"}) header += fmt::format("property uchar {}\n", name);
  return header + "end_header\n";
}

template <class T>
void append_bytes(std::vector<std::byte>& buffer, const T* values, std::size_t count) {
  const auto bytes = std::as_bytes(std::span(values, count));
  buffer.insert(buffer.end(), bytes.begin(), bytes.end());
}

void check(const std::string& path, const PlyCloud& cloud) {
  const std::size_t n = cloud.points.size();
  require(cloud.colours.empty() || cloud.colours.size() == n, "{}: {} points and {} colours do not fit", path, n,
          cloud.colours.size());
  require(cloud.normals.empty() || cloud.normals.size() == n, "{}: {} points and {} normals do not fit", path, n,
          cloud.normals.size());
  for (std::size_t i = 0; i < n; ++i) require(cloud.points[i].allFinite(), "{}: point {} is not finite", path, i);
}

}  // namespace

void write_ply(const std::string& path, const PlyCloud& cloud, const PlyOptions& options) {
  check(path, cloud);
  const Eigen::Vector3d offset = choose_offset(cloud, options.double_precision);
  io::OutputFile file(path);
  file.append(header_of(cloud, options.double_precision, offset));
  constexpr std::size_t flush_bytes = 1 << 20;
  std::vector<std::byte> buffer;
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    const Eigen::Vector3d stored = cloud.points[i] - offset;
    if (options.double_precision)
      append_bytes(buffer, stored.data(), 3);
    else
      append_bytes(buffer, Eigen::Vector3f(stored.cast<float>()).data(), 3);
    if (!cloud.normals.empty()) append_bytes(buffer, cloud.normals[i].data(), 3);
    if (!cloud.colours.empty()) append_bytes(buffer, &cloud.colours[i], 1);
    if (buffer.size() >= flush_bytes) {
      file.append(buffer);
      buffer.clear();
    }
  }
  file.append(buffer);
  file.commit();
}

}  // namespace uwv
