// SPDX-License-Identifier: Apache-2.0
// Clips of the stock scenes filmed by a camera on an orbit, with everything about them known.
#pragma once

#include <numbers>
#include <vector>

#include "uwv/eval/stock_scenes.h"
#include "uwv/geometry/scene_geometry.h"

namespace uwv::testing {

struct OrbitingClip {
  std::vector<ImageRgb> frames;
  std::vector<Camera> cameras;
  std::vector<FrameGeometry> truth;         ///< Exact depth, confidence 1 where there is any.
  std::vector<Image<std::int32_t>> object;  ///< Index into the scene's objects.
};

/// `frames` frames during which the camera turns by `degrees` around the subject while `seconds` pass.
inline OrbitingClip orbiting_clip(const StockScene& stock, int frames, double degrees, double seconds,
                                  ThreadPool& pool) {
  OrbitingClip clip;
  for (int i = 0; i < frames; ++i) {
    const double share = frames > 1 ? static_cast<double>(i) / (frames - 1) : 0.0;
    const double angle = (share - 0.5) * degrees * std::numbers::pi / 180;
    const Camera camera = orbit_camera(stock.source, stock.subject_in_world, angle);
    SyntheticFrame seen = render(stock.scene, camera, share * seconds, pool, 2);
    ConfidenceMap confidence(camera.size);
    for (std::size_t p = 0; p < confidence.pixels().size(); ++p)
      confidence.pixels()[p] = seen.depth.pixels()[p] > 0 ? 1.0F : 0.0F;
    clip.frames.push_back(std::move(seen.colour));
    clip.cameras.push_back(camera);
    clip.truth.push_back({std::move(seen.depth), std::move(confidence)});
    clip.object.push_back(std::move(seen.object));
  }
  return clip;
}

}  // namespace uwv::testing
