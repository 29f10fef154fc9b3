// SPDX-License-Identifier: Apache-2.0
// How a clip longer than the network takes at once is cut into windows that overlap.
//
// All windows are denoised together, step by step: where they overlap, their velocities are averaged with weights that
// fall linearly towards each window's end, so that no frame is where one window stops and another begins. See
// docs/model.md for what the alternatives measured.
#pragma once

#include <cstdint>
#include <vector>

namespace uwv::model {

struct WindowOptions {
  int frames = 81;   ///< Of a window, 1 + 4k; 81 is what the network was trained on. Memory and time grow with it.
  int overlap = 20;  ///< Frames two neighbours share at least; 4k. More is smoother and costs frames computed twice.

  /// Throws std::invalid_argument.
  void check() const;
};

/// A stretch of latent frames.
struct Window {
  std::int64_t first = 0, count = 0;
  std::vector<float> weights;  ///< One a latent frame; those of all windows over a frame sum to 1.
};

/// Windows over `latents` latent frames: of equal length, the same distance apart within a latent. One when all fit.
std::vector<Window> plan_windows(std::int64_t latents, const WindowOptions& options);

}  // namespace uwv::model
