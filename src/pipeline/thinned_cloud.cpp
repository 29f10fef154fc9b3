// SPDX-License-Identifier: Apache-2.0
#include "pipeline/thinned_cloud.h"

#include <algorithm>

#include "pipeline/resources.h"

namespace uwv::pipeline {
namespace {

constexpr std::size_t bounding_targets = 3;  // the shift grows with distance: those between are bound by the farthest

/// The cameras farthest from the source among those that show its frame.
std::vector<Camera> farthest_targets(const Plan& plan, long index) {
  const Camera source = plan.source_camera(index);
  const auto distance = [&](const Camera& target) { return target_from_source(target, source).translation.norm(); };
  std::vector<Camera> targets;
  for (const TargetFrame& frame : plan.path.frames)
    if (frame.source_frame == index) targets.push_back(frame.camera);
  if (targets.empty())
    for (const TargetFrame& frame : plan.path.frames) targets.push_back(frame.camera);
  const auto count = std::min(targets.size(), bounding_targets);
  std::partial_sort(targets.begin(), targets.begin() + static_cast<std::ptrdiff_t>(count), targets.end(),
                    [&](const Camera& a, const Camera& b) { return distance(a) > distance(b); });
  targets.resize(count);
  return targets;
}

}  // namespace

double max_error_of(const RunOptions& options) {
  const double otherwise = 0.5;  // what rounding to pixels moves a point by at most
  const double asked = options.max_error.value_or(0);
  return asked > 0 ? asked : otherwise;
}

SourceFrame ThinnedCloud::seen_by(const Camera& camera, const SourceData& data) const {
  SourceFrame frame = data.seen_by(camera);
  frame.depth = &depth;
  frame.slopes = &slopes;
  frame.valid = &kept;
  frame.cells = &cells;
  return frame;
}

ThinnedCloud thin_out(const Plan& plan, const SourceData& data, bool one_colour, ThreadPool& pool) {
  DecimationOptions options;
  options.max_error = max_error_of(plan.options);
  const Camera source = plan.source_camera(data.index);
  DecimatedDepth thinned = decimate_depth(data.depth, source, farthest_targets(plan, data.index), options, pool,
                                          one_colour ? &data.colour : nullptr);
  ThinnedCloud cloud{data.depth, {}, std::move(thinned.kept), std::move(thinned.cell)};
  const OcclusionOptions occlusion = plan.occlusion();
  if (data.slopes)
    cloud.slopes = *data.slopes;
  else
    limited_slopes_from_depth(data.depth, source.intrinsics, occlusion.slopes, pool, cloud.slopes);
  for (std::size_t i = 0; i < cloud.kept.pixels().size(); ++i)
    if (cloud.cells.pixels()[i] > 1) {
      cloud.depth.pixels()[i] = thinned.depth.pixels()[i];
      cloud.slopes.pixels()[i] = thinned.slopes.pixels()[i];
    }
  if (occlusion.reliability.enabled) intersect(cloud.kept, reliable_depth(data.depth, occlusion.reliability, pool));
  return cloud;
}

const ThinnedCloud& Thinning::of(const SourceData& data) {
  if (index_ == data.index) return cloud_;
  const StageClock clock;
  cloud_ = thin_out(plan_, data, plan_.options.kernel == Kernel::nearest, pool_);
  index_ = data.index;
  points_before_ +=
      static_cast<std::size_t>(std::count_if(data.depth.pixels().begin(), data.depth.pixels().end(), is_valid_depth));
  points_after_ += cloud_.kept.count();
  seconds_ += clock.seconds();
  return cloud_;
}

nlohmann::ordered_json Thinning::to_json() const {
  return {{"max_error", max_error_of(plan_.options)},
          {"points_before", points_before_},
          {"points_after", points_after_},
          {"seconds", seconds_}};
}

}  // namespace uwv::pipeline
