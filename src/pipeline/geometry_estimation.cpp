// SPDX-License-Identifier: Apache-2.0
#include "pipeline/geometry_estimation.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "pipeline/given_pictures.h"
#include "pipeline/moving_layer.h"
#include "pipeline/network_geometry.h"
#include "pipeline/other_shots.h"
#include "pipeline/relative_depth.h"
#include "pipeline/resources.h"
#include "pipeline/scene_choices.h"
#include "uwv/geometry/background_completion.h"
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
                        {"frames_of_other_shots", std::count(sfm.in_shot.begin(), sfm.in_shot.end(), 0)},
                        {"notes", sfm.notes},
                        {"seconds", sfm.seconds}};
  if (!sfm.cameras.empty())
    facts["lens"] = {{"fx", sfm.cameras.front().intrinsics.fx},
                     {"fov_deg", fov_deg(sfm.cameras.front().intrinsics, sfm.cameras.front().size)},
                     {"estimated", sfm.focal_estimated}};
  return facts;
}

/// Of all pixels, those whose depth counts as measured.
double measured_share(const SceneGeometry& scene) {
  constexpr float measured = 0.5F;
  double count = 0, pixels = 0;
  for (const FrameGeometry& frame : scene.frames) {
    const auto values = frame.confidence.pixels();
    count += static_cast<double>(std::count_if(values.begin(), values.end(), [](float c) { return c >= measured; }));
    pixels += static_cast<double>(values.size());
  }
  return pixels > 0 ? count / pixels : 0;
}

/// The steps of an estimation, each noting in `facts_` what it found or why it was left out.
class Estimation {
 public:
  Estimation(const RunOptions& options, const ClipToEstimate& clip, ThreadPool& pool, Monitor& monitor)
      : options_(options),
        frames_(clip.frames),
        relative_(clip.relative),
        known_(clip.known),
        foreground_networks_(clip.foreground_networks),
        pool_(pool),
        monitor_(monitor) {
    if (clip.network != nullptr) network_.emplace(*clip.network, frames_, pool_, monitor_);
    if (!known_ && network_) known_ = network_->lens();
  }

  EstimatedGeometry run() {
    find_cameras();
    const std::span<const ImageRgb> clip = frames_;
    const std::optional<Shot> shot = stay_in_shot();
    const GeometryProvider provider = choose();
    result_.facts["provider"] = to_string(provider);
    if (network_)
      believe_network();
    else if (!relative_.empty())
      bring_to_scale();
    else if (provider == GeometryProvider::sfm)
      measure();
    else
      assume();
    if (shot) spread_over_clip(*shot, clip, pool_, monitor_, result_);
    if (network_) result_.facts["network"] = network_->facts();
    result_.facts["profile"] = to_json(profile_);
    result_.facts["brief"] = brief_;
    return std::move(result_);
  }

 private:
  Size size() const { return frames_.front().size(); }
  bool depth_is_given() const { return network_ || !relative_.empty(); }

  void find_cameras() {
    if (options_.geometry == GeometryChoice::prior || frames_.size() == 1) {
      sfm_.motion = ClipMotion::still;
      sfm_.reason = frames_.size() == 1 ? "one frame shows no motion" : "--geometry prior: not looked at";
      result_.facts["structure_from_motion"] = "skipped: " + sfm_.reason;
      return;
    }
    if (network_ && network_->has_cameras()) {
      sfm_.reason = "the network gives the cameras";
      result_.facts["structure_from_motion"] = "skipped: " + sfm_.reason;
      return;
    }
    SfmOptions asked = sfm_options(options_);
    asked.intrinsics = known_;
    sfm_ = structure_from_motion(frames_, asked, pool_, monitor_);
    result_.facts["structure_from_motion"] = facts_of(sfm_);
    for (const std::string& note : sfm_.notes) monitor_.warn(fmt::format("{}: {}", options_.video, note));
    if (!sfm_.cuts.empty())
      monitor_.warn(fmt::format(
          "{}: the picture cuts at {} place(s), first at frame {}; what is found is of the longest shot, "
          "{}: use --start and --max-frames to take one",
          options_.video, sfm_.cuts.size(), sfm_.cuts.front(),
          depth_is_given() ? "the cameras of the others are placeholders" : "the depth of the others is assumed"));
  }

  /// Everything that is estimated from the pictures alone is of one shot. Given depth is of every frame.
  std::optional<Shot> stay_in_shot() {
    const std::optional<Shot> shot = depth_is_given() ? std::nullopt : reconstructed_shot(sfm_);
    if (!shot) return shot;
    cuts_ = static_cast<int>(sfm_.cuts.size());
    sfm_ = of_shot(std::move(sfm_), *shot);
    frames_ = frames_.subspan(shot->first, shot->count);
    options_.start += static_cast<long>(shot->first) * options_.stride;
    return shot;
  }

