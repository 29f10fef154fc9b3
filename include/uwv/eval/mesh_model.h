// SPDX-License-Identifier: Apache-2.0
// Triangle models from binary glTF files (.glb): meshes, node transforms, base colours and textures, skins and linear
// animations. What a clip of evaluation needs and no more: no lights, no morph targets, no materials beyond the base
// colour.
//
// The model's frame is glTF's: right-handed, y up, metres as the artist meant them. Files are not trusted: indices,
// sizes and the node tree are checked, nothing outside the file is opened.
#pragma once

#include <Eigen/Core>

#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "uwv/core/image.h"
#include "uwv/eval/texture.h"

namespace uwv {

struct MeshModelOptions {
  std::vector<std::string> hidden;  ///< Names of nodes whose mesh is left out, as models bring all their tools at once.
  /// A file can name one mesh in many nodes, so its triangles are not bounded by its size. A few gigabytes of vertices.
  std::size_t max_triangles = 10'000'000;
};

struct MeshTriangle {
  std::array<int, 3> corners{};  ///< Indices of vertices.
  int material = -1;             ///< -1 = white.
};

struct MeshMaterial {
  Colour base = Colour::Ones();  ///< Multiplied with the texture; values as in the texture (sRGB).
  int texture = -1;              ///< Index into MeshModel::textures(), -1 = none.
};

/// A model in memory. Copies share what they hold; reading is thread-safe.
class MeshModel {
 public:
  /// Without any triangle.
  MeshModel();
  /// Throws Error: file_not_found, format_unknown (no binary glTF), file_damaged (truncated, indices or sizes that lie,
  /// a node that is its own ancestor), value_invalid (something of glTF that is not supported), out_of_memory.
  static MeshModel read(const std::string& path, const MeshModelOptions& options = {});
  /// The same from a file's bytes; `name` is what errors call it.
  static MeshModel from_bytes(std::span<const std::byte> glb, const std::string& name,
                              const MeshModelOptions& options = {});

  const std::vector<MeshTriangle>& triangles() const;
  const std::vector<MeshMaterial>& materials() const;
  const std::vector<ImageRgb>& textures() const;
  /// One per vertex; (0, 0) where the file has none. (0, 0) is the texture's upper left corner; it repeats.
  const std::vector<Eigen::Vector2d>& texture_coordinates() const;
  /// Vertices in the model's frame with all nodes at rest.
  const std::vector<Eigen::Vector3d>& rest() const;

  std::vector<std::string> animations() const;
  /// Seconds; throws Error(value_invalid) listing the animations there are.
  double duration(std::string_view animation) const;
  /// Vertices in the model's frame at a time of an animation, in seconds; the animation repeats. Rotations are
  /// interpolated along the sphere, all else linearly, and skins are blended linearly.
  std::vector<Eigen::Vector3d> posed(std::string_view animation, double time) const;

 private:
  struct State;
  explicit MeshModel(std::shared_ptr<const State> state) : state_(std::move(state)) {}
  std::shared_ptr<const State> state_;
};

}  // namespace uwv
