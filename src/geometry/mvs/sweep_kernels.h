// SPDX-License-Identifier: Apache-2.0
// The plane sweep's inner loops, each over one row of the reference.
#pragma once

#include <cstddef>
#include <cstdint>

#include "geometry/mvs/view.h"

namespace uwv::mvs {

constexpr int worst_cost = 100;   ///< Of planes on which nothing is alike.
constexpr int window_radius = 1;  ///< 3x3: larger windows reach over edges and fatten what is in front.
constexpr int window = 2 * window_radius + 1;

/// Where the reference's pixel (x, y) at inverse depth w lands in another view, homogeneous: a*x + b*y + c + w*shift.
/// Pixels are whole numbers at their centres on both sides.
struct PlaneWarp {
  float ax, ay, az, bx, by, bz, cx, cy, cz;
  float shift_x, shift_y, shift_z;
};
PlaneWarp make_warp(const Camera& reference, const Camera& other);

/// A row of places in the other view: index of the top left of four pixels in a picture with rows of `stride`, the
/// position between them, and 1 where the place is inside the picture (0 elsewhere, with the nearest place inside).
void find_places(const PlaneWarp& warp, float w, float y, int count, Size other, int stride, std::int32_t* index,
                 float* fx, float* fy, float* inside);

/// Bilinear values of a picture whose last row and column are there twice, so that four pixels exist everywhere.
void sample_row(const float* padded, int stride, const std::int32_t* index, const float* fx, const float* fy, int count,
                float* out);

/// Sums over the rows of the window of value, value^2 and value*reference.
void sum_columns(const float* const* values, const float* const* reference, int count, float* value, float* square,
                 float* product);

/// How different two windows look but for their brightness, 0 to 1: one minus the contrast and structure terms of SSIM
/// (Wang et al., 2004). Unlike correlation it tells an even window from a textured one, and finds two even ones alike.
/// From column sums (readable window_radius beyond both ends) and the reference's mean and variance; places that are
/// not inside cost what speaks neither for nor against.
void correlate(const float* value, const float* square, const float* product, const float* mean, const float* variance,
               const float* inside, int count, float* cost);

/// Mean and variance of windows from column sums.
void window_statistics(const float* value, const float* square, int count, float* mean, float* variance);

/// Sorts a row of costs into the `kept` smallest so far, level by level; `cost` is used up.
void insert_sorted(float* cost, int count, int kept, std::size_t stride, float* best);

/// The mean of the kept costs, [0, 1] to [0, worst_cost].
void mean_to_bytes(const float* best, int count, int kept, std::size_t stride, std::uint8_t* out);

}  // namespace uwv::mvs
