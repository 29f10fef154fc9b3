// SPDX-License-Identifier: Apache-2.0
// M_vis: what of the source has been visible so far along the path.
#pragma once

#include "uwv/render/occlusion.h"

namespace uwv::detail {

/// The running mask. Empty before the first frame.
class VisibleSoFar {
 public:
  explicit VisibleSoFar(Accumulation rule) : rule_(rule) {}

  /// Takes in M'' of the next frame. `points` and `target` tell what lies outside the picture (product_in_view);
  /// `foreground` is F of this frame (foreground rule).
  void add(const ValidityMask& second, const PointGrid& points, const Camera& target, const ValidityMask* foreground,
           ThreadPool& pool);
  /// A frame from which everything is visible.
  void add_all(Size size, const ValidityMask* foreground);
  const ValidityMask& mask() const { return visible_; }
  void restart() { visible_ = ValidityMask(); }

 private:
  Accumulation rule_;
  ValidityMask visible_;
};

}  // namespace uwv::detail
