// SPDX-License-Identifier: Apache-2.0
// The renderings Algorithm 1 asks for, as one kernel makes them. Passes are called in the order of the algorithm for
// each frame: first, come_back, draw, colour; a frame may leave out the first two. colour() may be called again.
#pragma once

#include <memory>

#include "uwv/render/occlusion.h"

namespace uwv::detail {

class KernelChain {
 public:
  virtual ~KernelChain() = default;

  /// Source -> target: I', D', M'.
  virtual void first(const PointGrid& points, const Camera& target) = 0;
  /// M' of the last first().
  virtual void first_mask(ValidityMask& out) const = 0;
  /// M'' of the last first(): which source pixels are seen from the target. Target pixels with exclude = 1 (null =
  /// none) do not come back.
  virtual void come_back(const PointGrid& points, const Camera& target, const ValidityMask* exclude,
                         ValidityMask& second) = 0;
  /// Where these points land in the target.
  virtual void coverage(const PointGrid& points, const Camera& target, ValidityMask& out) = 0;
  /// The final rendering. With `after_first` the last first() drew a superset of `kept` into the same target; returns
  /// false when `kept` gives that rendering once more.
  virtual bool draw(const SourceFrame& source, const PointGrid& kept, const Camera& target, bool after_first) = 0;
  /// The picture of the last draw().
  virtual void colour(const SourceFrame& source, const PointGrid& kept, const Camera& target, RenderedFrame& out) = 0;
};

/// Kernel::nearest and Kernel::resample.
std::unique_ptr<KernelChain> make_zbuffer_chain(Rasterizer& rasterizer, ThreadPool& pool,
                                                const OcclusionOptions& options);
/// Kernel::bilinear.
std::unique_ptr<KernelChain> make_soft_chain(Rasterizer& rasterizer, ThreadPool& pool, const OcclusionOptions& options);

}  // namespace uwv::detail
