// SPDX-License-Identifier: Apache-2.0
// What a depth network says of a clip, brought together with cameras that it may not know (paper, Sec. "Geometry").
//
// Its depth stays as it is where nothing contradicts it; where the cameras were measured in another unit, or the
// network leaves scale and shift open, it is aligned to what was measured, or to the prior where nothing was.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <vector>

#include "uwv/core/thread_pool.h"
#include "uwv/geometry/layers.h"
#include "uwv/geometry/scene_geometry.h"
#include "uwv/geometry/structure_from_motion.h"
#include "uwv/model/depth_network.h"

namespace uwv::pipeline {

class NetworkGeometry {
 public:
  /// Runs the network over the clip, which must outlive this.
  NetworkGeometry(DepthNetwork& network, std::span<const ImageRgb> frames, ThreadPool& pool, Monitor& monitor);

  /// The lens it saw, the median over the frames; empty when it says nothing of one.
  std::optional<Intrinsics> lens() const;
  bool has_cameras() const { return !seen_.world_from_cam.empty(); }
  /// True when its depth means nothing without a reference.
  bool needs_reference() const { return seen_.meaning == NetworkDepth::inverse_affine; }

  /// The network's own cameras, with `known` in place of its lens where that is given. has_cameras() must hold.
  std::vector<Camera> cameras(const std::optional<Intrinsics>& known) const;

  /// Puts the network's depth into `scene`, whose cameras are there already. Its unit becomes the cameras' where
  /// `points` tell how large that is (but metres where the network knows them: then the cameras are scaled). Without
  /// points, `standing` says that a pixel keeps its depth unless something moves, which steadies networks that see each
  /// frame alone; a network that needs a reference takes the depth that is in `scene`.
  void place(std::span<const ScenePoint> points, bool standing, SceneGeometry& scene);

  /// The depth of the clip without its foreground, by the same network: 1/depth is fitted to `scene` where nothing was
  /// in the way, so that the two layers meet (paper, "Layer-wise Point Cloud Construction").
  std::vector<DepthMap> behind(std::span<const ImageRgb> background, std::span<const ForegroundMask> foreground,
                               const SceneGeometry& scene);

  /// For run.json: the network's name, what its numbers are, how they were aligned, seconds.
  const nlohmann::ordered_json& facts() const { return facts_; }

 private:
  void take_as_is(SceneGeometry& scene) const;
  void align(std::span<const ScenePoint> points, SceneGeometry& scene);
  void steady(SceneGeometry& scene);
  void keep_confidence(SceneGeometry& scene) const;

  DepthNetwork& network_;
  ThreadPool& pool_;
  Monitor& monitor_;
  DepthNetworkResult seen_;
  nlohmann::ordered_json facts_;
};

}  // namespace uwv::pipeline
