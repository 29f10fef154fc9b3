// SPDX-License-Identifier: Apache-2.0
// Depth continued into holes from around them.
#pragma once

#include <opencv2/core.hpp>

#include "uwv/core/image.h"

namespace uwv::layers {

/// Gives the pixels of `missing` (CV_8U) the inverse depth of a membrane stretched over the hole: harmonic, equal to
/// what is known at the rim, flat towards the picture's border. Pixels that are neither missing nor valid are as the
/// border. 0 where nothing known is connected to the hole. Small rests of stiffness (a few thousandths) are left by
/// iteration.
void fill_smoothly(DepthMap& depth, const cv::Mat& missing);

}  // namespace uwv::layers
