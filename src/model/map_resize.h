// SPDX-License-Identifier: Apache-2.0
// Maps with unknown pixels, brought to the size of the frame.
#pragma once

#include "model/network_output.h"

namespace uwv::model {

/// A map and which of its pixels are known (weight > 0): the confidence.
struct KnownMap {
  FloatMap value;
  FloatMap confidence;
};

/// Bilinear, pixel edges on pixel edges (what torch calls align_corners=False). Unknown neighbours have no say; a pixel
/// is known when the nearest source pixel is.
KnownMap resized(const KnownMap& map, Size size);
/// The same for directions: the mean is normalised; zero = unknown.
VectorMap resized_directions(const VectorMap& map, Size size);

}  // namespace uwv::model
