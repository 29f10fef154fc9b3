// SPDX-License-Identifier: Apache-2.0
// A hall put together from KayKit's dungeon models, through which one walks with a camera in the hand.
#pragma once

#include <string>
#include <vector>

#include "uwv/eval/mesh_scene.h"

namespace uwv::bench {

struct DungeonClip {
  MeshScene scene;
  std::vector<Camera> cameras;  ///< One per frame. The world has y down, the floor is at y = 0, a unit about a metre.
  double fps = 16;
  int figure = -1;  ///< The instance that moves; -1 = none.
};

/// `models` holds kaykit_dungeon_CC0/gltf/*.glb and, for the figure that walks through the picture,
/// kaykit_adventurers_CC0/Knight.glb. Their flat colours are multiplied with clouds, as nothing could be tracked on
/// them otherwise. Throws Error when a model is missing.
DungeonClip dungeon_clip(const std::string& models, Size size, int frames, bool with_figure);

}  // namespace uwv::bench
