// SPDX-License-Identifier: Apache-2.0
// The focal length and the depth shift hidden in a point map that is right up to a shift along z (geometry sheet 4.1).
#pragma once

#include "model/map_resize.h"

namespace uwv::model {

struct FocalShift {
  double focal = 0;  ///< In pixels of `frame`, square pixels, centred principal point.
  double shift = 0;  ///< To be added to z.
  /// Root mean square of what remains between the points' pixels and where they were found, in pixels of `frame`.
  double residual = 0;
  /// False when the points say nothing of the shift (all at one depth): it is 0 then.
  bool shift_known = true;
};

/// Minimises |f * xy / (z + s) - uv| over at most 64x64 of the known points (known > 0); f has a closed form for each
/// s. focal is 0 when fewer than 8 points are known or no positive focal fits.
FocalShift recover_focal_shift(const VectorMap& points, const FloatMap& known, Size frame);

}  // namespace uwv::model
