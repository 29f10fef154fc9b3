// SPDX-License-Identifier: Apache-2.0
// From frames to the tensor a network wants.
#pragma once

#include <span>

#include "model/network_manifest.h"
#include "uwv/core/thread_pool.h"

namespace uwv::model {

/// The size at which a frame enters. Throws Error(value_invalid) when it would have more than 2^28 pixels.
Size network_size(const InputRule& rule, Size frame);

/// One frame, resized and normalised: planes C, H, W.
FloatTensor prepared_frame(const InputRule& rule, const ImageRgb& frame);

/// Prepared frames put together in the rule's layout; a rule without T takes exactly one.
FloatTensor network_input(const InputRule& rule, std::span<const FloatTensor* const> frames);

}  // namespace uwv::model
