// SPDX-License-Identifier: Apache-2.0
#include "pipeline/geometry_estimation.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "pipeline/clip_foreground.h"
#include "pipeline/relative_depth.h"
#include "pipeline/resources.h"
#include "pipeline/scene_choices.h"
#include "uwv/geometry/background_completion.h"
#include "uwv/geometry/moving_objects.h"
#include "uwv/geometry/planar_prior.h"

namespace uwv::pipeline {
namespace {

using nlohmann::ordered_json;

double fov_deg(const Intrinsics& intrinsics, Size size) {
  return 2 * std::atan(0.5 * size.width / std::abs(intrinsics.fx)) * 180 / std::numbers::pi;
}

double registered_share(const SfmResult& sfm) {
  if (sfm.registered.empty()) return 0;
  const auto measured = std::count(sfm.registered.begin(), sfm.registered.end(), std::uint8_t{1});
  return static_cast<double>(measured) / static_cast<double>(sfm.registered.size());
}

ordered_json facts_of(const SfmResult& sfm) {
  ordered_json facts = {{"motion", to_string(sfm.motion)},
                        {"reason", sfm.reason},
                        {"parallax_px", sfm.parallax_px},
                        {"points", sfm.points.size()},
                        {"registered_share", registered_share(sfm)},
                        {"rms_error_px", sfm.rms_error_px},
                        {"moving_tracks_share", sfm.moving_share},
                        {"cuts", sfm.cuts},
                        {"seconds", sfm.seconds}};
  if (!sfm.cameras.empty())
    facts["lens"] = {{"fx", sfm.cameras.front().intrinsics.fx},
                     {"fov_deg", fov_deg(sfm.cameras.front().intrinsics, sfm.cameras.front().size)},
                     {"estimated", sfm.focal_estimated}};
  return facts;
}

/// The steps of an estimation, each noting in `facts_` what it found or why it was left out.
class Estimation {
 public:
  Estimation(const RunOptions& options, std::span<const ImageRgb> frames, std::span<const DepthMap> relative,
             const std::optional<Intrinsics>& known, ThreadPool& pool, Monitor& monitor)
      : options_(options), frames_(frames), relative_(relative), known_(known), pool_(pool), monitor_(monitor) {}

  EstimatedGeometry run() {
    find_cameras();
    const GeometryProvider provider = choose();
    result_.facts["provider"] = to_string(provider);
    if (!relative_.empty())
      bring_to_scale();
    else if (provider == GeometryProvider::sfm)
      measure();
    else
      assume();
    result_.facts["profile"] = to_json(profile_);
    result_.facts["brief"] = brief_;
    return std::move(result_);
  }

 private:
  Size size() const { return frames_.front().size(); }

  void find_cameras() {
    if (options_.geometry == GeometryChoice::prior || frames_.size() == 1) {
      sfm_.motion = ClipMotion::still;
      sfm_.reason = frames_.size() == 1 ? "one frame shows no motion" : "--geometry prior: not looked at";
      result_.facts["structure_from_motion"] = "skipped: " + sfm_.reason;
      return;
    }
    SfmOptions asked = sfm_options(options_);
    asked.intrinsics = known_;
    sfm_ = structure_from_motion(frames_, asked, pool_, monitor_);
    result_.facts["structure_from_motion"] = facts_of(sfm_);
    if (!sfm_.cuts.empty())
      monitor_.warn(
          fmt::format("{}: the picture cuts at {} place(s), first at frame {}; the geometry is that of the longest "
                      "shot: use --start and --max-frames to take one",
                      options_.video, sfm_.cuts.size(), sfm_.cuts.front()));
  }

