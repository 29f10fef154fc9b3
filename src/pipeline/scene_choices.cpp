// SPDX-License-Identifier: Apache-2.0
#include "pipeline/scene_choices.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace uwv::pipeline {
namespace {

using nlohmann::json;
using nlohmann::ordered_json;

double median(std::vector<double>& values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// How far two pictures of a scene shift against each other beyond what turning the camera explains: turning moves all
/// depths alike, so it takes the shift of the middle depth with it. Points are given in the first camera.
double unexplained_shift(const std::vector<Eigen::Vector3d>& x_in_first, const Camera& first, const Camera& second) {
  std::vector<double> depths;
  for (const Eigen::Vector3d& x : x_in_first) depths.push_back(x.z());
  const double middle = median(depths);
  if (!(middle > 0)) return 0;
  const Rigid3 second_from_first = target_from_source(second, first);
  std::vector<double> shifts;
  for (const Eigen::Vector3d& x : x_in_first) {
    Eigen::Vector2d landed(0, 0), at_middle(0, 0);
    if (x.z() > 0 && project(second.intrinsics, second_from_first * x, landed) &&
        project(second.intrinsics, second_from_first * (x * (middle / x.z())), at_middle))
      shifts.push_back((landed - at_middle).norm());
  }
  return median(shifts);
}

/// Points of a depth map, a few hundred.
std::vector<Eigen::Vector3d> sampled_points(const DepthMap& depth, const Intrinsics& intrinsics) {
  constexpr int per_side = 24;
  std::vector<Eigen::Vector3d> points;
  for (int j = 0; j < per_side; ++j)
    for (int i = 0; i < per_side; ++i) {
      const int x = (2 * i + 1) * depth.width() / (2 * per_side), y = (2 * j + 1) * depth.height() / (2 * per_side);
      if (const float z = depth(x, y); z > 0)
        points.push_back(unproject(intrinsics, {x + 0.5, y + 0.5}, static_cast<double>(z)));
    }
  return points;
}

Camera camera_of(const SourceClip& source, long index) {
  return {source.intrinsics(index), source.world_from_cam(index), source.size()};
}

ClipMotion motion_of(const SourceClip& source) {
  const auto& poses = source.world_from_cam();
  const auto differs = [&](auto same) { return !std::all_of(poses.begin(), poses.end(), same); };
  if (differs([&](const Rigid3& pose) { return pose.translation == poses.front().translation; }))
    return ClipMotion::moving;
  return differs([&](const Rigid3& pose) { return pose == poses.front(); }) ? ClipMotion::turning : ClipMotion::still;
}

/// What given cameras and depth say: poses are taken at their word, and so is depth.
void measure_given(SourceClip& source, SceneProfile& profile) {
  profile.motion = motion_of(source);
  profile.registered_share = 1;
  profile.measured_share = 1;
  const auto first = source.read(0);
  if (!first) return;
  if (first->foreground && source.frames() > 1) profile.moving_share = share_of(first->foreground->pixels());
  if (profile.motion != ClipMotion::moving) return;
  const std::vector<Eigen::Vector3d> points = sampled_points(first->depth, source.intrinsics(0));
  std::vector<double> steps;
  for (long i = 1; i < source.frames(); ++i) {
    profile.parallax_px =
        std::max(profile.parallax_px, unexplained_shift(points, camera_of(source, 0), camera_of(source, i)));
    Camera moved = camera_of(source, 0);  // the step between two frames, taken from the first
    moved.world_from_cam = moved.world_from_cam * target_from_source(camera_of(source, i - 1), camera_of(source, i));
    steps.push_back(unexplained_shift(points, camera_of(source, 0), moved));
  }
  profile.parallax_per_frame_px = median(steps);
}

double number(const json& from, const char* key) {
  const auto found = from.find(key);
  return found != from.end() && found->is_number() ? found->get<double>() : 0.0;
}

/// What the geometry stage wrote; what is missing stays unknown.
void take_recorded(const json& from, SceneProfile& profile) {
  const auto motion = from.find("motion");
  if (motion != from.end())
    for (const ClipMotion known :
         {ClipMotion::moving, ClipMotion::turning, ClipMotion::still, ClipMotion::indeterminate})
      if (*motion == to_string(known)) profile.motion = known;
  profile.parallax_px = number(from, "parallax_px");
  profile.parallax_per_frame_px = number(from, "parallax_per_frame_px");
  profile.rms_error_px = number(from, "rms_error_px");
  profile.registered_share = number(from, "registered_share");
  profile.moving_share = number(from, "moving_share");
  profile.measured_share = number(from, "measured_share");
  profile.cuts = static_cast<int>(std::clamp(number(from, "cuts"), 0.0, 1e6));
}

GeometryProvider provider_of(const std::optional<GeometryFolder>& geometry) {
  if (!geometry) return GeometryProvider::import;
  for (const GeometryProvider known : {GeometryProvider::network, GeometryProvider::sfm, GeometryProvider::prior})
    if (geometry->description.value("provider", json()) == to_string(known)) return known;
  return GeometryProvider::import;
}

/// The stride was chosen when depth was computed.
PlanDecision<int> stride_of(const std::optional<GeometryFolder>& geometry) {
  if (!geometry) return {1, "depth is given for every frame", "nothing", false};
  const json made = geometry->description.value("key_stride", json());
  if (!made.is_object() || !made.value("choice", json()).is_number_integer())
    return {1, "the geometry folder does not say", "nothing", false};
  const auto text = [&](const char* key) {
    const json value = made.value(key, json());
    return value.is_string() ? value.get<std::string>() : std::string();
  };
  return {made["choice"].get<int>(), text("reason"), text("saves"), made.value("forced", json(false)) == true};
}

}  // namespace

double parallax_per_frame(const SfmResult& sfm) {
  std::vector<std::vector<Eigen::Vector3d>> x_in_cam(sfm.cameras.size());
  for (const ScenePoint& point : sfm.points)
    for (const PointObservation& seen : point.observations) {
      const auto frame = static_cast<std::size_t>(seen.frame);
      x_in_cam[frame].push_back(sfm.cameras[frame].cam_from_world() * point.x_in_world);
    }
  std::vector<double> steps;
  for (std::size_t i = 0; i + 1 < x_in_cam.size(); ++i)
    if (!x_in_cam[i].empty()) steps.push_back(unexplained_shift(x_in_cam[i], sfm.cameras[i], sfm.cameras[i + 1]));
  return median(steps);
}

double share_of(std::span<const std::uint8_t> mask) {
  const auto ones = std::count(mask.begin(), mask.end(), std::uint8_t{1});
  return mask.empty() ? 0 : static_cast<double>(ones) / static_cast<double>(mask.size());
}

double mean_share(std::span<const ForegroundMask> masks) {
  double sum = 0;
  for (const ForegroundMask& mask : masks) sum += share_of(mask.pixels());
  return masks.empty() ? 0 : sum / static_cast<double>(masks.size());
}

ordered_json to_json(const SceneProfile& p) {
  return {{"size", fmt::format("{}x{}", p.size.width, p.size.height)},
          {"frames", p.frames},
          {"motion", to_string(p.motion)},
          {"parallax_px", p.parallax_px},
          {"parallax_per_frame_px", p.parallax_per_frame_px},
          {"rms_error_px", p.rms_error_px},
          {"registered_share", p.registered_share},
          {"moving_share", p.moving_share},
          {"measured_share", p.measured_share},
          {"disocclusion_share", p.disocclusion_share},
          {"depth_ratio", p.depth_ratio},
          {"cuts", p.cuts}};
}

SceneProfile profile_of(SourceClip& source, const SceneLook& look, const std::optional<GeometryFolder>& geometry) {
  SceneProfile profile;
  const json recorded = geometry ? geometry->description.value("profile", json()) : json();
  if (recorded.is_object())
    take_recorded(recorded, profile);
  else
    measure_given(source, profile);
  profile.size = source.size();
  profile.frames = static_cast<int>(source.frames());
  profile.disocclusion_share = look.uncovered_share;
  profile.depth_ratio = look.near_depth > 0 ? std::max(1.0, look.far_depth / look.near_depth) : 1.0;
  return profile;
}

SceneChoices choose(SourceClip& source, const SceneLook& look, const std::optional<GeometryFolder>& geometry,
                    const RunOptions& options) {
  SceneChoices choices;
  choices.profile = profile_of(source, look, geometry);
  GeometryPlanOptions wishes;
  wishes.provider = provider_of(geometry);
  if (options.cloud != CloudChoice::automatic)
    wishes.cloud = options.cloud == CloudChoice::merged ? CloudKind::merged : CloudKind::per_frame;
  if (options.layers != LayerChoice::automatic) wishes.layers = options.layers == LayerChoice::on;
  if (options.max_error) wishes.decimate = *options.max_error > 0;
  choices.plan = plan_geometry(choices.profile, wishes);
  choices.plan.key_stride = stride_of(geometry);
  if (!source.has_background() && choices.plan.layers.choice)
    choices.plan.layers = {false,
                           geometry ? "the geometry has no background apart from its foreground"
                                    : "depth is given, and no background behind it",
                           "nothing", wishes.layers.has_value()};
  return choices;
}

ordered_json SceneChoices::to_json() const {
  return {{"cloud", pipeline::to_json(plan.cloud)},
          {"layers", pipeline::to_json(plan.layers)},
          {"key_stride", pipeline::to_json(plan.key_stride)},
          {"decimate", pipeline::to_json(plan.decimate)}};
}

std::string SceneChoices::brief() const {
  const auto mark = [](bool forced) { return forced ? " (set)" : ""; };
  return fmt::format("{} cloud{}: {}; layers {}{}; depth of one frame in {}{}; points {}{}",
                     plan.cloud.choice == CloudKind::merged ? "merged" : "per-frame", mark(plan.cloud.forced),
                     plan.cloud.reason, plan.layers.choice ? "on" : "off", mark(plan.layers.forced),
                     plan.key_stride.choice, mark(plan.key_stride.forced), plan.decimate.choice ? "thinned" : "all",
                     mark(plan.decimate.forced));
}

}  // namespace uwv::pipeline
