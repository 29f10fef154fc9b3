// SPDX-License-Identifier: Apache-2.0
#include "pipeline/other_shots.h"

#include <algorithm>

#include "uwv/core/depth.h"
#include "uwv/geometry/planar_prior.h"

namespace uwv::pipeline {
namespace {

/// The values of a clip's frames from those of the shot's; `other(i)` makes those of the frames outside it.
template <class T, class Other>
void spread(const Shot& shot, std::size_t frames, std::vector<T>& values, const Other& other) {
  if (values.empty()) return;
  std::vector<T> all;
  all.reserve(frames);
  for (std::size_t i = 0; i < frames; ++i)
    all.push_back(i >= shot.first && i < shot.first + shot.count ? std::move(values[i - shot.first]) : other(i));
  values = std::move(all);
}

}  // namespace

std::optional<Shot> reconstructed_shot(const SfmResult& sfm) {
  const auto begin = std::find(sfm.in_shot.begin(), sfm.in_shot.end(), std::uint8_t{1});
  const auto end = std::find(begin, sfm.in_shot.end(), std::uint8_t{0});
  const Shot shot{static_cast<std::size_t>(begin - sfm.in_shot.begin()), static_cast<std::size_t>(end - begin)};
  if (shot.count == 0 || shot.count == sfm.in_shot.size()) return std::nullopt;
  return shot;
}

SfmResult of_shot(SfmResult sfm, const Shot& shot) {
  const auto cut = [&](auto& values) {
    if (values.empty()) return;
    const auto first = values.begin() + static_cast<std::ptrdiff_t>(shot.first);
    values = {first, first + static_cast<std::ptrdiff_t>(shot.count)};
  };
  cut(sfm.cameras);
  cut(sfm.registered);
  cut(sfm.in_shot);
  for (ScenePoint& point : sfm.points)
    for (PointObservation& seen : point.observations) seen.frame -= static_cast<int>(shot.first);
  sfm.cuts.clear();
  return sfm;
}

void spread_over_clip(const Shot& shot, std::span<const ImageRgb> frames, ThreadPool& pool, Monitor& monitor,
                      EstimatedGeometry& geometry) {
  SceneGeometry& scene = geometry.scene;
  const Size size = frames.front().size();
  PlanarPriorOptions prior_options;
  prior_options.locked_off = false;  // each shot has a backdrop of its own
  prior_options.median_depth = median_depth(scene.frames.front().depth);
  const auto prior_of = [&](std::size_t i) {
    return std::move(
        planar_prior(frames.subspan(i, 1), {}, scene.cameras.front().intrinsics, prior_options, pool, monitor)
            .geometry.frames.front());
  };
  spread(shot, frames.size(), scene.frames, prior_of);
  const Camera first = scene.cameras.front(), last = scene.cameras.back();
  spread(shot, frames.size(), scene.cameras, [&](std::size_t i) { return i < shot.first ? first : last; });
  spread(shot, frames.size(), scene.normals, [&](std::size_t) { return NormalMap(size, Eigen::Vector3f::Zero()); });
  spread(shot, frames.size(), geometry.foreground, [&](std::size_t) { return ForegroundMask(size); });
  spread(shot, frames.size(), geometry.background.colour, [&](std::size_t i) { return frames[i]; });
  spread(shot, frames.size(), geometry.background.depth, [&](std::size_t i) { return scene.frames[i].depth; });
  geometry.facts["other_shots"] = {{"first_frame_of_the_shot", shot.first},
                                   {"frames_of_the_shot", shot.count},
                                   {"frames_of_others", frames.size() - shot.count},
                                   {"their_depth", "assumed (layered prior)"}};
}

}  // namespace uwv::pipeline
