// SPDX-License-Identifier: Apache-2.0
// What a run knows about its clip, and what it therefore leaves out: plan_geometry() applied to real numbers, and both
// as run.json and geometry.json tell them.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <type_traits>

#include "pipeline/source_clip.h"
#include "uwv/geometry/scene_profile.h"
#include "uwv/geometry/structure_from_motion.h"
#include "uwv/pipeline/scene_look.h"

namespace uwv::pipeline {

/// Median over neighbouring frames of the median shift of the points both see that turning cannot explain, pixels; 0
/// where nothing was reconstructed.
double parallax_per_frame(const SfmResult& sfm);

/// Share of the pixels that are 1, mean over the masks; 0 for no masks.
double mean_share(std::span<const ForegroundMask> masks);
double share_of(std::span<const std::uint8_t> mask);

nlohmann::ordered_json to_json(const SceneProfile& profile);

template <class T>
nlohmann::ordered_json to_json(const PlanDecision<T>& decision) {
  nlohmann::ordered_json choice;
  if constexpr (std::is_enum_v<T>)
    choice = to_string(decision.choice);
  else if constexpr (std::is_same_v<T, bool>)
    choice = decision.choice ? "on" : "off";
  else
    choice = decision.choice;
  return {{"choice", choice}, {"reason", decision.reason}, {"saves", decision.saves}, {"forced", decision.forced}};
}

/// The profile at rendering time: what the geometry stage left in `geometry`, or what cameras and depth of the first
/// frame say where they were given; and what `look` says of the path.
SceneProfile profile_of(SourceClip& source, const SceneLook& look, const std::optional<GeometryFolder>& geometry);

struct SceneChoices {
  SceneProfile profile;
  GeometryPlan plan;

  /// cloud, layers, key_stride and decimate, each with choice, reason, saves, forced.
  nlohmann::ordered_json to_json() const;
  std::string brief() const;  ///< One line.
};

SceneChoices choose(SourceClip& source, const SceneLook& look, const std::optional<GeometryFolder>& geometry,
                    const RunOptions& options);

}  // namespace uwv::pipeline
