// SPDX-License-Identifier: Apache-2.0
// COLMAP as a yardstick: the program of that name, run on the same pictures.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "uwv/core/camera.h"

namespace uwv::bench {

struct ColmapOptions {
  std::optional<Intrinsics> intrinsics;  ///< Known and kept; empty = one focal length is estimated.
  int overlap = 10;                      ///< Each picture is matched with so many after it (COLMAP's default).
  int threads = 0;                       ///< 0 = all processors.
  double patience_seconds = 600;         ///< For all steps together.
};

struct ColmapResult {
  std::string failure;                   ///< What went wrong; empty = nothing.
  std::vector<Camera> cameras;           ///< One per frame.
  std::vector<std::uint8_t> registered;  ///< Per frame: 1 = COLMAP gave it a pose.
  std::size_t points = 0;
  double seconds = 0;            ///< Features, matches and mapper together.
  double processor_seconds = 0;  ///< The same, of all threads.
};

/// Works in `folder`, which is created and left behind with COLMAP's log. Features on the processor, one camera for all
/// pictures, neighbours in time matched, no loops looked for. Of several models the largest is taken. Throws Error when
/// the folder cannot be written; what goes wrong with COLMAP is in the result.
ColmapResult run_colmap(std::span<const ImageRgb> frames, const std::string& folder, const ColmapOptions& options);

}  // namespace uwv::bench
