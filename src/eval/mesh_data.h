// SPDX-License-Identifier: Apache-2.0
// A model as the file describes it, checked: every index below is in range and the nodes form trees.
#pragma once

#include <Eigen/Geometry>

#include <optional>

#include "uwv/eval/mesh_model.h"

namespace uwv {

struct MeshSurface {
  std::vector<Eigen::Vector3d> positions;
  std::vector<Eigen::Vector2d> texture_coordinates;  // empty or one per position
  std::vector<std::array<int, 4>> joints;            // empty or one per position
  std::vector<Eigen::Vector4d> weights;              // as joints
  std::vector<std::array<int, 3>> triangles;
  int material = -1;
  int joints_used = 0;  // highest joint + 1
};

struct MeshNode {
  std::string name;
  int parent = -1;
  int mesh = -1;
  int skin = -1;
  std::optional<Eigen::Affine3d> matrix;  // in place of the three below
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d scale = Eigen::Vector3d::Ones();
};

struct MeshSkin {
  std::vector<int> joints;                       // nodes
  std::vector<Eigen::Affine3d> joint_from_mesh;  // at rest
};

struct MeshChannel {
  enum class Target { translation, rotation, scale };
  int node = 0;
  Target target = Target::translation;
  bool steps = false;
  std::vector<double> times;            // increasing, at least one
  std::vector<Eigen::Vector4d> values;  // one per time; rotations as x y z w
};

struct MeshAnimation {
  std::string name;
  std::vector<MeshChannel> channels;
  double duration = 0;
};

struct MeshData {
  std::vector<std::vector<MeshSurface>> meshes;
  std::vector<MeshNode> nodes;
  std::vector<int> parents_first;  // all nodes, each after its parent
  std::vector<MeshSkin> skins;
  std::vector<MeshAnimation> animations;
  std::vector<MeshMaterial> materials;
  std::vector<ImageRgb> textures;
};

/// Throws Error as MeshModel::from_bytes does.
MeshData read_glb(std::span<const std::byte> glb, const std::string& name);

}  // namespace uwv
