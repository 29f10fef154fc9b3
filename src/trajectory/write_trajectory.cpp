// SPDX-License-Identifier: Apache-2.0
#include <nlohmann/json.hpp>

#include "trajectory/spec_keys.h"
#include "uwv/trajectory/trajectory_spec.h"

namespace uwv {
namespace {

using nlohmann::ordered_json;

template <class Matrix>
ordered_json row_by_row(const Matrix& matrix) {
  ordered_json values = ordered_json::array();
  for (Eigen::Index row = 0; row < matrix.rows(); ++row)
    for (Eigen::Index column = 0; column < matrix.cols(); ++column) values.push_back(matrix(row, column));
  return values;
}

void write(ordered_json& root, const PresetMotion& motion) {
  if (motion.focal == 1)
    root["preset"] = motion.name;
  else
    root["preset"] = {{"name", motion.name}, {"focal", motion.focal}};
}

void write(ordered_json& root, const FreeMove& move) {
  root["free"] = {{"d_phi", move.d_phi},
                  {"d_theta", move.d_theta},
                  {"d_r", move.d_r},
                  {"x", move.x},
                  {"y", move.y},
                  {"z", move.z},
                  {"focal", move.focal},
                  {"easing", to_string(move.easing)},
                  {"zoom_twice", move.zoom_twice}};
}

void write(ordered_json& root, const OrbitLists& lists) {
  root["txt"] = {{"phi", lists.phi}, {"theta", lists.theta}, {"r", lists.r}};
}

ordered_json keyframe_json(const Keyframe& key) {
  ordered_json node = ordered_json::object();
  if (key.at) node["at"] = *key.at;
  if (key.frame) node["frame"] = *key.frame;
  if (const auto* sphere = std::get_if<SpherePlace>(&key.place)) {
    node["phi"] = sphere->phi;
    node["theta"] = sphere->theta;
    node["r"] = sphere->r;
  } else if (const auto* position = std::get_if<Eigen::Vector3d>(&key.place)) {
    node["position"] = row_by_row(*position);
  } else {
    node["world_from_cam"] = row_by_row(std::get<Rigid3>(key.place).matrix());
  }
  if (std::holds_alternative<SubjectPoint>(key.aim)) node["look_at"] = "subject";
  if (const auto* point = std::get_if<Eigen::Vector3d>(&key.aim)) node["look_at"] = row_by_row(*point);
  if (const auto* rotation = std::get_if<Eigen::Matrix3d>(&key.aim)) node["rotation"] = row_by_row(*rotation);
  if (key.roll != 0) node["roll"] = key.roll;
  if (key.focal) node["focal"] = *key.focal;
  if (key.fov) node["fov"] = *key.fov;
  if (key.easing != Easing::linear) node["easing"] = to_string(key.easing);
  return node;
}

void write(ordered_json& root, const KeyframeMotion& motion) {
  ordered_json& keys = root["keyframes"] = ordered_json::array();
  for (const Keyframe& key : motion.keyframes) keys.push_back(keyframe_json(key));
}

ordered_json camera_json(const ExplicitCamera& camera) {
  ordered_json node{{"world_from_cam", row_by_row(camera.world_from_cam.matrix())}};
  if (const auto& k = camera.intrinsics) {
    node["fx"] = k->fx;
    node["fy"] = k->fy;
    node["cx"] = k->cx;
    node["cy"] = k->cy;
  }
  if (camera.fov) node["fov"] = *camera.fov;
  if (camera.size) {
    node["width"] = camera.size->width;
    node["height"] = camera.size->height;
  }
  return node;
}

void write(ordered_json& root, const CameraMotion& motion) {
  if (motion.cameras.empty()) {
    root["cameras"] = motion.cameras_file;
    return;
  }
  ordered_json& cameras = root["cameras"] = ordered_json::array();
  for (const ExplicitCamera& camera : motion.cameras) cameras.push_back(camera_json(camera));
}

ordered_json time_json(const TimeControl& time) {
  if (const auto* freeze = std::get_if<FreezeTime>(&time)) return {{"freeze", freeze->frame}};
  if (const auto* listed = std::get_if<ListedTime>(&time)) return {{"frames", listed->frames}};
  if (const auto* span = std::get_if<SpanTime>(&time)) return {{"from", span->from}, {"to", span->to}};
  return "follow";
}

}  // namespace

std::string to_json(const TrajectorySpec& spec) {
  ordered_json root = ordered_json::object();
  if (spec.frames != 0) root["frames"] = spec.frames;
  if (spec.fps != 0) root["fps"] = spec.fps;
  root["elevation"] = spec.elevation;
  if (spec.radius == 0)
    root["radius"] = "auto";
  else
    root["radius"] = spec.radius;
  root["radius_scale"] = spec.radius_scale;
  std::visit([&](const auto& motion) { write(root, motion); }, spec.motion);
  root["frame_of_reference"] = detail::frame_of_reference_names[static_cast<std::size_t>(spec.frame_of_reference)];
  root["units"] = detail::unit_names[static_cast<std::size_t>(spec.units)];
  root["time"] = time_json(spec.time);
  root["follow_source"] = spec.follow_source;
  return root.dump(2) + "\n";
}

}  // namespace uwv
