// SPDX-License-Identifier: Apache-2.0
// Numbers out of a glTF file's buffers, with every offset and count checked against the bytes that are there.
#pragma once

#include <tiny_gltf.h>

#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace uwv {

/// Reads the accessors of one file. The model outlives it.
class GltfAccessors {
 public:
  GltfAccessors(const tinygltf::Model& model, std::string name) : model_(&model), name_(std::move(name)) {}

  /// All values of an accessor with `components` numbers each, one after the other. Normalised integers become
  /// fractions. Throws Error: file_damaged (an index, offset or count that leads outside, another number of
  /// components, numbers that are not finite), value_invalid (sparse accessors).
  std::vector<double> read(int accessor, std::size_t components) const;
  /// The bytes of a buffer view.
  std::span<const unsigned char> bytes(int view) const;
  const std::string& name() const { return name_; }

 private:
  const tinygltf::Model* model_;
  std::string name_;
};

}  // namespace uwv
