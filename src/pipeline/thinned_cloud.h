// SPDX-License-Identifier: Apache-2.0
// A frame's cloud with fewer points where its surfaces are flat (decimation.h), bounded in the pictures of a path.
#pragma once

#include <optional>

#include "pipeline/plan.h"
#include "uwv/geometry/decimation.h"

namespace uwv::pipeline {

/// `depth` and `slopes` are the frame's own but for the points that stand for cells.
struct ThinnedCloud {
  DepthMap depth;
  SlopeMap slopes;
  ValidityMask kept;
  Image<std::uint8_t> cells;

  /// As the renderer takes it; colours come from `data`.
  SourceFrame seen_by(const Camera& camera, const SourceData& data) const;
};

/// The bound in pixels: the option's, or what is used where thinning was chosen without one.
double max_error_of(const RunOptions& options);

/// What of a frame has to be kept for the target cameras that show its moment (all of the path where none does).
/// With `one_colour`, cells of several colours are divided.
ThinnedCloud thin_out(const Plan& plan, const SourceData& data, bool one_colour, ThreadPool& pool);

/// Thins out the frames of a path one after another; a frame that comes again is not done again.
class Thinning {
 public:
  Thinning(const Plan& plan, ThreadPool& pool) : plan_(plan), pool_(pool) {}
  const ThinnedCloud& of(const SourceData& data);
  /// For run.json.
  nlohmann::ordered_json to_json() const;

 private:
  const Plan& plan_;
  ThreadPool& pool_;
  std::optional<long> index_;
  ThinnedCloud cloud_;
  std::size_t points_before_ = 0, points_after_ = 0;
  double seconds_ = 0;
};

}  // namespace uwv::pipeline
