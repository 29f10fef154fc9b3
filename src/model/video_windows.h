// SPDX-License-Identifier: Apache-2.0
// A clip through a network that sees a window of frames at a time, joined into one (geometry sheet 4.5).
#pragma once

#include <vector>

#include "model/depth_manifest.h"
#include "model/map_resize.h"

namespace uwv::model {

/// For each window, which frame of the clip stands at each position. Past the clip's end its last frame is repeated. A
/// window that would bring nothing new is left out (the official code runs one more for some lengths).
std::vector<std::vector<int>> plan_windows(const WindowRule& rule, int frames);

/// y = scale * x + shift, least squares over the pixels known in both. Pixels without variation give scale 1.
struct ScaleShift {
  double scale = 1, shift = 0;
};
ScaleShift fit_scale_shift(const std::vector<const KnownMap*>& x, const std::vector<const KnownMap*>& y);

/// Takes windows in order.
class WindowJoiner {
 public:
  /// `align`: bring each window to the scale and shift of the one before; networks of metric depth need none.
  WindowJoiner(const WindowRule& rule, bool align) : rule_(rule), align_(align) {}
  /// Returns the scale and shift that were applied.
  ScaleShift add(std::vector<KnownMap> window);
  /// The clip's maps, joined; `frames` of them.
  std::vector<KnownMap> take(int frames);

 private:
  ScaleShift fitted(const std::vector<KnownMap>& window) const;
  void blend_end(const std::vector<KnownMap>& window);

  WindowRule rule_;
  bool align_;
  std::vector<KnownMap> joined_;
  std::vector<KnownMap> references_;  ///< Joined maps of the frames at positions 0 .. tied-1 of the next window.
};

}  // namespace uwv::model
