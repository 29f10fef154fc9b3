// SPDX-License-Identifier: Apache-2.0
#include "pipeline/moving_layer.h"

#include <algorithm>

#include "pipeline/given_pictures.h"
#include "uwv/geometry/background_from_views.h"
#include "uwv/geometry/scene_profile.h"

namespace uwv::pipeline {
namespace {

std::vector<ForegroundMask> foreground_of(const MovingPixels& moving) {
  std::vector<ForegroundMask> masks;
  for (const ValidityMask& fixed : moving.static_pixels) {
    ForegroundMask& mask = masks.emplace_back(fixed.size());
    std::transform(fixed.pixels().begin(), fixed.pixels().end(), mask.pixels().begin(),
                   [](std::uint8_t still) { return static_cast<std::uint8_t>(still == 0); });
  }
  return masks;
}

void complete_behind(const RunOptions& options, std::span<const ImageRgb> frames, ThreadPool& pool, Monitor& monitor,
                     EstimatedGeometry& result) {
  if (options.layers == LayerChoice::off) {
    result.facts["background"] = "skipped: --layers off";
    return;
  }
  ViewsBackground behind =
      background_from_views(frames, result.scene.cameras, result.scene.frames, result.foreground, {}, pool, monitor);
  result.facts["background"] = {{"seen_in_other_frames_share", behind.share_seen},
                                {"invented_share", behind.share_invented},
                                {"notes", behind.notes},
                                {"seconds", behind.seconds}};
  result.background.colour = std::move(behind.frames);
  if (!options.background.empty()) {
    result.background.colour = read_given_pictures(options.background, "background picture", options, frames.size(),
                                                   frames.front().size(), monitor);
    result.facts["background"]["given"] = options.background;
  }
  result.background.depth = std::move(behind.depth);
}

}  // namespace

bool matters(const MovingPixels& moving) { return moving.moving_share > GeometryPlanOptions{}.min_layer_motion; }

MovingPixels find_moving_layer(const RunOptions& options, const ForegroundNetworks& networks,
                               std::span<const ImageRgb> frames, std::span<const Camera> cameras,
                               std::span<const FrameGeometry> coarse, ThreadPool& pool, Monitor& monitor,
                               nlohmann::ordered_json& facts) {
  MovingPixels moving = find_moving_pixels(frames, cameras, coarse, {}, pool, monitor);
  nlohmann::ordered_json about = {{"seconds", moving.seconds}};
  if (matters(moving)) {
    const ClipForeground foreground = find_clip_foreground(options, networks, frames, pool, monitor);
    about["foreground"] = foreground.note + "; motion decides what of it moves";
    about["share_by_motion_alone"] = moving.moving_share;
    if (!foreground.masks.empty()) take_foreground_whole(frames, foreground.masks, {}, pool, moving);
  }
  about["share"] = moving.moving_share;
  about["notes"] = moving.notes;
  facts["moving_pixels"] = std::move(about);
  return moving;
}

void lay_behind_moving(const RunOptions& options, std::span<const ImageRgb> frames, const MovingPixels& moving,
                       ThreadPool& pool, Monitor& monitor, EstimatedGeometry& result) {
  result.foreground = foreground_of(moving);
  complete_behind(options, frames, pool, monitor, result);
}

std::string place_moving_layer(const RunOptions& options, std::span<const ImageRgb> frames, const MovingPixels& moving,
                               ThreadPool& pool, Monitor& monitor, EstimatedGeometry& result) {
  const MovingDepthSummary placed =
      fill_moving_depth(frames, result.scene.cameras, moving.static_pixels, {}, pool, monitor, result.scene.frames);
  result.facts["moving_depth"] = {{"objects", placed.objects.size()},
                                  {"contact_share", placed.contact_share},
                                  {"unknown_share", placed.unknown_share},
                                  {"notes", placed.notes},
                                  {"seconds", placed.seconds}};
  lay_behind_moving(options, frames, moving, pool, monitor, result);
  return placed.brief();
}

}  // namespace uwv::pipeline
