// SPDX-License-Identifier: Apache-2.0
// Writes the depths of a clip, one frame at a time; what it writes, open_depth() reads.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "uwv/core/image.h"
#include "uwv/core/monitor.h"

namespace uwv {

enum class DepthFormat {
  npz,    ///< One file, array `depth`, float32, shape (n, h, w).
  png16,  ///< A folder of 00000.png, 00001.png, ... and depth.json, which states the scale.
  exr,    ///< A folder of 00000.exr, ...: 32-bit float, channel Z.
};
std::string_view to_string(DepthFormat format);
/// Throws std::invalid_argument naming the known formats.
DepthFormat depth_format_named(std::string_view name);

struct DepthWriterOptions {
  DepthFormat format = DepthFormat::npz;  ///< Lossless, and one file to carry around.
  /// Scene units per step of a 16-bit PNG. Millimetres of metres: reaches 65.5 m; farther depths become invalid.
  double png_scale = 0.001;
  /// 0 stores (fast, frames can be sought), 1 to 9 deflate: depth rarely shrinks below two thirds.
  int npz_deflate_level = 0;
  /// Throws std::invalid_argument when a value is out of range.
  void check() const;
};

class DepthWriter {
 public:
  virtual ~DepthWriter() = default;
  /// Appends a frame of the size given at creation.
  virtual void write(const DepthMap& depth) = 0;
  /// Completes the output and gives it its name; without it nothing is left behind. Warns the monitor when a 16-bit PNG
  /// could not hold some depths, with their number.
  virtual void finish() = 0;
};

/// `path` is the file or folder to be written. `frames` is the number of frames to come; finish() holds the caller to
/// it (std::invalid_argument), 0 = not known. An existing file is replaced at the end, and so is a folder that holds
/// nothing but an earlier output of this writer; any other folder that is not empty is refused. Throws
/// Error(output_failed).
std::unique_ptr<DepthWriter> make_depth_writer(const std::string& path, const DepthWriterOptions& options, Size size,
                                               long frames, Monitor& monitor);

}  // namespace uwv
