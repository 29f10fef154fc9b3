// SPDX-License-Identifier: Apache-2.0
// Binary pictures made of whole regions instead of specks.
#pragma once

#include <opencv2/core.hpp>

#include "uwv/core/mask.h"

namespace uwv::moving {

/// 255 where `score` is at least `low` and connected to a pixel of at least `high` (8 neighbours).
cv::Mat hysteresis(const cv::Mat& score, double high, double low);

/// Closes gaps of a few pixels, fills holes smaller than `hole` pixels and drops regions smaller than `smallest`.
/// Regions are 255 on 0. Returns how many are left.
int tidy_regions(cv::Mat& regions, double smallest, double hole);

/// Lets regions grow to the outlines seen in `picture` (8UC3, same size) if these are within a fortieth of its height:
/// between what surely moves and what is far enough from it, the border goes where colour changes most (watershed).
void grow_to_outlines(cv::Mat& regions, const cv::Mat& picture);

/// 1 = static, of a picture with 255 for what moves; enlarged to `size`.
ValidityMask static_from_regions(const cv::Mat& regions, Size size);

}  // namespace uwv::moving
