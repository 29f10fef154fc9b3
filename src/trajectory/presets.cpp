// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>

#include "uwv/trajectory/orbit.h"

namespace uwv {
namespace {

struct Preset {
  PresetInfo info;
  FreeMove move;
  int swing = 0;  ///< 1 or 2 for the table-driven ones, whose `move` is not used.
};

// The first eight are the official ones; the plain words stay small enough for a model to complete what opens up.
const std::array<Preset, 19>& table() {
  static const std::array<Preset, 19> presets{{
      {{"free1", "up and left around the subject, moving away"}, {.d_phi = 45, .d_theta = -15, .d_r = 1.6}},
      {{"free2", "far to the right around the subject"}, {.d_phi = -60, .x = -0.05}},
      {{"free3", "away from the subject, a little to the left"}, {.d_r = 1.7, .x = -0.25}},
      {{"free4", "up and right around the subject, coming closer"}, {.d_phi = -60, .d_theta = -15, .d_r = 0.75}},
      {{"free5", "up and right around the subject to behind it, moving away"},
       {.d_phi = -120, .d_theta = -15, .d_r = 1.6}},
      {{"orbit", "a full circle to the right around the subject"}, {.d_phi = -360}},
      {{"swing1", "a loop to the right and up, moving away a little"}, {}, 1},
      {{"swing2", "a loop to the left and up, coming closer and back"}, {}, 2},
      {{"still", "the camera of the first frame, not moving"}, {}},
      {{"left", "30 degrees to the left around the subject"}, {.d_phi = 30}},
      {{"right", "30 degrees to the right around the subject"}, {.d_phi = -30}},
      {{"up", "20 degrees up around the subject, looking down on it"}, {.d_theta = -20}},
      {{"down", "15 degrees down around the subject, looking up at it"}, {.d_theta = 15}},
      {{"forward", "to 70 % of the distance"}, {.d_r = 0.7}},
      {{"backward", "to 140 % of the distance"}, {.d_r = 1.4}},
      {{"truck_left", "sideways to the left by a quarter of the distance, without turning"}, {.x = -0.25}},
      {{"truck_right", "sideways to the right by a quarter of the distance, without turning"}, {.x = 0.25}},
      {{"zoom_in", "focal length times 1.5, without moving"}, {.focal = 1.5}},
      {{"zoom_out", "focal length times 0.7, without moving"}, {.focal = 0.7}},
  }};
  return presets;
}

const Preset* find(std::string_view name) {
  const auto found = std::find_if(table().begin(), table().end(), [&](const Preset& p) { return p.info.name == name; });
  return found == table().end() ? nullptr : &*found;
}

}  // namespace

std::span<const PresetInfo> presets() {
  static const std::vector<PresetInfo> infos = [] {
    std::vector<PresetInfo> list;
    for (const Preset& preset : table()) list.push_back(preset.info);
    return list;
  }();
  return infos;
}

bool is_preset(std::string_view name) { return find(name) != nullptr; }

CameraPath preset_path(std::string_view name, double focal, const Rigid3& start, double offset_radius, long frames) {
  const Preset* preset = find(name);
  require(preset != nullptr, "there is no preset '{}'", name);
  if (preset->swing != 0) return swing_path(preset->swing, focal, start, frames);
  FreeMove move = preset->move;
  move.focal *= focal;
  return free_path(move, start, offset_radius, frames);
}

}  // namespace uwv
