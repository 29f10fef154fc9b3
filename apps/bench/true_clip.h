// SPDX-License-Identifier: Apache-2.0
// Clips of which cameras and depth are known: what geometry found from the pictures alone is judged against.
#pragma once

#include <string>
#include <vector>

#include "uwv/core/camera.h"
#include "uwv/core/mask.h"
#include "uwv/io/resize_policy.h"

namespace uwv::bench {

/// All of one size, one entry a frame.
struct TrueClip {
  std::string name;
  std::vector<ImageRgb> frames;
  std::vector<Camera> cameras;
  std::vector<DepthMap> depths;             ///< 0 = not known.
  std::vector<ValidityMask> static_pixels;  ///< 1 = belongs to the scene at rest; empty = all do.
};

/// Which frames of a recording: `start`, `start + stride`, ...; at most `max_frames`, 0 = all.
struct FrameRange {
  long start = 0, stride = 1, max_frames = 0;
};

/// Reads frames of a folder, which holds one of
/// - image/, depth.npz and cameras.json, perhaps foreground/: what save_clip() writes;
/// - image/, depth/ (16-bit PNG, millimetres) and test_scene/trajectory.log: a depth camera's recording, as in
///   real_pairs.h;
/// - color/, depth/ (16-bit PNG, 5000 a metre) and pose.txt (x y z qx qy qz qw a line, world_from_cam) with the lens of
///   the ICL-NUIM recordings, whose y points up;
/// - a stereo pair, see stereo_pairs.h, which is read whole.
/// Throws Error for other folders, for fewer depths or poses than pictures and for a range without a frame.
TrueClip read_true_clip(const std::string& folder, const FrameRange& range, const ResizePolicy& resize);

}  // namespace uwv::bench
