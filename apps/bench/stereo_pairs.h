// SPDX-License-Identifier: Apache-2.0
// Rectified stereo pairs with measured disparity, as clips of two frames: left, right.
#pragma once

#include <string>

#include "bench/true_clip.h"

namespace uwv::bench {

/// Whether the folder holds a pair read_stereo_pair() reads.
bool is_stereo_pair(const std::string& folder);

/// Reads one of
/// - im2.png, im6.png, disp2.png and disp6.png, disparities in quarters of a pixel (Middlebury 2003);
/// - view1.png, view5.png, disp1.png and disp5.png, disparities in halves of a pixel (Middlebury 2005 and 2006);
/// - motorcycle_left.png, motorcycle_right.png and motorcycle_disp.npz, which scripts/setup leaves in .cache/demo and
///   docs/sources.md has the calibration of. Depth is in millimetres, the right picture's is not known.
/// The Middlebury pairs come without calibration: the lens is taken for as long as the picture is wide and the baseline
/// for 1, which scales true depth by one factor and leaves relative errors as they are. Disparity 0 = not measured.
/// Throws Error for files that are missing and for pictures of different sizes.
TrueClip read_stereo_pair(const std::string& folder, const ResizePolicy& resize);

}  // namespace uwv::bench
