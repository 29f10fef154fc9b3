// SPDX-License-Identifier: Apache-2.0
// From what forward returned to maps with a meaning: each shape is checked against the manifest's promise.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string_view>
#include <vector>

#include "model/network_manifest.h"

namespace uwv::model {

using FloatMap = Image<float>;
using VectorMap = Image<Eigen::Vector3f>;

/// The outputs of one call, for `frames` frames. Errors name the network's file, the output and its shape.
class NetworkOutput {
 public:
  NetworkOutput(const NetworkManifest& manifest, const std::string& model_path, ModuleOutputs outputs, int frames);

  bool has(std::string_view role) const { return manifest_.outputs.find(role) != manifest_.outputs.end(); }
  /// One map of one channel per frame: [.., H, W] or [.., H, W, 1], what stands before making up the frames.
  std::vector<FloatMap> maps(std::string_view role) const;
  /// One map of three channels per frame: [.., H, W, 3] or [.., 3, H, W].
  std::vector<VectorMap> vectors(std::string_view role) const;
  /// `count` numbers per frame, finite: [.., count].
  std::vector<std::vector<double>> numbers(std::string_view role, std::size_t count) const;

 private:
  const FloatTensor& tensor(std::string_view role) const;
  [[noreturn]] void refuse(std::string_view role, const FloatTensor& found, std::string_view wanted) const;

  const NetworkManifest& manifest_;
  const std::string& model_path_;
  ModuleOutputs outputs_;
  int frames_;
};

}  // namespace uwv::model
