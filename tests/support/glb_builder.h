// SPDX-License-Identifier: Apache-2.0
// Builds small binary glTF files in memory, honest ones and ones that lie.
#pragma once

#include <nlohmann/json.hpp>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

namespace uwv::test {

class GlbBuilder {
 public:
  nlohmann::json json = {{"asset", {{"version", "2.0"}}}};

  /// Appends bytes as a buffer view of their own and returns its index.
  template <class T>
  int view(const std::vector<T>& values) {
    const std::size_t offset = data_.size(), size = values.size() * sizeof(T);
    data_.resize(offset + (size + 3) / 4 * 4);
    std::memcpy(data_.data() + offset, values.data(), size);
    return append("bufferViews", {{"buffer", 0}, {"byteOffset", offset}, {"byteLength", size}});
  }

  /// Appends an accessor over values of its own, e.g. floats(.., "VEC3").
  int floats(const std::vector<float>& values, const std::string& type, std::size_t components) {
    return append(
        "accessors",
        {{"bufferView", view(values)}, {"componentType", 5126}, {"type", type}, {"count", values.size() / components}});
  }
  int shorts(const std::vector<std::uint16_t>& values, const std::string& type, std::size_t components) {
    return append(
        "accessors",
        {{"bufferView", view(values)}, {"componentType", 5123}, {"type", type}, {"count", values.size() / components}});
  }

  /// Appends an object to one of the file's lists and returns its index.
  int append(const char* list, nlohmann::json object) {
    json[list].push_back(std::move(object));
    return static_cast<int>(json[list].size()) - 1;
  }

  std::vector<std::byte> bytes() const {
    nlohmann::json whole = json;
    if (!data_.empty()) whole["buffers"] = {{{"byteLength", data_.size()}}};
    std::string text = whole.dump();
    text.resize((text.size() + 3) / 4 * 4, ' ');
    std::vector<std::byte> out;
    const auto word = [&](std::uint32_t v) {
      const auto* raw = reinterpret_cast<const std::byte*>(&v);
      out.insert(out.end(), raw, raw + sizeof v);
    };
    const auto chunk = [&](std::uint32_t kind, const void* from, std::size_t size) {
      word(static_cast<std::uint32_t>(size));
      word(kind);
      const auto* raw = static_cast<const std::byte*>(from);
      out.insert(out.end(), raw, raw + size);
    };
    word(0x46546C67);
    word(2);
    word(static_cast<std::uint32_t>(12 + 8 + text.size() + (data_.empty() ? 0 : 8 + data_.size())));
    chunk(0x4E4F534A, text.data(), text.size());
    if (!data_.empty()) chunk(0x004E4942, data_.data(), data_.size());
    return out;
  }

 private:
  std::vector<std::byte> data_;
};

/// A cube |x|, |y|, |z| <= 1 of four vertices a face, each face showing the whole texture, in a scene of one node.
inline GlbBuilder cube() {
  GlbBuilder file;
  std::vector<float> positions, uv;
  std::vector<std::uint16_t> corners;
  for (int axis = 0; axis < 3; ++axis)
    for (const float side : {-1.0F, 1.0F}) {
      const auto first = static_cast<std::uint16_t>(positions.size() / 3);
      for (int k = 0; k < 4; ++k) {
        float x[3];
        x[axis] = side;
        x[(axis + 1) % 3] = k % 2 == 0 ? -1.0F : 1.0F;
        x[(axis + 2) % 3] = k / 2 == 0 ? -1.0F : 1.0F;
        positions.insert(positions.end(), x, x + 3);
        uv.insert(uv.end(), {static_cast<float>(k % 2), static_cast<float>(k / 2)});
      }
      for (const int k : {0, 1, 2, 2, 1, 3}) corners.push_back(static_cast<std::uint16_t>(first + k));
    }
  const int where = file.floats(positions, "VEC3", 3), look = file.floats(uv, "VEC2", 2);
  const int triangles = file.shorts(corners, "SCALAR", 1);
  file.append("meshes", {{"primitives",
                          {{{"attributes", {{"POSITION", where}, {"TEXCOORD_0", look}}}, {"indices", triangles}}}}});
  file.append("nodes", {{"name", "cube"}, {"mesh", 0}});
  return file;
}

/// A strip from y = 0 to y = 2 in the plane z = 0. The lower vertices hang on the joint `lower` at the origin, those at
/// y = 1 on both alike, the upper ones on `upper` at y = 1, which the animation "bend" turns by a right angle about z
/// within a second.
inline GlbBuilder bending_strip() {
  GlbBuilder file;
  const int where = file.floats({0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 2, 0, 1, 2, 0}, "VEC3", 3);
  const int joints = file.shorts({0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, "VEC4", 4);
  const int weights =
      file.floats({1, 0, 0, 0, 1, 0, 0, 0, 0.5F, 0.5F, 0, 0, 0.5F, 0.5F, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, "VEC4", 4);
  const int triangles = file.shorts({0, 1, 2, 2, 1, 3, 2, 3, 4, 4, 3, 5}, "SCALAR", 1);
  // Column-major; the second moves the joint at y = 1 to the origin.
  const int bind = file.floats({1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0,  0, 1,  //
                                1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, -1, 0, 1},
                               "MAT4", 16);
  const int times = file.floats({0, 1}, "SCALAR", 1);
  const float half = 0.70710678F;  // of a right angle, as a quaternion
  const int turns = file.floats({0, 0, 0, 1, 0, 0, half, half}, "VEC4", 4);
  file.append("meshes", {{"primitives",
                          {{{"attributes", {{"POSITION", where}, {"JOINTS_0", joints}, {"WEIGHTS_0", weights}}},
                            {"indices", triangles}}}}});
  // The node of the mesh is moved far away, which a skinned mesh must not follow.
  file.append("nodes", {{"name", "strip"}, {"mesh", 0}, {"skin", 0}, {"translation", {100, 0, 0}}});
  file.append("nodes", {{"name", "lower"}, {"children", {2}}});
  file.append("nodes", {{"name", "upper"}, {"translation", {0, 1, 0}}});
  file.append("skins", {{"joints", {1, 2}}, {"inverseBindMatrices", bind}});
  file.append("animations", {{"name", "bend"},
                             {"samplers", {{{"input", times}, {"output", turns}}}},
                             {"channels", {{{"sampler", 0}, {"target", {{"node", 2}, {"path", "rotation"}}}}}}});
  return file;
}

}  // namespace uwv::test