  GeometryProvider choose() {
    profile_.size = size();
    profile_.frames = static_cast<int>(frames_.size());
    profile_.motion = sfm_.motion;
    profile_.parallax_px = sfm_.parallax_px;
    profile_.parallax_per_frame_px = parallax_per_frame(sfm_);
    profile_.rms_error_px = sfm_.rms_error_px;
    profile_.registered_share = registered_share(sfm_);
    profile_.cuts = static_cast<int>(sfm_.cuts.size());
    GeometryPlanOptions wishes;
    wishes.min_parallax_px = options_.min_parallax_px;
    if (options_.geometry == GeometryChoice::prior) wishes.provider = GeometryProvider::prior;
    if (options_.mvs_key_stride > 0) wishes.key_stride = options_.mvs_key_stride;
    const GeometryPlan plan = plan_geometry(profile_, wishes);
    const auto& chosen = plan.provider;
    result_.facts["choice"] = to_json(chosen);
    result_.facts["key_stride"] = to_json(plan.key_stride);
    key_stride_ = plan.key_stride.choice;
    if (options_.geometry == GeometryChoice::sfm && chosen.choice != GeometryProvider::sfm)
      fail(ErrorCode::value_invalid,
           "{}: depth cannot be measured from it: {}; use --geometry auto or prior, or give --depth", options_.video,
           sfm_.reason);
    brief_ = sfm_.brief();
    return chosen.choice;
  }

  void measure() {
    result_.scene.cameras = sfm_.cameras;
    result_.scene.depth_from = result_.scene.cameras_from = GeometryProvider::sfm;
    const MovingPixels moving = find_moving_pixels(frames_, sfm_.cameras, {}, {}, pool_, monitor_);
    result_.facts["moving_pixels"] = {
        {"share", moving.moving_share}, {"notes", moving.notes}, {"seconds", moving.seconds}};
    const bool something_moves = moving.moving_share > GeometryPlanOptions{}.min_layer_motion;
    const std::span<const ValidityMask> static_pixels =
        something_moves ? std::span<const ValidityMask>(moving.static_pixels) : std::span<const ValidityMask>();
    MvsOptions stereo = mvs_options(options_);
    stereo.key_stride = key_stride_;
    const MvsSummary mvs = multi_view_stereo(frames_, sfm_.cameras, sfm_.points, static_pixels, stereo, pool_, monitor_,
                                             result_.scene.frames);
    profile_.moving_share = moving.moving_share;
    profile_.measured_share = mvs.measured_share;
    result_.facts["multi_view_stereo"] = {{"matched_frames", mvs.matched_frames},
                                          {"measured_share", mvs.measured_share},
                                          {"seconds", mvs.seconds},
                                          {"notes", mvs.notes}};
    brief_ += "; " + mvs.brief();
    if (something_moves)
      place_moving(moving);
    else
      result_.facts["moving_depth"] =
          fmt::format("skipped: {:.2f} % of the pixels move by themselves", 100 * moving.moving_share);
  }

  void place_moving(const MovingPixels& moving) {
    result_.facts["background"] = "skipped: what moving objects hide is completed for cameras that stand still only";
    const MovingDepthSummary placed =
        fill_moving_depth(frames_, sfm_.cameras, moving.static_pixels, {}, pool_, monitor_, result_.scene.frames);
    result_.facts["moving_depth"] = {{"objects", placed.objects.size()},
                                     {"contact_share", placed.contact_share},
                                     {"unknown_share", placed.unknown_share},
                                     {"notes", placed.notes},
                                     {"seconds", placed.seconds}};
    brief_ += "; " + placed.brief();
    for (const ValidityMask& fixed : moving.static_pixels) {
      ForegroundMask mask(fixed.size());
      std::transform(fixed.pixels().begin(), fixed.pixels().end(), mask.pixels().begin(),
                     [](std::uint8_t still) { return static_cast<std::uint8_t>(still == 0); });
      result_.foreground.push_back(std::move(mask));
    }
  }

  Intrinsics lens() const {
    if (known_) return *known_;
    return sfm_.focal_estimated ? sfm_.cameras.front().intrinsics : assumed_intrinsics(size());
  }

