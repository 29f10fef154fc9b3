// SPDX-License-Identifier: Apache-2.0
// Keyframes turned into one pose and zoom per frame.
#pragma once

#include "uwv/trajectory/target_path.h"

namespace uwv::detail {

/// The zoom that gives a horizontal field of view, relative to the context's intrinsics.
double zoom_for_fov(double fov_deg, const PathContext& context);

/// The keyframes' path. `motion` is spec.motion. Errors as build_path().
CameraPath keyframe_path(const KeyframeMotion& motion, const TrajectorySpec& spec, const PathContext& context,
                         long frames);

}  // namespace uwv::detail
