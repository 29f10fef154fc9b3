// SPDX-License-Identifier: Apache-2.0
// The nine numbers in which VGGT and STream3R write a camera (geometry sheet 4.2).
#pragma once

#include <span>
#include <string_view>

#include "uwv/core/camera.h"

namespace uwv::model {

/// A camera as the encoding has it: centred principal point.
struct EncodedCamera {
  Rigid3 transform;  ///< cam_from_world or world_from_cam, as the manifest says.
  Intrinsics intrinsics;
};

/// t (3), quaternion x y z w (4, any length but zero), vertical and horizontal field of view in radians. Throws
/// Error(value_invalid) naming `what` for a zero quaternion or a field of view outside (0, pi).
EncodedCamera decode_pose(std::span<const double> encoding, Size frame, std::string_view what);

}  // namespace uwv::model
