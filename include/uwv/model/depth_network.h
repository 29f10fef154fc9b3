// SPDX-License-Identifier: Apache-2.0
// Depth, and what else a network says of a clip's geometry, from a network the user exported to TorchScript.
//
// A network comes as a folder: a TorchScript file and `manifest.json`, which says how pictures go in and what comes
// out. Nothing is guessed from the file. docs/depth-models.md is the manifest's reference and has one for each of the
// published networks. Design: paper, Sec. "Geometry"; MoGe-2, STream3R and Video Depth Anything are what it uses.
//
// This header needs no libtorch; open_depth_network is in the component uwv::model.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "uwv/core/camera.h"
#include "uwv/core/image.h"
#include "uwv/core/monitor.h"
#include "uwv/core/thread_pool.h"
#include "uwv/geometry/scene_geometry.h"

namespace uwv {

/// What the numbers in DepthNetworkResult's depth maps are.
enum class NetworkDepth {
  metric,         ///< Metres along the optical axis.
  up_to_scale,    ///< Distance along the optical axis in a unit of the network's own, one for the whole clip.
  inverse_affine  ///< a / depth + b with a > 0 and b unknown, one pair for the clip (or for each frame): align it
                  ///< first.
};
std::string_view to_string(NetworkDepth meaning);

struct DepthNetworkOptions {
  /// Threads of the network; 0 = as many as the pool has. More helps until they share a core.
  int threads = 0;
  /// The confidence of a valid pixel where the network gives none: a learned depth counts as measured, barely.
  float plain_confidence = 0.5F;
  /// Throws std::invalid_argument.
  void check() const;
};

/// A clip as the network sees it. Everything has the size of the frames given.
struct DepthNetworkResult {
  NetworkDepth meaning = NetworkDepth::metric;
  /// True when all frames share their scale (and shift); false when each frame was seen alone by an affine network.
  bool consistent = true;
  /// One per frame. Where `meaning` is inverse_affine, `depth` holds the inverse depth as the network gave it: larger
  /// is nearer, 0 and negative values are possible, and confidence 0 alone marks the unknown. Otherwise as
  /// SceneGeometry.
  std::vector<FrameGeometry> frames;
  /// Unit normals in the camera's frame, facing the camera (z <= 0); zero where unknown. Empty when the network has
  /// none.
  std::vector<Image<Eigen::Vector3f>> normals;
  /// One per frame, in pixels of the frame. Empty when the network has none.
  std::vector<Intrinsics> intrinsics;
  /// One per frame, in the unit of the depth; the first is the identity. Empty when the network has none.
  std::vector<Rigid3> world_from_cam;
  double seconds = 0;              ///< Wall clock of run().
  std::uint64_t peak_bytes = 0;    ///< The most memory the process had taken by its end.
  std::vector<std::string> notes;  ///< One sentence each: what was decided and why, what is uncertain.
};

/// An opened network. Not for use by two threads at once.
class DepthNetwork {
 public:
  virtual ~DepthNetwork() = default;
  /// The manifest's name, else the folder's.
  virtual const std::string& name() const = 0;
  virtual NetworkDepth meaning() const = 0;
  /// The size at which a frame of this size enters the network.
  virtual Size input_size(Size frame) const = 0;
  /// All frames have one size. Throws std::invalid_argument (no frames, differing sizes), Error(value_invalid) when the
  /// network's outputs are not those the manifest promises, Error(out_of_memory), Error(cancelled).
  virtual DepthNetworkResult run(std::span<const ImageRgb> frames, const DepthNetworkOptions& options, ThreadPool& pool,
                                 Monitor& monitor) = 0;
};

/// Opens the folder. Throws Error naming the file, what was found and what was wanted: file_not_found, file_damaged,
/// format_unknown (weights without a network), value_invalid (the manifest).
std::unique_ptr<DepthNetwork> open_depth_network(const std::string& folder);

}  // namespace uwv
