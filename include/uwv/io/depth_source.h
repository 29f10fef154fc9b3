// SPDX-License-Identifier: Apache-2.0
// The depths of a clip, one frame at a time, from whatever a depth estimator wrote.
#pragma once

#include <memory>
#include <string>

#include "uwv/core/image.h"
#include "uwv/core/monitor.h"

namespace uwv {

struct DepthOptions {
  /// Scene units per stored unit. 0 = what a depth.json beside the pictures says, else 0.001 for 16-bit PNG and 1 for
  /// everything else.
  double scale = 0;
  /// The array inside an .npz; "" = the first there is of dep (the official name), depth, depths, arr_0, or the only
  /// one.
  std::string key;
  // Frames are picked as the video's are (ClipOptions): depth i is frame start + i * stride of the file.
  long start = 0;
  long stride = 1;
  long max_frames = 0;  ///< 0 = all: the depths decide nothing about how long the clip is.
  /// Throws std::invalid_argument for a negative or non-finite scale, negative start or max_frames, stride below 1.
  void check() const;
};

/// Depths opened for reading. Memory does not depend on their number. Not for use by two threads at once.
class DepthSource {
 public:
  virtual ~DepthSource() = default;
  /// At least 1.
  virtual long frames() const = 0;
  /// Of every frame.
  virtual Size size() const = 0;
  /// Reads frame `index` >= 0 into `out`, in scene units with 0 = invalid; false when there are fewer frames. Any
  /// order works; going back in a deflated .npz starts over. Throws Error(file_damaged), or Error(size_mismatch) when
  /// a file of a sequence has another size than the first.
  virtual bool read(long index, DepthMap& out) = 0;
};

/// Opens `path`, which is one of
/// - an .npy or .npz array of shape (h, w), (n, h, w), (n, 1, h, w) or (n, h, w, 1);
/// - a single .png (16-bit grey), .exr or .pfm: one frame;
/// - a folder of .png, .exr, .pfm or .npy files of one kind, in natural order (depth2 before depth10);
/// - a pattern of such files whose name holds `%d` / `%05d`, `*` or `?`.
/// Throws Error: file_not_found, file_damaged, format_unknown, value_invalid (shape, key, start behind the end).
/// `monitor` hears warnings: whole numbers without a stated scale, an array order that is slow to read.
std::unique_ptr<DepthSource> open_depth(const std::string& path, const DepthOptions& options, Monitor& monitor);

/// Depth for a picture of another size. Pixel edges stay pixel edges. Where the four neighbours are valid and within 5
/// % of each other they are taken as one surface and interpolated linearly in 1/z, which is exact on planes; elsewhere
/// the nearest pixel is taken, so that no depth appears between foreground and background.
DepthMap resize_depth(const DepthMap& depth, Size size);

}  // namespace uwv
