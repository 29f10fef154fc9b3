// SPDX-License-Identifier: Apache-2.0
// Small clips with depth for tests of the programs: a near square slides in front of a wall.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "support/temp_folder.h"
#include "uwv/core/image.h"

namespace uwv::test {

struct ClipSpec {
  Size size = {64, 48};
  long frames = 5;
};

/// Colour of frame `index`.
ImageRgb clip_picture(const ClipSpec& spec, long index);
/// Depth of frame `index`: the wall at 4, the square at 2.
DepthMap clip_depth(const ClipSpec& spec, long index);

/// Writes clip.mp4 and depth.npz into the folder.
void make_clip(const TempFolder& folder, const ClipSpec& spec);

/// The command line of a run over that clip into `out`, with `more` behind it.
std::vector<std::string> run_arguments(const std::string& out, const std::vector<std::string>& more = {});

/// Every file below `folder` with its bytes, but those that hold times: run.json and the stage markers.
std::map<std::string, std::string> results(const std::string& folder);

/// What is in a folder, with sizes and modification times.
std::vector<std::string> listing(const std::string& folder);

}  // namespace uwv::test
