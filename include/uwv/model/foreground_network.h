// SPDX-License-Identifier: Apache-2.0
// Foreground by networks the user exported to TorchScript: matting or saliency for the first frame, a promptable
// segmenter (SAM 2 and its like) for the others. Paper, "Layer-wise Point Cloud Construction"; geometry sheet 4.4.
//
// Each comes as a folder with a TorchScript file and a manifest; docs/depth-models.md is the manifest's reference. This
// header needs no libtorch; the functions are in the component uwv::model.
#pragma once

#include <memory>
#include <string>

#include "uwv/geometry/layers.h"

namespace uwv {

/// Opens a network that finds the foreground of one picture. `threads` are the network's own; 0 = as many as there are
/// processors. Throws Error naming the file, what was found and what was wanted: file_not_found, file_damaged,
/// format_unknown (weights without a network), value_invalid (the manifest). find() throws Error(value_invalid) when
/// the network's answer is not what the manifest promises; values that are no number count as background.
std::unique_ptr<ForegroundFinder> open_foreground_network(const std::string& folder, int threads = 0);

/// Opens a segmenter. Throws as above; so does follow().
std::unique_ptr<ForegroundTracker> open_foreground_tracker(const std::string& folder, int threads = 0);

}  // namespace uwv
