// SPDX-License-Identifier: Apache-2.0
// One depth picture in a file: .npy, .npz, 16-bit .png, .exr or .pfm.
//
// Values become scene units (stored value times `scale`) along the optical axis; everything that is no usable depth
// (0, NaN, Inf, negative, outside [min_depth, max_depth]) becomes 0. Row 0 is the top row in every format.
// docs/formats.md has the tables.
#pragma once

#include <string>

#include "uwv/core/depth.h"
#include "uwv/core/image.h"

namespace uwv {

struct DepthFileOptions {
  /// Scene units per stored unit. 0 = the format's default: 0.001 for 16-bit PNG (millimetres to metres), else 1.
  double scale = 0;
  /// The array inside an .npz; "" = the first there is of dep, depth, depths, arr_0, or the only one.
  std::string key;
  /// Throws std::invalid_argument unless the scale is finite and not negative.
  void check() const;
};

/// Reads one picture; the format is recognised by the file's first bytes. An array may have any shape with one frame
/// that DepthSource accepts. Throws Error: file_not_found, file_damaged, format_unknown, value_invalid (no such key, no
/// depth channel, more than one frame).
DepthMap read_depth_file(const std::string& path, const DepthFileOptions& options = {});

/// What a 16-bit PNG could not hold; such pixels are written as 0 (invalid).
struct DepthLoss {
  std::size_t too_far = 0;   ///< Beyond 65535 steps of the scale.
  std::size_t too_near = 0;  ///< Positive, yet rounding to step 0.
};

/// Writes one picture in the format of the name's extension (.npy, .png, .exr or .pfm); only .png can lose anything
/// valid. options.scale as for reading: the file holds depth / scale. The file appears only when it is whole. Throws
/// Error(output_failed), and Error(format_unknown) for other extensions.
DepthLoss write_depth_file(const std::string& path, const DepthMap& depth, const DepthFileOptions& options = {});

}  // namespace uwv