  void assume() {
    const StageClock clock;
    ClipForeground foreground = find_clip_foreground(options_, frames_, pool_, monitor_);
    if (frames_.size() > 1) profile_.moving_share = mean_share(foreground.masks);
    PlanarPriorOptions prior_options;
    prior_options.locked_off = sfm_.motion == ClipMotion::still;
    PlanarPriorResult prior = planar_prior(frames_, foreground.masks, lens(), prior_options, pool_, monitor_);
    result_.scene = std::move(prior.geometry);
    if (sfm_.motion == ClipMotion::turning) {
      for (std::size_t i = 0; i < frames_.size(); ++i)
        result_.scene.cameras[i].world_from_cam = sfm_.cameras[i].world_from_cam;
      result_.scene.cameras_from = GeometryProvider::sfm;
    }
    result_.facts["foreground"] = foreground.note;
    complete_behind(foreground.masks, prior_options, prior);
    result_.foreground = std::move(foreground.masks);
    result_.facts["planar_prior"] = {{"horizon_row", prior.horizon_row},
                                     {"horizon_from", to_string(prior.horizon_from)},
                                     {"backdrop_row", prior.backdrop_row},
                                     {"backdrop_from", to_string(prior.backdrop_from)},
                                     {"backdrop_distance", prior.backdrop_distance},
                                     {"foreground_share", prior.foreground_share},
                                     {"seconds", clock.seconds()}};
    brief_ += "; " + prior.brief();
    if (!known_ && !sfm_.focal_estimated)
      monitor_.warn(
          fmt::format("no intrinsics given: assuming a horizontal field of view of {} degrees; set --fov or "
                      "--fx",
                      assumed_fov_deg));
    monitor_.warn(fmt::format("depth is a prior, not a measurement ({}): give --depth for real depth", sfm_.reason));
  }

  /// The scene without its foreground, laid out like the scene with it.
  void complete_behind(const std::vector<ForegroundMask>& foreground, PlanarPriorOptions layout,
                       const PlanarPriorResult& with_foreground) {
    if (foreground.empty() || options_.layers == LayerChoice::off) {
      result_.facts["background"] = foreground.empty() ? "skipped: nothing stands before it" : "skipped: --layers off";
      return;
    }
    CompletionOptions completion;
    completion.camera_moves = sfm_.motion == ClipMotion::turning;
    BackgroundClip background = complete_background(frames_, foreground, completion, pool_, monitor_);
    layout.horizon_row = with_foreground.horizon_row;
    layout.backdrop_row = with_foreground.backdrop_row;
    PlanarPriorResult behind = planar_prior(background.frames, {}, lens(), layout, pool_, monitor_);
    result_.background.colour = std::move(background.frames);
    for (FrameGeometry& frame : behind.geometry.frames) result_.background.depth.push_back(std::move(frame.depth));
    result_.facts["background"] = {{"seen_in_other_frames_share", background.share_seen},
                                   {"invented_share", background.share_invented},
                                   {"notes", background.notes}};
  }

  void bring_to_scale() {
    if (sfm_.motion == ClipMotion::moving)
      result_.scene.cameras = sfm_.cameras;
    else
      assume();
    const RelativeDepthOutcome outcome = bring_relative_depth_to_scale(frames_, relative_, options_.depth_kind,
                                                                       sfm_.points, result_.scene, pool_, monitor_);
    result_.facts["alignment"] = outcome.facts;
    brief_ += "; " + outcome.brief;
  }

  const RunOptions& options_;
  std::span<const ImageRgb> frames_;
  std::span<const DepthMap> relative_;
  const std::optional<Intrinsics>& known_;
  ThreadPool& pool_;
  Monitor& monitor_;
  SfmResult sfm_;
  SceneProfile profile_;
  int key_stride_ = 1;
  std::string brief_;
  EstimatedGeometry result_;
};

}  // namespace

EstimatedGeometry estimate_geometry(const RunOptions& options, std::span<const ImageRgb> frames,
                                    std::span<const DepthMap> relative, const std::optional<Intrinsics>& known,
                                    ThreadPool& pool, Monitor& monitor) {
  return Estimation(options, frames, relative, known, pool, monitor).run();
}

}  // namespace uwv::pipeline
