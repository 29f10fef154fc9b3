// SPDX-License-Identifier: Apache-2.0
// Scenes of triangle models with exact truth: like synthetic_scene.h, with shapes an artist made and figures that move.
//
// Depth is where the ray through a pixel's centre meets a triangle's plane, in double precision; a triangle is never
// approximated by its projected corners, needs no near plane, and neighbours sharing an edge leave no gap.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "uwv/eval/mesh_model.h"
#include "uwv/eval/synthetic_scene.h"

namespace uwv {

struct MeshInstance {
  std::string name;
  MeshModel model;
  double scale = 1;            ///< Applied in the model's frame.
  Rigid3 world_from_model;     ///< Models have y up.
  std::string animation;       ///< Empty = at rest.
  double animation_start = 0;  ///< Seconds of the animation at time 0.
  /// `world_from_model` at a time in seconds, in place of the fixed one; empty = stays where it is.
  std::function<Rigid3(double time)> motion;
  /// Each multiplied with the model's colours, mid-grey (0.5) leaving them as they are; looked up at the surface's
  /// place at rest in the model's frame, so that they stick to skin that moves. Models for games are flat, and cameras
  /// are found from texture. One noise repeats itself nearly, two of different seeds do so no more.
  std::vector<Texture> details;
  double detail_strength = 1;  ///< 0 = the details change nothing, 1 = they are as strong as they say.
  /// 0..1: darkens surfaces by their normal at rest, which makes form visible and leaves every point its one colour.
  double shading = 0.5;
};

struct MeshScene {
  std::vector<MeshInstance> instances;
  Colour background = Colour::Zero();  ///< Where nothing is hit.
};

/// As render() of a Scene; `object` holds indices into MeshScene::instances. Normals are the triangles' own. Colour is
/// the mean of supersample^2 samples a pixel (>= 1), all else one ray through the pixel's centre.
SyntheticFrame render(const MeshScene& scene, const Camera& camera, double time, ThreadPool& pool, int supersample = 2);

}  // namespace uwv
