// SPDX-License-Identifier: Apache-2.0
// Where the centres of points land in the target, a block of points at a time.
#pragma once

#include <array>

#include "render/footprint.h"

namespace uwv::detail {

struct Landings {
  alignas(64) std::array<float, block_size> u, v, depth;   ///< Meaningless where `pixel` is negative.
  alignas(64) std::array<std::int32_t, block_size> pixel;  ///< y * width + x in the target; -1 = not in its picture.
};

/// Lands points (x, y) .. (x + count - 1, y); the pointers are those of point (x, y), `keep` may be null. Points that
/// are not kept, invalid or behind the camera land nowhere.
void land_block(const WarpMap& map, int x, int y, int count, const float* depth, const std::uint8_t* keep, Size target,
                Landings& out);

}  // namespace uwv::detail
