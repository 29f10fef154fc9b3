// SPDX-License-Identifier: Apache-2.0
#include "io/json_text.h"
#include "trajectory/json_node.h"
#include "trajectory/orbit_lists_file.h"
#include "trajectory/parse_motion.h"
#include "trajectory/spec_keys.h"
#include "uwv/trajectory/trajectory_spec.h"

namespace uwv {
namespace {

using detail::JsonNode;
using detail::Range;

constexpr Range any_elevation{-90, 90, true, true};
constexpr Range any_radius{1e-9, 1e12};
constexpr Range any_radius_scale{0, 1e3};
constexpr Range any_rate{0, 1000, true};

template <std::size_t N>
std::size_t choice(const JsonNode& node, const std::array<std::string_view, N>& names) {
  return static_cast<std::size_t>(std::find(names.begin(), names.end(), node.text(names)) - names.begin());
}

TimeControl parse_time(const JsonNode& node) {
  constexpr long last = TrajectorySpec::max_frames - 1;
  if (!node.value().is_object()) {
    if (node.value() != "follow")
      node.refuse("\"follow\", {\"freeze\": i}, {\"frames\": [...]} or {\"from\": a, \"to\": b}");
    return FollowTime{};
  }
  node.check_keys({"freeze", "frames", "from", "to"});
  if (node.value().size() != (node.has("from") ? 2U : 1U))
    node.complain("one of 'freeze', 'frames' or the pair 'from', 'to' is wanted");
  if (node.has("freeze")) return FreezeTime{node["freeze"].integer(0, last)};
  if (node.has("from") || node.has("to")) return SpanTime{node["from"].integer(0, last), node["to"].integer(0, last)};
  ListedTime listed;
  for (const JsonNode& element : node["frames"].elements(1, TrajectorySpec::max_frames, "an array of source frames"))
    listed.frames.push_back(element.integer(0, last));
  return listed;
}

double parse_radius(const JsonNode& node) {
  if (node.value() == "auto") return 0;
  if (!node.value().is_number()) node.refuse("\"auto\" or " + any_radius.text());
  return node.number(any_radius);
}

/// What the single keys cannot know about each other.
void check_together(const JsonNode& root, const TrajectorySpec& spec) {
  const bool has_poses =
      std::holds_alternative<KeyframeMotion>(spec.motion) || std::holds_alternative<CameraMotion>(spec.motion);
  if (spec.frame_of_reference == FrameOfReference::source_world) {
    if (!has_poses) root["frame_of_reference"].complain("source_world goes with keyframes or cameras only");
    if (spec.units == LengthUnit::radius) root["units"].complain("radius does not go with source_world");
  }
  const auto check_count = [&](std::size_t count, const JsonNode& node, std::string_view what) {
    if (spec.frames != 0 && count != 0 && count != static_cast<std::size_t>(spec.frames))
      node.complain(fmt::format("holds {} {}, but /frames is {}; equal counts are wanted", count, what, spec.frames));
  };
  if (const auto* cameras = std::get_if<CameraMotion>(&spec.motion))
    check_count(cameras->cameras.size(), root["cameras"], "cameras");
  if (const auto* listed = std::get_if<ListedTime>(&spec.time)) {
    check_count(listed->frames.size(), root["time"]["frames"], "source frames");
    if (const auto* cameras = std::get_if<CameraMotion>(&spec.motion))
      if (!cameras->cameras.empty() && cameras->cameras.size() != listed->frames.size())
        root["time"]["frames"].complain(
            fmt::format("holds {} source frames, but there are {} cameras; equal counts are wanted",
                        listed->frames.size(), cameras->cameras.size()));
  }
}

std::vector<std::string_view> known_keys() {
  std::vector<std::string_view> keys{"frames", "fps",  "elevation",    "radius", "radius_scale", "frame_of_reference",
                                     "units",  "time", "follow_source"};
  keys.insert(keys.end(), detail::motion_keys.begin(), detail::motion_keys.end());
  return keys;
}

}  // namespace

TrajectorySpec parse_trajectory(std::string_view json, std::string_view name, const std::filesystem::path& folder) {
  TrajectorySpec spec;
  spec.name = name;
  const nlohmann::json parsed = io::parse_json(json, spec.name);
  const JsonNode root(parsed, "", spec.name);
  root.check_keys(known_keys());
  if (root.has("frames")) spec.frames = root["frames"].integer(1, TrajectorySpec::max_frames);
  spec.fps = root.number_or("fps", 0, any_rate);
  spec.elevation = root.number_or("elevation", 0, any_elevation);
  if (root.has("radius")) spec.radius = parse_radius(root["radius"]);
  spec.radius_scale = root.number_or("radius_scale", 1, any_radius_scale);
  if (root.has("frame_of_reference"))
    spec.frame_of_reference =
        static_cast<FrameOfReference>(choice(root["frame_of_reference"], detail::frame_of_reference_names));
  if (root.has("units")) spec.units = static_cast<LengthUnit>(choice(root["units"], detail::unit_names));
  if (root.has("time")) spec.time = parse_time(root["time"]);
  if (root.has("follow_source")) spec.follow_source = root["follow_source"].boolean();
  spec.motion = detail::parse_motion(root, folder);
  check_together(root, spec);
  return spec;
}

TrajectorySpec read_trajectory(const std::filesystem::path& path) {
  if (path.extension() == ".txt") {
    TrajectorySpec spec;
    spec.name = path.string();
    spec.motion = detail::read_orbit_lists(path);
    return spec;
  }
  constexpr std::uintmax_t limit = std::uintmax_t{512} << 20;  // a million cameras with 17 digits per number
  return parse_trajectory(detail::read_text(path, limit), path.string(), path.parent_path());
}

TrajectorySpec trajectory_from_preset(std::string_view preset) {
  if (!is_preset(preset)) {
    std::vector<std::string_view> names;
    for (const PresetInfo& info : presets()) names.push_back(info.name);
    const std::string_view nearest = detail::nearest_name(preset, names);
    fail(ErrorCode::value_invalid, "there is no trajectory preset '{}'{}; one of {} is wanted", preset.substr(0, 60),
         nearest.empty() ? "" : fmt::format(" (did you mean '{}'?)", nearest), detail::joined(names));
  }
  TrajectorySpec spec;
  spec.name = preset;
  spec.motion = PresetMotion{std::string(preset)};
  return spec;
}

}  // namespace uwv
