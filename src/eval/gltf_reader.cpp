// SPDX-License-Identifier: Apache-2.0
#include <tiny_gltf.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "gltf_accessor.h"
#include "mesh_data.h"
#include "uwv/core/error.h"

namespace uwv {
namespace {

/// tinygltf's texts have line breaks and no end; one sentence is what people get.
std::string one_line(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  constexpr std::size_t longest = 200;
  if (text.size() > longest) text.resize(longest);
  while (!text.empty() && text.back() == ' ') text.pop_back();
  return text.empty() ? "no reason given" : text;
}

/// Pictures are decoded later, from bytes whose place in the file has been checked. Those in the JSON itself have no
/// such place and are kept here.
bool keep_encoded(tinygltf::Image* image, int, std::string*, std::string*, int, int, const unsigned char* bytes,
                  int size, void*) {
  if (image->bufferView < 0 && size > 0) image->image.assign(bytes, bytes + size);
  return true;
}

tinygltf::Model parse(std::span<const std::byte> glb, const std::string& name) {
  constexpr std::size_t header = 20;
  const auto* bytes = reinterpret_cast<const unsigned char*>(glb.data());
  if (glb.size() < header || std::string_view(reinterpret_cast<const char*>(bytes), 4) != "glTF")
    fail(ErrorCode::format_unknown, "{}: is no binary glTF file (.glb)", name);
  if (glb.size() > std::numeric_limits<unsigned>::max())
    fail(ErrorCode::file_damaged, "{}: has {} bytes; binary glTF ends at 4 GB", name, glb.size());
  tinygltf::TinyGLTF reader;
  reader.SetFsCallbacks({});  // a file may name others on this machine: none is opened
  reader.SetImageLoader(keep_encoded, nullptr);
  tinygltf::Model model;
  std::string error, warning;
  bool read = false;
  try {
    read = reader.LoadBinaryFromMemory(&model, &error, &warning, bytes, static_cast<unsigned>(glb.size()));
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& problem) {
    error = problem.what();
  }
  if (!read) fail(ErrorCode::file_damaged, "{}: cannot be read as glTF: {}", name, one_line(error));
  return model;
}

/// Checks an index that may be absent (-1).
int checked(int index, std::size_t count, const char* what, const std::string& name) {
  if (index < -1 || (index >= 0 && static_cast<std::size_t>(index) >= count))
    fail(ErrorCode::file_damaged, "{}: {} {} is wanted, the file has {}", name, what, index, count);
  return index;
}

template <int N>
std::vector<Eigen::Matrix<double, N, 1>> vectors(const GltfAccessors& accessors, int accessor) {
  const std::vector<double> numbers = accessors.read(accessor, N);
  std::vector<Eigen::Matrix<double, N, 1>> out(numbers.size() / N);
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = Eigen::Map<const Eigen::Matrix<double, N, 1>>(&numbers[i * N]);
  return out;
}

std::vector<Eigen::Affine3d> transforms(const GltfAccessors& accessors, int accessor) {
  std::vector<Eigen::Affine3d> out;
  for (const auto& numbers : vectors<16>(accessors, accessor))
    out.emplace_back(Eigen::Matrix4d(Eigen::Map<const Eigen::Matrix4d>(numbers.data())));
  return out;
}

int attribute(const tinygltf::Primitive& primitive, const char* name) {
  const auto found = primitive.attributes.find(name);
  return found == primitive.attributes.end() ? -1 : found->second;
}

/// Throws unless there is one for each of `wanted` vertices.
template <class T>
void require_one_each(const std::vector<T>& values, std::size_t wanted, const char* what, const std::string& name) {
  if (values.size() != wanted)
    fail(ErrorCode::file_damaged, "{}: {} vertices have {} {}", name, wanted, values.size(), what);
}

void read_triangles(const GltfAccessors& accessors, const tinygltf::Primitive& primitive, MeshSurface& surface) {
  std::vector<double> corners;
  const std::size_t vertices = surface.positions.size();
  if (primitive.indices >= 0)
    corners = accessors.read(primitive.indices, 1);
  else
    for (std::size_t i = 0; i < vertices; ++i) corners.push_back(static_cast<double>(i));
  if (corners.size() % 3 != 0)
    fail(ErrorCode::file_damaged, "{}: {} corners are no whole number of triangles", accessors.name(), corners.size());
  for (const double corner : corners)
    if (!(corner >= 0 && corner < static_cast<double>(vertices)))
      fail(ErrorCode::file_damaged, "{}: a triangle wants vertex {}, its mesh has {}", accessors.name(), corner,
           vertices);
  surface.triangles.reserve(corners.size() / 3);
  for (std::size_t i = 0; i < corners.size(); i += 3)
    surface.triangles.push_back(
        {static_cast<int>(corners[i]), static_cast<int>(corners[i + 1]), static_cast<int>(corners[i + 2])});
}

void read_skin_weights(const GltfAccessors& accessors, const tinygltf::Primitive& primitive, MeshSurface& surface) {
  const int joints = attribute(primitive, "JOINTS_0"), weights = attribute(primitive, "WEIGHTS_0");
  if (joints < 0 || weights < 0) return;
  surface.weights = vectors<4>(accessors, weights);
  require_one_each(surface.weights, surface.positions.size(), "skin weights", accessors.name());
  const auto wanted = vectors<4>(accessors, joints);
  require_one_each(wanted, surface.positions.size(), "joints", accessors.name());
  for (const Eigen::Vector4d& four : wanted) {
    if (!(four.minCoeff() >= 0 && four.maxCoeff() <= 65535))
      fail(ErrorCode::file_damaged, "{}: joint {} is wanted", accessors.name(), four.maxCoeff());
    surface.joints.push_back({});
    for (std::size_t k = 0; k < 4; ++k) {
      surface.joints.back()[k] = static_cast<int>(four[static_cast<Eigen::Index>(k)]);
      surface.joints_used = std::max(surface.joints_used, surface.joints.back()[k] + 1);
    }
  }
  // Files round their weights; a sum that is not 1 would move the vertex.
  for (Eigen::Vector4d& four : surface.weights) {
    const double sum = four.sum();
    if (!(sum > 0) || four.minCoeff() < 0)
      fail(ErrorCode::file_damaged, "{}: a vertex has skin weights that are negative or sum up to 0", accessors.name());
    four /= sum;
  }
}

MeshSurface read_surface(const GltfAccessors& accessors, const tinygltf::Model& model,
                         const tinygltf::Primitive& primitive) {
  MeshSurface surface;
  if (primitive.mode != TINYGLTF_MODE_TRIANGLES && primitive.mode != -1)
    fail(ErrorCode::value_invalid, "{}: has a mesh of points, lines or strips; triangles are wanted", accessors.name());
  if (!primitive.extensions.empty() && primitive.extensions.count("KHR_draco_mesh_compression") != 0)
    fail(ErrorCode::value_invalid, "{}: its meshes are compressed (Draco), which is not supported", accessors.name());
  surface.positions = vectors<3>(accessors, attribute(primitive, "POSITION"));
  surface.material = checked(primitive.material, model.materials.size(), "material", accessors.name());
  if (const int uv = attribute(primitive, "TEXCOORD_0"); uv >= 0) {
    surface.texture_coordinates = vectors<2>(accessors, uv);
    require_one_each(surface.texture_coordinates, surface.positions.size(), "texture coordinates", accessors.name());
  }
  read_triangles(accessors, primitive, surface);
  read_skin_weights(accessors, primitive, surface);
  return surface;
}

/// Copies as many numbers as glTF prescribes into `out`; absent means as it was.
template <class Vector>
void take(const std::vector<double>& numbers, Vector&& out, const std::string& name) {
  if (numbers.empty()) return;
  const bool finite = std::all_of(numbers.begin(), numbers.end(), [](double v) { return std::isfinite(v); });
  if (numbers.size() != static_cast<std::size_t>(out.size()) || !finite)
    fail(ErrorCode::file_damaged, "{}: a node's transform has {} numbers, {} finite ones are wanted", name,
         numbers.size(), out.size());
  std::copy(numbers.begin(), numbers.end(), out.data());
}

MeshNode read_node(const tinygltf::Model& model, const tinygltf::Node& from, const std::string& name) {
  MeshNode node;
  node.name = from.name;
  node.mesh = checked(from.mesh, model.meshes.size(), "mesh", name);
  node.skin = checked(from.skin, model.skins.size(), "skin", name);
  take(from.translation, node.translation, name);
  take(from.scale, node.scale, name);
  take(from.rotation, node.rotation.coeffs(), name);  // both in the order x y z w
  if (!(node.rotation.norm() > 0.5)) fail(ErrorCode::file_damaged, "{}: a node's rotation is no quaternion", name);
  node.rotation.normalize();
  if (!from.matrix.empty()) {
    Eigen::Matrix4d matrix;
    take(from.matrix, matrix, name);
    node.matrix = Eigen::Affine3d(matrix);
  }
  return node;
}

void link_nodes(const tinygltf::Model& model, MeshData& data, const std::string& name) {
  for (std::size_t i = 0; i < model.nodes.size(); ++i)
    for (const int child : model.nodes[i].children) {
      if (child < 0) fail(ErrorCode::file_damaged, "{}: node {} is wanted", name, child);
      MeshNode& node = data.nodes[static_cast<std::size_t>(checked(child, data.nodes.size(), "node", name))];
      if (node.parent >= 0) fail(ErrorCode::file_damaged, "{}: node {} has two parents", name, child);
      node.parent = static_cast<int>(i);
    }
  for (std::size_t i = 0; i < data.nodes.size(); ++i)
    if (data.nodes[i].parent < 0) data.parents_first.push_back(static_cast<int>(i));
  for (std::size_t k = 0; k < data.parents_first.size(); ++k)
    for (const int child : model.nodes[static_cast<std::size_t>(data.parents_first[k])].children)
      data.parents_first.push_back(child);
  if (data.parents_first.size() != data.nodes.size())
    fail(ErrorCode::file_damaged, "{}: a node is its own ancestor", name);
}

MeshSkin read_skin(const GltfAccessors& accessors, const tinygltf::Skin& from, std::size_t nodes) {
  MeshSkin skin;
  for (const int joint : from.joints) {
    if (checked(joint, nodes, "node", accessors.name()) < 0)
      fail(ErrorCode::file_damaged, "{}: a skin's joint is no node", accessors.name());
    skin.joints.push_back(joint);
  }
  if (from.inverseBindMatrices < 0)
    skin.joint_from_mesh.assign(skin.joints.size(), Eigen::Affine3d::Identity());
  else
    skin.joint_from_mesh = transforms(accessors, from.inverseBindMatrices);
  require_one_each(skin.joint_from_mesh, skin.joints.size(), "skin matrices", accessors.name());
  return skin;
}

MeshChannel read_channel(const GltfAccessors& accessors, const tinygltf::Animation& from,
                         const tinygltf::AnimationChannel& channel, MeshChannel::Target target) {
  const std::string& name = accessors.name();
  if (checked(channel.sampler, from.samplers.size(), "sampler", name) < 0)
    fail(ErrorCode::file_damaged, "{}: an animation's channel has no sampler", name);
  const tinygltf::AnimationSampler& sampler = from.samplers[static_cast<std::size_t>(channel.sampler)];
  if (sampler.interpolation != "LINEAR" && sampler.interpolation != "STEP" && !sampler.interpolation.empty())
    fail(ErrorCode::value_invalid, "{}: animation '{}' is interpolated by {}, which is not supported", name,
         one_line(from.name), one_line(sampler.interpolation));
  MeshChannel out;
  out.node = channel.target_node;
  out.target = target;
  out.steps = sampler.interpolation == "STEP";
  out.times = accessors.read(sampler.input, 1);
  if (out.times.empty() || !std::is_sorted(out.times.begin(), out.times.end()))
    fail(ErrorCode::file_damaged, "{}: the times of animation '{}' are none or out of order", name,
         one_line(from.name));
  if (target == MeshChannel::Target::rotation)
    out.values = vectors<4>(accessors, sampler.output);
  else
    for (const Eigen::Vector3d& value : vectors<3>(accessors, sampler.output))
      out.values.emplace_back(value.x(), value.y(), value.z(), 0);
  require_one_each(out.values, out.times.size(), "animated values", name);
  return out;
}

MeshAnimation read_animation(const GltfAccessors& accessors, const tinygltf::Animation& from, std::size_t nodes) {
  MeshAnimation animation;
  animation.name = from.name;
  for (const tinygltf::AnimationChannel& channel : from.channels) {
    if (checked(channel.target_node, nodes, "node", accessors.name()) < 0) continue;  // glTF: to be ignored
    MeshChannel::Target target{};
    if (channel.target_path == "translation")
      target = MeshChannel::Target::translation;
    else if (channel.target_path == "rotation")
      target = MeshChannel::Target::rotation;
    else if (channel.target_path == "scale")
      target = MeshChannel::Target::scale;
    else
      continue;  // morph targets, which are not drawn either
    animation.channels.push_back(read_channel(accessors, from, channel, target));
    animation.duration = std::max(animation.duration, animation.channels.back().times.back());
  }
  return animation;
}

ImageRgb read_texture(const GltfAccessors& accessors, const tinygltf::Image& from) {
  const std::string& name = accessors.name();
  std::span<const unsigned char> encoded(from.image);
  if (from.bufferView >= 0) encoded = accessors.bytes(from.bufferView);
  if (encoded.empty()) fail(ErrorCode::value_invalid, "{}: its texture '{}' is in another file", name, from.uri);
  cv::Mat decoded;
  try {
    // OpenCV only reads through the pointer it cannot take as const.
    const cv::Mat bytes(1, static_cast<int>(std::min<std::size_t>(encoded.size(), std::numeric_limits<int>::max())),
                        CV_8U, const_cast<unsigned char*>(encoded.data()));
    decoded = cv::imdecode(bytes, cv::IMREAD_COLOR);
  } catch (const cv::Exception&) {
    decoded.release();
  }
  if (decoded.empty()) fail(ErrorCode::file_damaged, "{}: a texture cannot be decoded", name);
  ImageRgb texture(decoded.cols, decoded.rows);
  cv::Mat rgb(decoded.rows, decoded.cols, CV_8UC3, texture.data());
  cv::cvtColor(decoded, rgb, cv::COLOR_BGR2RGB);
  return texture;
}

MeshMaterial read_material(const tinygltf::Model& model, const tinygltf::Material& from, const std::string& name) {
  MeshMaterial material;
  const auto& look = from.pbrMetallicRoughness;
  for (std::size_t c = 0; c < 3 && look.baseColorFactor.size() >= 3; ++c)
    material.base[static_cast<Eigen::Index>(c)] = static_cast<float>(std::clamp(look.baseColorFactor[c], 0.0, 1.0));
  const int texture = checked(look.baseColorTexture.index, model.textures.size(), "texture", name);
  if (texture >= 0)
    material.texture =
        checked(model.textures[static_cast<std::size_t>(texture)].source, model.images.size(), "image", name);
  return material;
}

void require_joints(const MeshData& data, const std::string& name) {
  for (const MeshNode& node : data.nodes) {
    if (node.mesh < 0 || node.skin < 0) continue;
    const std::size_t joints = data.skins[static_cast<std::size_t>(node.skin)].joints.size();
    for (const MeshSurface& surface : data.meshes[static_cast<std::size_t>(node.mesh)])
      if (static_cast<std::size_t>(surface.joints_used) > joints)
        fail(ErrorCode::file_damaged, "{}: joint {} is wanted, its skin has {}", name, surface.joints_used - 1, joints);
  }
}

}  // namespace

MeshData read_glb(std::span<const std::byte> glb, const std::string& name) {
  const tinygltf::Model model = parse(glb, name);
  const GltfAccessors accessors(model, name);
  MeshData data;
  for (const tinygltf::Mesh& mesh : model.meshes) {
    data.meshes.emplace_back();
    for (const tinygltf::Primitive& primitive : mesh.primitives)
      data.meshes.back().push_back(read_surface(accessors, model, primitive));
  }
  for (const tinygltf::Node& node : model.nodes) data.nodes.push_back(read_node(model, node, name));
  link_nodes(model, data, name);
  for (const tinygltf::Skin& skin : model.skins) data.skins.push_back(read_skin(accessors, skin, data.nodes.size()));
  require_joints(data, name);
  for (const tinygltf::Animation& animation : model.animations)
    data.animations.push_back(read_animation(accessors, animation, data.nodes.size()));
  for (const tinygltf::Image& image : model.images) data.textures.push_back(read_texture(accessors, image));
  for (const tinygltf::Material& material : model.materials)
    data.materials.push_back(read_material(model, material, name));
  return data;
}

}  // namespace uwv
