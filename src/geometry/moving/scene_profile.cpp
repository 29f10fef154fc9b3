// SPDX-License-Identifier: Apache-2.0
#include "uwv/geometry/scene_profile.h"

#include <algorithm>
#include <cmath>

namespace uwv {
namespace {

std::string_view phrase(ClipMotion motion) {
  switch (motion) {
    case ClipMotion::moving: return "moves";
    case ClipMotion::turning: return "only turns";
    case ClipMotion::still: return "stands still";
    default: return "does something that could not be told";
  }
}

/// The profile with unusable numbers replaced by what is safe, each with a note.
SceneProfile usable(SceneProfile profile, std::vector<std::string>& notes) {
  const auto number = [&](double& value, const char* name, double low, double high, double otherwise) {
    if (std::isfinite(value) && value >= low && value <= high) return;
    notes.push_back(fmt::format("{} of {} is not usable and was taken for {}", name, value, otherwise));
    value = otherwise;
  };
  constexpr double huge = 1e9;
  number(profile.parallax_px, "parallax_px", 0, huge, 0);
  number(profile.parallax_per_frame_px, "parallax_per_frame_px", 0, huge, 0);
  number(profile.rms_error_px, "rms_error_px", 0, huge, huge);
  number(profile.registered_share, "registered_share", 0, 1, 0);
  number(profile.moving_share, "moving_share", 0, 1, 0);
  number(profile.measured_share, "measured_share", 0, 1, 0);
  number(profile.disocclusion_share, "disocclusion_share", 0, 1, 0);
  number(profile.depth_ratio, "depth_ratio", 1, huge, 1);
  const auto count = [&](int& value, const char* name) {
    if (value >= 0) return;
    notes.push_back(fmt::format("{} of {} was taken for 0", name, value));
    value = 0;
  };
  count(profile.frames, "frames");
  count(profile.cuts, "cuts");
  count(profile.size.width, "width");
  count(profile.size.height, "height");
  return profile;
}

/// What the numbers say, or what the options force.
template <class T>
PlanDecision<T> decide(const PlanDecision<T>& by_numbers, const std::optional<T>& forced) {
  if (!forced) return by_numbers;
  const std::string said = *forced == by_numbers.choice ? "the numbers say the same" : "the numbers say otherwise";
  return {*forced, fmt::format("set by option; {}: {}", said, by_numbers.reason),
          *forced == by_numbers.choice ? by_numbers.saves : std::string(), true};
}

PlanDecision<GeometryProvider> choose_provider(const SceneProfile& p, const GeometryPlanOptions& o) {
  const auto prior = [](std::string reason) {
    return PlanDecision<GeometryProvider>{GeometryProvider::prior, std::move(reason),
                                          "the time of multi-view stereo; depth is then an assumption", false};
  };
  if (p.frames < 2) return prior(fmt::format("{} frame(s) show no parallax", p.frames));
  if (p.motion != ClipMotion::moving)
    return prior(fmt::format("the camera {}, so depth cannot be measured", phrase(p.motion)));
  if (p.parallax_px < o.min_parallax_px)
    return prior(
        fmt::format("parallax of {:.2f} px over the clip is below {:.2f} px", p.parallax_px, o.min_parallax_px));
  if (p.rms_error_px > o.max_error_px)
    return prior(
        fmt::format("the reconstruction is off by {:.2f} px, more than {:.2f} px", p.rms_error_px, o.max_error_px));
  if (p.registered_share < o.min_registered_share)
    return prior(fmt::format("only {:.0f} % of the poses were measured, below {:.0f} %", 100 * p.registered_share,
                             100 * o.min_registered_share));
  if (p.moving_share > o.max_moving_share)
    return prior(fmt::format("{:.0f} % of the pixels move by themselves, more than {:.0f} %", 100 * p.moving_share,
                             100 * o.max_moving_share));
  return {GeometryProvider::sfm,
          fmt::format("parallax of {:.1f} px over {} frames, reprojected within {:.2f} px, measures depth",
                      p.parallax_px, p.frames, p.rms_error_px),
          "nothing; it costs the time of multi-view stereo and replaces an assumption by a measurement", false};
}

PlanDecision<CloudKind> choose_cloud(const SceneProfile& p, const GeometryPlanOptions& o, GeometryProvider provider) {
  const auto per_frame = [](std::string reason) {
    return PlanDecision<CloudKind>{CloudKind::per_frame, std::move(reason),
                                   "drawing other frames; what one frame does not see stays open", false};
  };
  if (provider == GeometryProvider::prior)
    return per_frame("assumed depth of different frames does not agree well enough to be merged");
  if (p.frames < 2) return per_frame(fmt::format("{} frame(s): there is nothing to merge", p.frames));
  if (p.cuts > 0) return per_frame(fmt::format("{} cut(s): the shots show different scenes", p.cuts));
  if (p.motion != ClipMotion::moving)
    return per_frame(fmt::format("the camera {}: other frames see nothing new", phrase(p.motion)));
  if (p.measured_share > 0 && p.measured_share < o.min_measured_share)
    return per_frame(fmt::format("only {:.0f} % of the depths are measured, below {:.0f} %", 100 * p.measured_share,
                                 100 * o.min_measured_share));
  if (p.moving_share > o.max_moving_share)
    return per_frame(fmt::format("{:.0f} % of the pixels move by themselves, more than {:.0f} %", 100 * p.moving_share,
                                 100 * o.max_moving_share));
  if (p.disocclusion_share < o.min_disocclusion)
    return per_frame(fmt::format("single frames leave only {:.1f} % of the path uncovered, below {:.1f} %",
                                 100 * p.disocclusion_share, 100 * o.min_disocclusion));
  return {CloudKind::merged,
          fmt::format("single frames leave {:.1f} % of the path uncovered, and the camera saw the scene from {} places",
                      100 * p.disocclusion_share, p.frames),
          "generating what another frame has seen; it costs drawing a few more views for each frame", false};
}

PlanDecision<bool> choose_layers(const SceneProfile& p, const GeometryPlanOptions& o) {
  if (p.moving_share >= o.min_layer_motion)
    return {true, fmt::format("{:.1f} % of the pixels move by themselves", 100 * p.moving_share),
            "nothing; it keeps what moves from being smeared into the background", false};
  const std::string cost = "the time of finding and completing the background";
  if (p.depth_ratio < o.min_depth_ratio)
    return {false,
            fmt::format("the scene is flat: far is only {:.2f} times as far as near, below {:.2f}", p.depth_ratio,
                        o.min_depth_ratio),
            cost, false};
  if (p.disocclusion_share < o.min_disocclusion)
    return {false,
            fmt::format("the path uncovers only {:.1f} %, below {:.1f} %, and {:.1f} % of the pixels move",
                        100 * p.disocclusion_share, 100 * o.min_disocclusion, 100 * p.moving_share),
            cost, false};
  return {true,
          fmt::format("the path uncovers {:.1f} % of a scene whose far is {:.1f} times as far as its near",
                      100 * p.disocclusion_share, p.depth_ratio),
          "holes behind the foreground; it costs finding and completing the background", false};
}

PlanDecision<int> choose_stride(const SceneProfile& p, const GeometryPlanOptions& o, GeometryProvider provider) {
  if (provider != GeometryProvider::sfm) return {1, "depth is not matched between frames", "nothing", false};
  if (p.frames < 3) return {1, fmt::format("{} frames have nothing between them", p.frames), "nothing", false};
  const double per_frame = p.parallax_per_frame_px > 0 ? p.parallax_per_frame_px : p.parallax_px / (p.frames - 1);
  const double allowed = per_frame > 0 ? o.key_parallax_px / per_frame : static_cast<double>(o.max_key_stride);
  const int longest = std::min(o.max_key_stride, p.frames - 1);
  const int stride = static_cast<int>(std::clamp(std::floor(allowed), 1.0, static_cast<double>(longest)));
  const int keys = (p.frames - 1) / stride + 1;
  return {stride,
          fmt::format("parallax of {:.2f} px a frame reaches {:.1f} px after {:.1f} frames, at most {} allowed",
                      per_frame, o.key_parallax_px, allowed, longest),
          fmt::format("matching {} of {} frames", p.frames - std::min(keys, p.frames), p.frames), false};
}

PlanDecision<bool> choose_decimation(const SceneProfile& p) {
  return {false,
          fmt::format("drawing takes as long with a tenth of the {:.2f} million points: pixels set the pace",
                      static_cast<double>(p.size.pixels()) / 1e6),
          "the time of finding flat cells", false};
}

}  // namespace

std::string_view to_string(CloudKind kind) { return kind == CloudKind::merged ? "merged" : "per_frame"; }

std::string SceneProfile::brief() const {
  return fmt::format(
      "{} frames of {}x{}, the camera {}: parallax {:.1f} px, {:.1f} % moving, {:.1f} % uncovered, depth ratio {:.1f}, "
      "{} cuts",
      frames, size.width, size.height, phrase(motion), parallax_px, 100 * moving_share, 100 * disocclusion_share,
      depth_ratio, cuts);
}

std::string GeometryPlan::brief() const {
  const auto mark = [](bool forced) { return forced ? " (set)" : ""; };
  return fmt::format("depth from {}{}, {} cloud{}, {} layers{}, depth every {} frame(s){}, {} points{}",
                     to_string(provider.choice), mark(provider.forced), to_string(cloud.choice), mark(cloud.forced),
                     layers.choice ? "two" : "no", mark(layers.forced), key_stride.choice, mark(key_stride.forced),
                     decimate.choice ? "thinned" : "all", mark(decimate.forced));
}

void GeometryPlanOptions::check() const {
  const auto share = [](double value, const char* name) {
    require(value >= 0 && value <= 1, "{} {} is outside 0..1", name, value);
  };
  const auto positive = [](double value, const char* name) {
    require(value > 0 && std::isfinite(value), "{} {} is not positive", name, value);
  };
  positive(min_parallax_px, "min_parallax_px");
  positive(max_error_px, "max_error_px");
  share(min_registered_share, "min_registered_share");
  share(max_moving_share, "max_moving_share");
  share(min_measured_share, "min_measured_share");
  share(min_disocclusion, "min_disocclusion");
  require(min_depth_ratio >= 1 && std::isfinite(min_depth_ratio), "min_depth_ratio {} is below 1", min_depth_ratio);
  share(min_layer_motion, "min_layer_motion");
  positive(key_parallax_px, "key_parallax_px");
  require(max_key_stride >= 1, "max_key_stride {} is below 1", max_key_stride);
  require(!key_stride || *key_stride >= 1, "key_stride {} is below 1", key_stride.value_or(1));
}

GeometryPlan plan_geometry(const SceneProfile& profile, const GeometryPlanOptions& options) {
  options.check();
  GeometryPlan plan;
  const SceneProfile p = usable(profile, plan.notes);
  plan.provider = decide(choose_provider(p, options), options.provider);
  plan.cloud = decide(choose_cloud(p, options, plan.provider.choice), options.cloud);
  plan.layers = decide(choose_layers(p, options), options.layers);
  plan.key_stride = decide(choose_stride(p, options, plan.provider.choice), options.key_stride);
  plan.decimate = decide(choose_decimation(p), options.decimate);
  return plan;
}

}  // namespace uwv
