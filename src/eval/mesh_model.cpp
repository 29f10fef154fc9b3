// SPDX-License-Identifier: Apache-2.0
#include "uwv/eval/mesh_model.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "mesh_data.h"
#include "uwv/core/error.h"

namespace uwv {
namespace {

using Eigen::Affine3d;
using Eigen::Vector3d;

std::vector<std::byte> file_bytes(const std::string& path) {
  std::error_code problem;
  const std::uintmax_t size = std::filesystem::file_size(path, problem);
  if (problem) fail(ErrorCode::file_not_found, "{}: cannot be opened: {}", path, problem.message());
  constexpr std::uintmax_t largest = 1U << 30;
  if (size > largest) fail(ErrorCode::file_damaged, "{}: has {} bytes, models up to {} are read", path, size, largest);
  std::vector<std::byte> bytes(size);
  std::ifstream file(path, std::ios::binary);
  if (!file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size)))
    fail(ErrorCode::file_damaged, "{}: cannot be read to its end", path);
  return bytes;
}

Eigen::Quaterniond quaternion(const Eigen::Vector4d& xyzw) {
  return Eigen::Quaterniond(xyzw[3], xyzw[0], xyzw[1], xyzw[2]).normalized();
}

Eigen::Vector4d value_at(const MeshChannel& channel, double time) {
  const auto after = std::upper_bound(channel.times.begin(), channel.times.end(), time);
  if (after == channel.times.begin()) return channel.values.front();
  const auto next = static_cast<std::size_t>(after - channel.times.begin());
  if (after == channel.times.end() || channel.steps) return channel.values[next - 1];
  const double share = (time - channel.times[next - 1]) / (channel.times[next] - channel.times[next - 1]);
  const Eigen::Vector4d &a = channel.values[next - 1], &b = channel.values[next];
  if (channel.target == MeshChannel::Target::rotation) return quaternion(a).slerp(share, quaternion(b)).coeffs();
  return a + share * (b - a);
}

void apply(const MeshAnimation& animation, double time, std::vector<MeshNode>& nodes) {
  for (const MeshChannel& channel : animation.channels) {
    const Eigen::Vector4d value = value_at(channel, time);
    MeshNode& node = nodes[static_cast<std::size_t>(channel.node)];
    switch (channel.target) {
      case MeshChannel::Target::translation: node.translation = value.head<3>(); break;
      case MeshChannel::Target::rotation: node.rotation = quaternion(value); break;
      case MeshChannel::Target::scale: node.scale = value.head<3>(); break;
    }
  }
}

std::vector<Affine3d> model_from_nodes(const std::vector<MeshNode>& nodes, const std::vector<int>& parents_first) {
  std::vector<Affine3d> out(nodes.size());
  for (const int i : parents_first) {
    const MeshNode& node = nodes[static_cast<std::size_t>(i)];
    const Affine3d own =
        node.matrix ? *node.matrix
                    : Affine3d(Eigen::Translation3d(node.translation) * node.rotation * Eigen::Scaling(node.scale));
    out[static_cast<std::size_t>(i)] = node.parent < 0 ? own : out[static_cast<std::size_t>(node.parent)] * own;
  }
  return out;
}

/// The vertices of one surface. A skinned one follows its joints and not the node it hangs on (glTF 2.0, 3.7.3.3).
void place(const MeshSurface& surface, const MeshSkin* skin, const Affine3d& model_from_node,
           const std::vector<Affine3d>& model_from_nodes, std::vector<Vector3d>& out) {
  if (skin == nullptr || surface.joints.empty()) {
    for (const Vector3d& x : surface.positions) out.push_back(model_from_node * x);
    return;
  }
  std::vector<Affine3d> model_from_mesh;
  for (std::size_t k = 0; k < skin->joints.size(); ++k)
    model_from_mesh.push_back(model_from_nodes[static_cast<std::size_t>(skin->joints[k])] * skin->joint_from_mesh[k]);
  for (std::size_t i = 0; i < surface.positions.size(); ++i) {
    Vector3d sum = Vector3d::Zero();
    for (std::size_t k = 0; k < 4; ++k)
      sum += surface.weights[i][static_cast<Eigen::Index>(k)] *
             (model_from_mesh[static_cast<std::size_t>(surface.joints[i][k])] * surface.positions[i]);
    out.push_back(sum);
  }
}

}  // namespace

struct MeshModel::State {
  std::string name;
  MeshData data;
  std::vector<bool> drawn;  // per node
  std::vector<MeshTriangle> triangles;
  std::vector<Eigen::Vector2d> texture_coordinates;
  std::vector<Vector3d> rest;

