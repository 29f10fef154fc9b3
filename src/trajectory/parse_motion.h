// SPDX-License-Identifier: Apache-2.0
// The part of a trajectory file that says how the camera moves.
#pragma once

#include <filesystem>

#include "trajectory/json_node.h"
#include "uwv/trajectory/trajectory_spec.h"

namespace uwv::detail {

/// `root` is the whole file; exactly one of motion_keys must be in it. `folder` is where relative paths start.
Motion parse_motion(const JsonNode& root, const std::filesystem::path& folder);

}  // namespace uwv::detail
