// SPDX-License-Identifier: Apache-2.0
// One depth map out of foreground and background depth, and the mask operations around it.
//
// Paper: D = M * D_fg + (1 - M) * D_bg. The official code (geometry sheet 4.5) leaves a ring of invalid depth around
// the foreground, so that the two do not smear into each other; its reconstruction branch closes the masks first and
// leaves no ring.
#pragma once

#include "uwv/core/image.h"
#include "uwv/geometry/layers.h"

namespace uwv {

struct CompositeOptions {
  /// Depth 0 on the pixels around the foreground. Off: hard edges, every background pixel kept.
  bool ring = false;
  /// The ring is what a square of `ring_window`, grown `ring_iterations` times, adds: 12 pixels as the official code.
  int ring_window = 9;
  int ring_iterations = 3;
  /// The mask is closed by a square of `close_window` this often before it is used. The official reconstruction
  /// branch: 3 and 4; 0 uses masks as they are.
  int close_window = 3;
  int close_iterations = 0;
  void check() const;
};

/// D_fg where `foreground`, D_bg elsewhere, 0 in the ring. Invalid depth stays invalid. All of one size, or
/// std::invalid_argument.
DepthMap composite_depth(const DepthMap& foreground_depth, const DepthMap& background_depth,
                         const ForegroundMask& foreground, const CompositeOptions& options = {});

/// A mask grown or shrunk by a square with an odd side, `iterations` times. Nothing is known outside the picture: it
/// neither grows into it nor shrinks it.
ForegroundMask dilate_mask(const ForegroundMask& mask, int window, int iterations);
ForegroundMask erode_mask(const ForegroundMask& mask, int window, int iterations);
/// Grown, then shrunk by as much: fills holes and gaps, keeps outlines.
ForegroundMask close_mask(const ForegroundMask& mask, int window, int iterations);

}  // namespace uwv
