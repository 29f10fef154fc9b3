// SPDX-License-Identifier: Apache-2.0
// Which other views are worth drawing for a frame, by a few thousand points of each.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "uwv/render/other_views.h"

namespace uwv::detail {

/// The open pixels of a frame, counted in square cells.
struct OpenCells {
  static constexpr int side = 8;
  explicit OpenCells(const ValidityMask& valid);
  std::size_t cell_of(int x, int y) const {
    return static_cast<std::size_t>(y / side) * columns + static_cast<std::size_t>(x / side);
  }
  std::size_t columns;
  std::vector<std::uint32_t> open;  ///< Pixels a cell leaves open.
  std::size_t total = 0;
};

/// What a view's sampled points say about a frame.
struct ViewSurvey {
  std::vector<std::uint8_t> reaches;   ///< Per cell: 1 = a point lands on an open pixel of it.
  std::size_t agreeing = 0;            ///< Points that land on the frame's surface.
  std::size_t before = 0;              ///< Points that land before it.
  std::array<float, 3> gain{1, 1, 1};  ///< What brings the view's colours to the frame's.

  /// Share of the points seen by both that contradict the frame.
  double contradiction() const {
    const std::size_t both = agreeing + before;
    return both > 0 ? static_cast<double>(before) / static_cast<double>(both) : 0;
  }
};

ViewSurvey survey_view(const OtherView& view, const Camera& target, const RenderedFrame& frame, const OpenCells& cells,
                       const OtherViewsOptions& options);

/// The views to draw, most useful first: each opens up at least `min_pixels` that those before it don't. Ties go to the
/// lower index.
std::vector<std::size_t> choose_views(const std::vector<ViewSurvey>& surveys, const OpenCells& cells,
                                      std::size_t min_pixels, const OtherViewsOptions& options);

}  // namespace uwv::detail
