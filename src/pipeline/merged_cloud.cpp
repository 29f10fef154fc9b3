// SPDX-License-Identifier: Apache-2.0
#include "pipeline/merged_cloud.h"

#include <algorithm>

#include "pipeline/resources.h"

namespace uwv::pipeline {
namespace {

// Neighbouring frames see nearly the same: a view every few frames of a short clip shows what there is to be seen. More
// memory would not change that, and none of it may depend on the clip's length.
constexpr long most_views = 24;
constexpr std::size_t budget = 256U << 20U;
constexpr std::size_t bytes_per_pixel = sizeof(Rgb8) + sizeof(float) + sizeof(Slope) + 1;

long views_to_keep(const Plan& plan) {
  const std::size_t affordable = budget / (plan.size().pixels() * bytes_per_pixel);
  return std::clamp(static_cast<long>(affordable), 1L, std::min(most_views, plan.source->frames()));
}

}  // namespace

void MergeTally::add(const FillReport& report) {
  fill_seconds += report.seconds;
  filled += report.filled;
  hidden += report.hidden;
  drawn += report.views;
  refused += report.refused;
}

nlohmann::ordered_json MergeTally::to_json(double pixels, long frames) const {
  const auto per_frame = [&](long count) { return static_cast<double>(count) / static_cast<double>(frames); };
  return {{"filled_share", static_cast<double>(filled) / pixels},
          {"hidden_share", static_cast<double>(hidden) / pixels},
          {"views_kept", kept},
          {"views_drawn_per_frame", per_frame(drawn)},
          {"views_refused_per_frame", per_frame(refused)},
          {"gather_seconds", gather_seconds},
          {"fill_seconds", fill_seconds}};
}

std::unique_ptr<OtherViews> gather_views(const Workshop& shop, MergeTally& tally) {
  const Plan& plan = shop.plan;
  if (plan.choices.plan.cloud.choice != CloudKind::merged) return nullptr;
  const StageClock clock;
  const OcclusionOptions occlusion = plan.occlusion();
  auto views = std::make_unique<OtherViews>(shop.rasterizer, shop.pool, occlusion, OtherViewsOptions{});
  const long frames = plan.source->frames(), keep = views_to_keep(plan);
  for (long k = 0; k < keep; ++k) {
    shop.monitor.step("gathering", k, keep);
    const auto data = plan.source->read(keep > 1 ? k * (frames - 1) / (keep - 1) : 0);
    if (!data) break;
    OtherView view{data->index, plan.source_camera(data->index), data->colour, data->depth,
                   plan.source->lasting_points(*data)};
    if (occlusion.reliability.enabled)
      intersect(view.usable, reliable_depth(view.depth, occlusion.reliability, shop.pool));
    views->add(std::move(view));
  }
  shop.monitor.step("gathering", keep, keep);
  tally.kept = views->size();
  tally.gather_seconds = clock.seconds();
  return views;
}

}  // namespace uwv::pipeline
