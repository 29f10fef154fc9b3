// SPDX-License-Identifier: Apache-2.0
// The text at the start of a PLY file.
#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

#include "uwv/io/dtype.h"

namespace uwv::io {

enum class PlyFormat { ascii, binary_little, binary_big };

struct PlyProperty {
  std::string name;
  DType type = DType::f32;
  std::size_t offset = 0;  ///< Bytes from the start of a binary vertex.
};

struct PlyHeader {
  PlyFormat format = PlyFormat::ascii;
  std::uint64_t vertices = 0;
  std::vector<PlyProperty> properties;  ///< Of a vertex, in file order.
  std::size_t vertex_bytes = 0;         ///< Of a binary vertex.
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();
  std::size_t data_offset = 0;  ///< Where the first vertex starts in the file.

  /// Index of a property; -1 when there is none of that name.
  int find(std::string_view name) const;
};

/// `text` is the whole file or at least its header. Throws as read_ply().
PlyHeader parse_ply_header(std::string_view text, const std::string& path);

}  // namespace uwv::io
