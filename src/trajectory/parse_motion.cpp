// SPDX-License-Identifier: Apache-2.0
#include "trajectory/parse_motion.h"

#include <Eigen/Geometry>
#include <fstream>

#include "trajectory/orbit_lists_file.h"
#include "trajectory/spec_keys.h"

namespace uwv::detail {
namespace {

constexpr Range any_zoom{1e-3, 1e3};
constexpr Range any_fov{0, 180, true, true};
constexpr Range any_offset{-1e6, 1e6};  // in radii
constexpr Range any_distance{0, 1e6, true};
constexpr std::size_t most_keyframes = 100'000;

Easing parse_easing(const JsonNode& node) { return *easing_from_string(node.text(easing_names())); }

std::vector<std::string_view> preset_names() {
  std::vector<std::string_view> names;
  for (const PresetInfo& preset : presets()) names.push_back(preset.name);
  return names;
}

PresetMotion parse_preset(const JsonNode& node) {
  const auto names = preset_names();
  if (!node.value().is_object()) return {node.text(names), 1.0};
  node.check_keys({"name", "focal"});
  return {node["name"].text(names), node.number_or("focal", 1, any_zoom)};
}

FreeMove parse_free(const JsonNode& node, double default_d_phi) {
  node.check_keys({"d_phi", "d_theta", "d_r", "x", "y", "z", "focal", "easing", "zoom_twice"});
  FreeMove move;
  move.d_phi = node.number_or("d_phi", default_d_phi, any_angle);
  move.d_theta = node.number_or("d_theta", 0, any_angle);
  move.d_r = node.number_or("d_r", 1, any_distance);
  move.x = node.number_or("x", 0, any_offset);
  move.y = node.number_or("y", 0, any_offset);
  move.z = node.number_or("z", 0, any_offset);
  move.focal = node.number_or("focal", 1, any_zoom);
  if (node.has("easing")) move.easing = parse_easing(node["easing"]);
  if (node.has("zoom_twice")) move.zoom_twice = node["zoom_twice"].boolean();
  return move;
}

OrbitLists parse_lists(const JsonNode& node, const std::filesystem::path& folder) {
  if (node.value().is_string()) return read_orbit_lists(folder / node.text());
  node.check_keys({"phi", "theta", "r"});
  OrbitLists lists;
  if (node.has("phi")) lists.phi = node["phi"].numbers(1, most_list_values, any_angle);
  if (node.has("theta")) lists.theta = node["theta"].numbers(1, most_list_values, any_angle);
  if (node.has("r")) lists.r = node["r"].numbers(1, most_list_values, list_distances);
  return lists;
}

/// A rotation as 9 numbers row by row or a quaternion w, x, y, z.
Eigen::Matrix3d parse_rotation(const JsonNode& node) {
  if (node.value().is_array() && node.value().size() == 4) {
    const auto q = node.numbers(4, 4, any_length);
    const Eigen::Quaterniond quaternion(q[0], q[1], q[2], q[3]);
    if (!(std::abs(quaternion.norm() - 1) < 1e-3)) node.complain("a quaternion w, x, y, z of length 1 is wanted");
    return quaternion.normalized().toRotationMatrix();
  }
  const auto values = node.numbers(9, 9, any_length);
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix.topLeftCorner<3, 3>() = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(values.data());
  return Rigid3::from_matrix(matrix, node.place()).rotation;
}

Rigid3 parse_pose(const JsonNode& node) { return Rigid3::from_matrix(node.matrix4(), node.place()); }

/// Complains when more than one of `keys` is present.
void check_at_most_one(const JsonNode& node, std::initializer_list<std::string_view> keys) {
  const auto found = node.present(std::span<const std::string_view>(keys.begin(), keys.size()));
  if (found.size() > 1) node.complain(fmt::format("has both '{}' and '{}'; one of them is wanted", found[0], found[1]));
}

void parse_place(const JsonNode& node, Keyframe& key) {
  if (node.has("world_from_cam")) {
    for (const std::string_view other : {"position", "phi", "theta", "r", "look_at", "rotation"})
      if (node.has(other)) node[other].complain("does not go with world_from_cam, which says it all");
    key.place = parse_pose(node["world_from_cam"]);
  } else if (node.has("position")) {
    for (const std::string_view other : {"phi", "theta", "r"})
      if (node.has(other)) node[other].complain("does not go with position");
    key.place = node["position"].point();
  } else {
    key.place = SpherePlace{node.number_or("phi", 0, any_angle), node.number_or("theta", 0, any_angle),
                            node.number_or("r", 1, any_distance)};
  }
}

void parse_aim(const JsonNode& node, Keyframe& key) {
  check_at_most_one(node, {"look_at", "rotation"});
  if (node.has("rotation")) key.aim = parse_rotation(node["rotation"]);
  if (!node.has("look_at")) return;
  const JsonNode target = node["look_at"];
  if (target.value().is_array())
    key.aim = target.point();
  else if (target.value() == "subject")
    key.aim = SubjectPoint{};
  else
    target.refuse("\"subject\" or a point [x, y, z]");
}

Keyframe parse_keyframe(const JsonNode& node) {
  node.check_keys({"at", "frame", "position", "world_from_cam", "phi", "theta", "r", "look_at", "rotation", "roll",
                   "focal", "fov", "easing"});
  check_at_most_one(node, {"at", "frame"});
  check_at_most_one(node, {"focal", "fov"});
  Keyframe key;
  if (node.has("at")) key.at = node["at"].number({0, 1});
  if (node.has("frame")) key.frame = node["frame"].integer(0, TrajectorySpec::max_frames - 1);
  parse_place(node, key);
  parse_aim(node, key);
  key.roll = node.number_or("roll", 0, any_angle);
  if (node.has("focal")) key.focal = node["focal"].number(any_zoom);
  if (node.has("fov")) key.fov = node["fov"].number(any_fov);
  if (node.has("easing")) key.easing = parse_easing(node["easing"]);
  return key;
}

KeyframeMotion parse_keyframes(const JsonNode& node) {
  KeyframeMotion motion;
  const auto nodes = node.elements(1, most_keyframes, fmt::format("an array of 1 to {} keyframes", most_keyframes));
  for (const JsonNode& element : nodes) motion.keyframes.push_back(parse_keyframe(element));
  const auto timed = [](const Keyframe& key) { return key.at.has_value() || key.frame.has_value(); };
  for (std::size_t i = 1; i < nodes.size(); ++i) {
    const Keyframe& key = motion.keyframes[i];
    const Keyframe& before = motion.keyframes[i - 1];
    if (timed(key) != timed(before)) nodes[i].complain("'at' or 'frame' is wanted in all keyframes or in none");
    if (key.at && before.at && *key.at <= *before.at)
      nodes[i]["at"].refuse(fmt::format("a value after the previous keyframe's {:g}", *before.at));
    if (key.frame && before.frame && *key.frame <= *before.frame)
      nodes[i]["frame"].refuse(fmt::format("a value after the previous keyframe's {}", *before.frame));
  }
  return motion;
}

ExplicitCamera parse_camera(const JsonNode& node) {
  constexpr std::array<std::string_view, 4> intrinsics{"fx", "fy", "cx", "cy"};
  constexpr Range any_focal{1e-6, 1e12};
  node.check_keys({"world_from_cam", "fx", "fy", "cx", "cy", "fov", "width", "height"});
  ExplicitCamera camera;
  camera.world_from_cam = parse_pose(node["world_from_cam"]);
  if (node.has("width") || node.has("height"))
    camera.size = Size{static_cast<int>(node["width"].integer(1, 1'000'000)),
                       static_cast<int>(node["height"].integer(1, 1'000'000))};
  const auto given = node.present(intrinsics);
  if (node.has("fov")) {
    if (!given.empty()) node["fov"].complain(fmt::format("does not go with '{}'", given.front()));
    camera.fov = node["fov"].number(any_fov);
  } else if (!given.empty()) {
    camera.intrinsics = Intrinsics{node["fx"].number(any_focal), node["fy"].number(any_focal),
                                   node["cx"].number({-1e9, 1e9}), node["cy"].number({-1e9, 1e9})};
  }
  return camera;
}

CameraMotion parse_cameras(const JsonNode& node, const std::filesystem::path& folder) {
  CameraMotion motion;
  if (node.value().is_string()) {
    const std::string file = node.text();
    if (file.empty()) node.refuse("the path of a cameras file");
    motion.cameras_file = (folder / file).string();
    return motion;
  }
  constexpr auto most = static_cast<std::size_t>(TrajectorySpec::max_frames);
  for (const JsonNode& element : node.elements(1, most, fmt::format("an array of 1 to {} cameras, or a file", most)))
    motion.cameras.push_back(parse_camera(element));
  return motion;
}

}  // namespace

Motion parse_motion(const JsonNode& root, const std::filesystem::path& folder) {
  const auto found = root.present(motion_keys);
  if (found.empty()) root.complain(fmt::format("one of the keys {} is wanted", joined(motion_keys)));
  if (found.size() > 1)
    root.complain(
        fmt::format("has both '{}' and '{}'; exactly one of {} is wanted", found[0], found[1], joined(motion_keys)));
  const JsonNode node = root[found.front()];
  if (found.front() == "preset") return parse_preset(node);
  if (found.front() == "orbit") return parse_free(node, -360);
  if (found.front() == "free") return parse_free(node, 0);
  if (found.front() == "txt") return parse_lists(node, folder);
  if (found.front() == "keyframes") return parse_keyframes(node);
  return parse_cameras(node, folder);
}

}  // namespace uwv::detail