  GeometryProvider choose() {
    profile_.size = size();
    profile_.frames = static_cast<int>(frames_.size());
    profile_.motion = sfm_.motion;
    profile_.parallax_px = sfm_.parallax_px;
    profile_.parallax_per_frame_px = parallax_per_frame(sfm_);
    profile_.rms_error_px = sfm_.rms_error_px;
    profile_.registered_share = registered_share(sfm_);
    profile_.cuts = std::max(cuts_, static_cast<int>(sfm_.cuts.size()));
    if (network_) return believe();
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

  GeometryProvider believe() {
    const bool asked = options_.geometry == GeometryChoice::network;
    if (network_moves()) profile_.motion = ClipMotion::moving;
    result_.facts["choice"] = to_json(PlanDecision<GeometryProvider>{
        GeometryProvider::network, asked ? "--geometry network" : "--depth-model is given", "", asked});
    brief_ = sfm_.cameras.empty() ? "depth from the network" : "depth from the network; " + sfm_.brief();
    return GeometryProvider::network;
  }

  /// The network gives the cameras, of a clip.
  bool network_moves() const { return network_->has_cameras() && frames_.size() > 1; }

  void measure() {
    result_.scene.cameras = sfm_.cameras;
    result_.scene.depth_from = result_.scene.cameras_from = GeometryProvider::sfm;
    const MovingPixels moving =
        find_moving_layer(options_, foreground_networks_, frames_, sfm_.cameras, {}, pool_, monitor_, result_.facts);
    const bool something_moves = matters(moving);
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
      brief_ += "; " + place_moving_layer(options_, frames_, moving, pool_, monitor_, result_);
    else
      result_.facts["moving_depth"] =
          fmt::format("skipped: {:.2f} % of the pixels move by themselves", 100 * moving.moving_share);
  }

  Intrinsics lens() const {
    if (known_) return *known_;
    return sfm_.focal_estimated ? sfm_.cameras.front().intrinsics : assumed_intrinsics(size());
  }

  void assume() {
    lay_prior();
    monitor_.warn(fmt::format("depth is a prior, not a measurement ({}): give --depth or --depth-model for real depth",
                              sfm_.reason));
  }

  /// The reference of depth that has no unit of its own, where nothing was measured.
  void refer_to_prior() {
    lay_prior();
    monitor_.warn(
        fmt::format("scale and shift of the given depth are those of a prior, not of a measurement ({})", sfm_.reason));
  }

  void lay_prior() {
    const StageClock clock;
    ClipForeground foreground = find_clip_foreground(options_, foreground_networks_, frames_, pool_, monitor_);
    result_.facts["foreground"] = foreground.note;
    if (frames_.size() > 1) profile_.moving_share = mean_share(foreground.masks);
    PlanarPriorOptions prior_options;
    prior_options.locked_off = sfm_.motion == ClipMotion::still;
    PlanarPriorResult prior = planar_prior(frames_, foreground.masks, lens(), prior_options, pool_, monitor_);
    result_.scene = std::move(prior.geometry);
    take_rotations();
    complete_behind(foreground.masks, prior_options, prior);
    result_.foreground = std::move(foreground.masks);
    result_.facts["planar_prior"] = {{"horizon_row", prior.horizon_row},
                                     {"horizon_from", to_string(prior.horizon_from)},
                                     {"backdrop_row", prior.backdrop_row},
                                     {"backdrop_from", to_string(prior.backdrop_from)},
                                     {"backdrop_distance", prior.backdrop_distance},
                                     {"foreground_share", prior.foreground_share},
                                     {"contour", prior.contour.empty() ? "level" : "by column"},
                                     {"sky",
                                      {{"believed", prior.sky.believed},
                                       {"share", prior.sky.share},
                                       {"of_edge", prior.sky.of_edge},
                                       {"contrast", prior.sky.contrast},
                                       {"blue_over_red", prior.sky.blue_over_red}}},
                                     {"seconds", clock.seconds()}};
    brief_ += "; " + prior.brief();
    warn_of_assumed_lens();
  }

  /// The cameras of a clip without parallax: one place, and the turns that were seen.
  void take_rotations() {
    if (sfm_.motion != ClipMotion::turning) return;
    for (std::size_t i = 0; i < frames_.size(); ++i)
      result_.scene.cameras[i].world_from_cam = sfm_.cameras[i].world_from_cam;
    result_.scene.cameras_from = GeometryProvider::sfm;
  }

  void warn_of_assumed_lens() {
    if (!known_ && !sfm_.focal_estimated)
      monitor_.warn(
          fmt::format("no intrinsics given: assuming a horizontal field of view of {} degrees; set --fov or "
                      "--fx",
                      assumed_fov_deg));
  }

  /// What stands before the background, when the clip has both and they are wanted apart.
  bool wants_background(const std::vector<ForegroundMask>& foreground) {
    if (!foreground.empty() && options_.layers != LayerChoice::off) return true;
    result_.facts["background"] = foreground.empty() ? "skipped: nothing stands before it" : "skipped: --layers off";
    return false;
  }

  std::vector<ImageRgb> without_foreground(const std::vector<ForegroundMask>& foreground) {
    if (!options_.background.empty()) {
      result_.facts["background"] = {{"given", options_.background}};
      return read_given_pictures(options_.background, "background picture", options_, frames_.size(), size(), monitor_);
    }
    CompletionOptions completion;
    completion.camera_moves = sfm_.motion == ClipMotion::turning;
    BackgroundClip background = complete_background(frames_, foreground, completion, pool_, monitor_);
    result_.facts["background"] = {{"seen_in_other_frames_share", background.share_seen},
                                   {"invented_share", background.share_invented},
                                   {"notes", background.notes}};
    return std::move(background.frames);
  }

  /// The scene without its foreground, laid out like the scene with it.
  void complete_behind(const std::vector<ForegroundMask>& foreground, PlanarPriorOptions layout,
                       const PlanarPriorResult& with_foreground) {
    if (!wants_background(foreground)) return;
    std::vector<ImageRgb> background = without_foreground(foreground);
    layout.horizon_row = with_foreground.horizon_row;
    layout.backdrop_row = with_foreground.backdrop_row;
    layout.contour = with_foreground.contour;
    PlanarPriorResult behind = planar_prior(background, {}, lens(), layout, pool_, monitor_);
    result_.background.colour = std::move(background);
    for (FrameGeometry& frame : behind.geometry.frames) result_.background.depth.push_back(std::move(frame.depth));
  }

  /// The network's depth, in front of cameras that it, the pictures, or nobody knows.
  void believe_network() {
    const bool moves = sfm_.motion == ClipMotion::moving || network_moves();
    if (network_->has_cameras()) {
      result_.scene.cameras = network_->cameras(known_);
      result_.scene.cameras_from = GeometryProvider::network;
    } else if (moves) {
      result_.scene.cameras = sfm_.cameras;
      result_.scene.cameras_from = GeometryProvider::sfm;
    } else if (network_->needs_reference()) {
      refer_to_prior();
    } else {
      result_.scene.cameras.assign(frames_.size(), {lens(), Rigid3{}, size()});
      take_rotations();
      warn_of_assumed_lens();
    }
    network_->place(sfm_.points, sfm_.motion == ClipMotion::still, result_.scene);
    profile_.measured_share = measured_share(result_.scene);
    if (moves)
      find_what_moves();
    else
      lay_network_behind();
  }

  void find_what_moves() {
    const MovingPixels moving = find_moving_layer(options_, foreground_networks_, frames_, result_.scene.cameras,
                                                  result_.scene.frames, pool_, monitor_, result_.facts);
    profile_.moving_share = moving.moving_share;
    if (matters(moving)) lay_behind_moving(options_, frames_, moving, pool_, monitor_, result_);
  }

  /// A standing camera's background: completed pictures, and what the network says of them.
  void lay_network_behind() {
    if (network_->needs_reference()) {  // the prior's layers are there already
      if (result_.background.colour.empty()) return;
    } else {
      ClipForeground foreground = find_clip_foreground(options_, foreground_networks_, frames_, pool_, monitor_);
      result_.facts["foreground"] = foreground.note;
      result_.foreground = std::move(foreground.masks);
      if (frames_.size() > 1) profile_.moving_share = mean_share(result_.foreground);
      if (!wants_background(result_.foreground)) return;
      result_.background.colour = without_foreground(result_.foreground);
    }
    result_.background.depth = network_->behind(result_.background.colour, result_.foreground, result_.scene);
  }

  void bring_to_scale() {
    if (sfm_.motion == ClipMotion::moving)
      result_.scene.cameras = sfm_.cameras, result_.scene.cameras_from = GeometryProvider::sfm;
    else
      refer_to_prior();
    constexpr float believed = 0.5F;  // another's estimate, at a scale that was measured
    AlignmentOptions alignment = alignment_of(options_.depth_kind);
    alignment.smoothing = options_.depth_smoothing;
    const RelativeDepthOutcome outcome =
        bring_relative_depth_to_scale(relative_, alignment, sfm_.points, believed, result_.scene, pool_, monitor_);
    result_.scene.depth_from = GeometryProvider::import;
    result_.facts["alignment"] = outcome.facts;
    brief_ += "; " + outcome.alignment.brief();
  }

  RunOptions options_;  ///< Its start follows the shot.
  std::span<const ImageRgb> frames_;
  std::span<const DepthMap> relative_;
  std::optional<Intrinsics> known_;
  const ForegroundNetworks& foreground_networks_;
  ThreadPool& pool_;
  Monitor& monitor_;
  std::optional<NetworkGeometry> network_;
  SfmResult sfm_;
  SceneProfile profile_;
  int key_stride_ = 1;
  int cuts_ = 0;
  std::string brief_;
  EstimatedGeometry result_;
};

}  // namespace

EstimatedGeometry estimate_geometry(const RunOptions& options, const ClipToEstimate& clip, ThreadPool& pool,
                                    Monitor& monitor) {
  return Estimation(options, clip, pool, monitor).run();
}

}  // namespace uwv::pipeline
