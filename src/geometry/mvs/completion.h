// SPDX-License-Identifier: Apache-2.0
// Depth where matching could not see, and depth at the full size of the frame; both along edges of the picture.
#pragma once

#include "geometry/mvs/consistency.h"

namespace uwv::mvs {

/// Fills every pixel without depth, moving ones too: a static pixel at their border may need one of them when depth is
/// brought to full size. The filling is the smoothest one in inverse depth, in which planes are linear, that meets what
/// was measured, with little smoothness demanded across edges of colour; solved from coarse to fine. Its confidence is
/// below 0.5. Nothing is filled when nothing was measured.
void complete(const View& view, RatedDepth& depth);

/// To the size of the frame. A pixel takes the depth of those of the four coarse pixels around it that look like it and
/// lie on the surface of the one most like it: depth steps follow the picture's edges and are never averaged across.
RatedDepth upsample(const View& view, const RatedDepth& depth, const ImageRgb& frame, double tolerance);

}  // namespace uwv::mvs
