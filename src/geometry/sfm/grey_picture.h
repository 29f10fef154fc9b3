// SPDX-License-Identifier: Apache-2.0
// The grey picture that features are tracked in.
#pragma once

#include <opencv2/core.hpp>

#include "uwv/core/image.h"

namespace uwv::sfm {

/// 8 bit, shrunk to `size` by area.
cv::Mat grey_of(const ImageRgb& frame, Size size);

}  // namespace uwv::sfm