  const MeshAnimation& animation(std::string_view wanted) const {
    std::string known;
    for (const MeshAnimation& each : data.animations) {
      if (each.name == wanted) return each;
      known += (known.empty() ? "" : ", ") + each.name;
    }
    fail(ErrorCode::value_invalid, "{}: has no animation '{}'; it has {}", name, wanted,
         known.empty() ? "none" : known);
  }

  /// Calls visit(node, surface) in the order of the vertices.
  template <class Visitor>
  void for_each_surface(const Visitor& visit) const {
    for (std::size_t i = 0; i < data.nodes.size(); ++i) {
      if (!drawn[i] || data.nodes[i].mesh < 0) continue;
      for (const MeshSurface& surface : data.meshes[static_cast<std::size_t>(data.nodes[i].mesh)]) visit(i, surface);
    }
  }

  std::vector<Vector3d> vertices(const std::vector<MeshNode>& nodes) const {
    const std::vector<Affine3d> from_nodes = model_from_nodes(nodes, data.parents_first);
    std::vector<Vector3d> out;
    out.reserve(texture_coordinates.size());
    for_each_surface([&](std::size_t i, const MeshSurface& surface) {
      const int skin = nodes[i].skin;
      place(surface, skin < 0 ? nullptr : &data.skins[static_cast<std::size_t>(skin)], from_nodes[i], from_nodes, out);
    });
    return out;
  }

  void require_size(std::size_t max_triangles) const {
    std::size_t count = 0;
    // Vertices that no triangle uses take memory too.
    for_each_surface([&](std::size_t, const MeshSurface& surface) {
      count += std::max(surface.positions.size() / 3, surface.triangles.size());
    });
    if (count > max_triangles)
      fail(ErrorCode::out_of_memory, "{}: its nodes come to {} triangles, {} are allowed (max_triangles)", name, count,
           max_triangles);
  }

  void lay_out() {
    for_each_surface([&](std::size_t, const MeshSurface& surface) {
      const int first = static_cast<int>(texture_coordinates.size());
      for (const auto& corners : surface.triangles)
        triangles.push_back({{first + corners[0], first + corners[1], first + corners[2]}, surface.material});
      if (surface.texture_coordinates.empty())
        texture_coordinates.insert(texture_coordinates.end(), surface.positions.size(), Eigen::Vector2d::Zero());
      else
        texture_coordinates.insert(texture_coordinates.end(), surface.texture_coordinates.begin(),
                                   surface.texture_coordinates.end());
    });
    rest = vertices(data.nodes);
  }
};

MeshModel::MeshModel() : state_(std::make_shared<State>()) {}

MeshModel MeshModel::read(const std::string& path, const MeshModelOptions& options) {
  return from_bytes(file_bytes(path), path, options);
}

MeshModel MeshModel::from_bytes(std::span<const std::byte> glb, const std::string& name,
                                const MeshModelOptions& options) {
  auto state = std::make_shared<State>();
  state->name = name;
  state->data = read_glb(glb, name);
  for (const MeshNode& node : state->data.nodes)
    state->drawn.push_back(std::find(options.hidden.begin(), options.hidden.end(), node.name) == options.hidden.end());
  state->require_size(options.max_triangles);
  state->lay_out();
  return MeshModel(std::move(state));
}

const std::vector<MeshTriangle>& MeshModel::triangles() const { return state_->triangles; }
const std::vector<MeshMaterial>& MeshModel::materials() const { return state_->data.materials; }
const std::vector<ImageRgb>& MeshModel::textures() const { return state_->data.textures; }
const std::vector<Eigen::Vector2d>& MeshModel::texture_coordinates() const { return state_->texture_coordinates; }
const std::vector<Vector3d>& MeshModel::rest() const { return state_->rest; }

std::vector<std::string> MeshModel::animations() const {
  std::vector<std::string> names;
  for (const MeshAnimation& animation : state_->data.animations) names.push_back(animation.name);
  return names;
}

double MeshModel::duration(std::string_view animation) const { return state_->animation(animation).duration; }

std::vector<Vector3d> MeshModel::posed(std::string_view animation, double time) const {
  const MeshAnimation& found = state_->animation(animation);
  require(std::isfinite(time), "the time of an animation must be finite, not {}", time);
  std::vector<MeshNode> nodes = state_->data.nodes;
  // The end is the beginning of the next round, except for an animation of one instant.
  const double round = found.duration > 0 ? time - found.duration * std::floor(time / found.duration) : 0;
  apply(found, round, nodes);
  return state_->vertices(nodes);
}

}  // namespace uwv
