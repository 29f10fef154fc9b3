// SPDX-License-Identifier: Apache-2.0
// How alike two clips are, frame by frame.
#pragma once

#include <string>
#include <vector>

#include "uwv/core/monitor.h"

namespace uwv {

struct CompareOptions {
  std::string a, b;  ///< Clips or photos of the same size and number of frames.
  std::string mask;  ///< Empty, or a clip like generate_mask.mp4: white pixels are left out.
  /// Throws std::invalid_argument unless both clips are named.
  void check() const;
};

/// One frame's figures; see image_metrics.h for what they are exactly.
struct FrameComparison {
  double psnr = 0;         ///< dB over the pixels compared; infinite when equal, NaN when none are compared.
  double ssim = 0;         ///< Over windows that lie wholly in those pixels; NaN when there is none.
  double valid_share = 1;  ///< Pixels compared, of all.
};

struct ClipComparison {
  std::vector<FrameComparison> frames;
  /// Means over the frames whose figure is finite (PSNR) or a number (SSIM); NaN when there are none. The mean PSNR of
  /// clips of which all frames compared are equal is infinite.
  double mean_psnr() const;
  double mean_ssim() const;
  double mean_valid_share() const;
  long equal_frames() const;  ///< Of infinite PSNR.
  std::string report() const;
};

/// Throws Error(size_mismatch) when the clips differ in size or number of frames.
ClipComparison compare_clips(const CompareOptions& options, Monitor& monitor);

}  // namespace uwv
