// SPDX-License-Identifier: Apache-2.0
// Coloured points in .ply files.
//
// Written: binary little-endian, element `vertex` with x y z (float or double), then nx ny nz (float) when there are
// normals, then red green blue (uchar) when there are colours. Points far from the origin would lose their shape as
// floats; they are stored relative to an offset, which stands in the line `comment uwv_offset X Y Z` and is added again
// by our reader (other programs show the same shape near the origin).
// Read: those, ascii, and binary big-endian; any scalar types; other properties are skipped.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "uwv/core/image.h"

namespace uwv {

/// Points of the world with what is known about each. `colours` and `normals` are empty or as long as `points`.
struct PlyCloud {
  std::vector<Eigen::Vector3d> points;   ///< x_in_world, scene units, all finite.
  std::vector<Rgb8> colours;             ///< sRGB.
  std::vector<Eigen::Vector3f> normals;  ///< In the world's axes; (0, 0, 0) = unknown.
};

struct PlyOptions {
  /// Stores coordinates as double: 12 bytes more per point, and not every viewer reads it.
  bool double_precision = false;
};

/// Throws Error(output_failed); std::invalid_argument when the lengths differ or a point is not finite.
void write_ply(const std::string& path, const PlyCloud& cloud, const PlyOptions& options = {});

/// Reads the vertices. Points that are not finite, which depth cameras write for "nothing there", are left out. Throws
/// Error: file_not_found, file_damaged (no PLY header, more vertices claimed than bytes are there, a broken number),
/// format_unknown (no vertex element, vertices with lists, no x y z).
PlyCloud read_ply(const std::string& path);

}  // namespace uwv
