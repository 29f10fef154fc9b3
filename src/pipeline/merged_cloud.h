// SPDX-License-Identifier: Apache-2.0
// The other frames of a clip that help to draw each frame where the cloud is merged.
#pragma once

#include <memory>

#include "pipeline/stage.h"
#include "uwv/render/other_views.h"

namespace uwv::pipeline {

/// What other frames did along the path.
struct MergeTally {
  std::size_t kept = 0;       ///< Views held in memory.
  double gather_seconds = 0;  ///< Reading them.
  double fill_seconds = 0;
  std::size_t filled = 0, hidden = 0;  ///< Pixels.
  long drawn = 0, refused = 0;         ///< Views, summed over frames.

  void add(const FillReport& report);
  /// For run.json; `pixels` are those of all frames.
  nlohmann::ordered_json to_json(double pixels, long frames) const;
};

/// Frames spread evenly over the clip, as many as fit into a fixed share of memory, with their static, measured points.
/// Null when the choice is to draw each frame from its own points only.
std::unique_ptr<OtherViews> gather_views(const Workshop& shop, MergeTally& tally);

}  // namespace uwv::pipeline
