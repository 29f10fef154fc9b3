// SPDX-License-Identifier: Apache-2.0
// A hall put together from KayKit's dungeon models, through which one walks with a camera in the hand.
#pragma once

#include <string>
#include <vector>

#include "bench/true_clip.h"
#include "uwv/eval/mesh_scene.h"

namespace uwv::bench {

struct DungeonOptions {
  int frames = 81;
  /// How strong the clouds are that the models' flat colours are multiplied with; nothing could be tracked on the
  /// models without. 0 = none, 1 = strong everywhere.
  double texture = 0.4;
  double travel = 1;  ///< The camera's way, as a multiple of a step of 2.8 units to the side and 0.9 forwards.
  bool figure = true;
  /// Units from the camera's way to the figure's, which is 1.7 tall: at 4 it takes a tenth of the picture, at 2 a
  /// third, at 1.4 a half.
  double figure_distance = 4;
  /// Throws std::invalid_argument when a value is out of range.
  void check() const;
};

struct DungeonClip {
  MeshScene scene;
  std::vector<Camera> cameras;  ///< One per frame. The world has y down, the floor is at y = 0, a unit about a metre.
  double fps = 16;
  int figure = -1;  ///< The instance that moves; -1 = none.
};

/// `models` holds kaykit_dungeon_CC0/gltf/*.glb and, for the figure that walks through the picture,
/// kaykit_adventurers_CC0/Knight.glb. Throws Error when a model is missing.
DungeonClip dungeon_clip(const std::string& models, Size size, const DungeonOptions& options);

/// A frame as saved and judged: 2x2 rays a pixel.
SyntheticFrame render_frame(const DungeonClip& clip, int frame, ThreadPool& pool);
/// All of them, with all that is true about them.
TrueClip render_clip(const DungeonClip& clip, const std::string& name, ThreadPool& pool);

}  // namespace uwv::bench
