// SPDX-License-Identifier: Apache-2.0
#include "model/diffusion/windows.h"

#include <algorithm>

#include "uwv/core/error.h"

namespace uwv::model {
namespace {

/// A window's own weights, before those of its neighbours are known: up from its beginning, down to its end, unless
/// that is the clip's.
void set_ramps(Window& window, std::int64_t latents, std::int64_t ramp) {
  window.weights.assign(static_cast<std::size_t>(window.count), 1.0F);
  const auto slope = [&](std::int64_t from_end) {
    return std::min(1.0F, (static_cast<float>(from_end) + 0.5F) / static_cast<float>(ramp));
  };
  for (std::int64_t i = 0; i < window.count; ++i) {
    float& weight = window.weights[static_cast<std::size_t>(i)];
    if (window.first > 0) weight = std::min(weight, slope(i));
    if (window.first + window.count < latents) weight = std::min(weight, slope(window.count - 1 - i));
  }
}

void normalise(std::vector<Window>& windows, std::int64_t latents) {
  std::vector<float> sums(static_cast<std::size_t>(latents));
  for (const Window& window : windows)
    for (std::int64_t i = 0; i < window.count; ++i)
      sums[static_cast<std::size_t>(window.first + i)] += window.weights[static_cast<std::size_t>(i)];
  for (Window& window : windows)
    for (std::int64_t i = 0; i < window.count; ++i)
      window.weights[static_cast<std::size_t>(i)] /= sums[static_cast<std::size_t>(window.first + i)];
}

}  // namespace

void WindowOptions::check() const {
  require(frames >= 5 && frames % 4 == 1, "window_frames: found {}, wanted 1 + 4k, at least 5", frames);
  require(overlap >= 4 && overlap % 4 == 0 && overlap < frames - 1,
          "window_overlap: found {}, wanted a multiple of 4 below window_frames {}", overlap, frames);
}

std::vector<Window> plan_windows(std::int64_t latents, const WindowOptions& options) {
  options.check();
  require(latents >= 1, "a clip has {} latent frames, wanted 1 or more", latents);
  const std::int64_t length = std::min<std::int64_t>(1 + (options.frames - 1) / 4, latents);
  const std::int64_t overlap = options.overlap / 4, stride = length - overlap;
  const std::int64_t count = length == latents ? 1 : 1 + (latents - length + stride - 1) / stride;
  std::vector<Window> windows(static_cast<std::size_t>(count));
  for (std::int64_t k = 0; k < count; ++k) {
    Window& window = windows[static_cast<std::size_t>(k)];
    window.first = count == 1 ? 0 : k * (latents - length) / (count - 1);
    window.count = length;
    set_ramps(window, latents, overlap);
  }
  normalise(windows, latents);
  return windows;
}

}  // namespace uwv::model
