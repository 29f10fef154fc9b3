// SPDX-License-Identifier: Apache-2.0
#include "bench/dungeon_clip.h"

#include <cmath>
#include <map>
#include <numbers>

namespace uwv::bench {
namespace {

using Eigen::Vector3d;

constexpr double degree = std::numbers::pi / 180;
constexpr double camera_z = -1.2;  // where its way begins

/// Shortest wave of the clouds: 7 pixels of an 832 pixels wide picture 6 units away, enough not to flicker.
constexpr double cloud_period = 0.06;

/// Models have y up and look along z; the world has y down and the figure shall look at the camera when not turned.
Rigid3 standing(const Vector3d& x_in_world, double yaw) {
  const Eigen::AngleAxisd upside_down(std::numbers::pi, Vector3d::UnitX()), turn(yaw, Vector3d::UnitY());
  return {(upside_down * turn).toRotationMatrix(), x_in_world};
}

class Hall {
 public:
  Hall(std::string models, double texture) : models_(std::move(models)), texture_(texture) {}

  MeshInstance& put(const std::string& piece, const Vector3d& x_in_world, double yaw_degrees) {
    MeshInstance instance;
    instance.name = piece;
    instance.model = model(models_ + "/kaykit_dungeon_CC0/gltf/" + piece + ".gltf.glb", {});
    return add(std::move(instance), standing(x_in_world, yaw_degrees * degree));
  }

  MeshInstance& put_figure() {
    MeshInstance instance;
    instance.name = "Knight";
    instance.model = model(models_ + "/kaykit_adventurers_CC0/Knight.glb",
                           {"1H_Sword_Offhand", "Badge_Shield", "Rectangle_Shield", "Spike_Shield", "2H_Sword"});
    instance.scale = 0.75;
    return add(std::move(instance), {});
  }

  MeshScene take() { return {std::move(instances_), {0.35F, 0.37F, 0.4F}}; }
  int count() const { return static_cast<int>(instances_.size()); }

 private:
  MeshInstance& add(MeshInstance instance, const Rigid3& world_from_model) {
    instance.world_from_model = world_from_model;
    // Other seeds for each, or equal pieces would be taken for each other.
    const auto seed = 100 + 2 * static_cast<std::uint64_t>(count());
    const double fine = cloud_period / instance.scale, coarse = 2.7 * fine;
    instance.details = {Texture::noise({0.5F, 0.5F, 0.5F}, fine, seed),
                        Texture::noise({0.5F, 0.5F, 0.5F}, coarse, seed + 1)};
    instance.detail_strength = texture_;
    instances_.push_back(std::move(instance));
    return instances_.back();
  }

  const MeshModel& model(const std::string& path, const std::vector<std::string>& hidden) {
    const auto found = read_.find(path);
    if (found != read_.end()) return found->second;
    MeshModelOptions options;
    options.hidden = hidden;
    return read_.emplace(path, MeshModel::read(path, options)).first->second;
  }

  std::string models_;
  double texture_;
  std::map<std::string, MeshModel> read_;
  std::vector<MeshInstance> instances_;
};

void build_walls(Hall& hall) {
  const char* back[] = {"wall_cracked", "wall_arched", "wall_window_closed"};
  for (int i = 0; i < 3; ++i) {
    const double across = 4.0 * (i - 1), along = 4.0 * i;
    for (int k = 0; k < 3; ++k) hall.put("floor_tile_large", {across, 0, 4.0 * k}, 90 * ((i + 2 * k) % 4));
    hall.put(back[i], {across, 0, 10}, 0);
    hall.put("wall", {-6, 0, along}, 90);
    hall.put("wall", {6, 0, along}, 90);
    for (const double height : {-4.0, -8.0}) {
      hall.put("wall", {across, height, 10}, 0);
      hall.put("wall", {-6, height, along}, 90);
      hall.put("wall", {6, height, along}, 90);
    }
  }
}

void furnish(Hall& hall) {
  hall.put("pillar", {-4.6, 0, 8.6}, 0);
  hall.put("pillar", {4.6, 0, 8.6}, 0);
  hall.put("barrel_large", {-3.2, 0, 7.6}, 20);
  hall.put("barrel_small_stack", {-4.0, 0, 5.6}, 70);
  hall.put("crates_stacked", {3.3, 0, 7.4}, 15);
  hall.put("box_large", {2.4, 0, 5.4}, 35);
  hall.put("box_small", {2.3, -1.5, 5.5}, 10);
  hall.put("keg", {4.4, 0, 4.8}, -60);
  hall.put("table_medium", {0.2, 0, 7.6}, 10);
  hall.put("candle_triple", {0.3, -1, 7.5}, 0);
  hall.put("trunk_medium_A", {-1.7, 0, 8.3}, -15);
  hall.put("trunk_small_B", {-0.9, 0, 5.0}, 50);
  hall.put("stool", {-2.0, 0, 5.4}, 0);
}

/// Walks across the picture from left to right.
void animate(MeshInstance& figure, double distance) {
  figure.animation = "Walking_A";
  constexpr double speed = 1.0;  // units a second: the animation's own stride at this scale
  figure.motion = [distance](double time) {
    return standing({-0.6 * distance + speed * time, 0, camera_z + distance}, 90 * degree);
  };
}

Rigid3 looking_at(const Vector3d& from, const Vector3d& at, double roll) {
  const Vector3d forward = (at - from).normalized();
  const Vector3d right = Vector3d::UnitY().cross(forward).normalized();
  Rigid3 world_from_cam;
  world_from_cam.rotation << right, forward.cross(right), forward;
  world_from_cam.rotation = world_from_cam.rotation * Eigen::AngleAxisd(roll, Vector3d::UnitZ()).toRotationMatrix();
  world_from_cam.translation = from;
  return world_from_cam;
}

/// Sways as a hand does: slow waves whose periods (in seconds) share no common multiple, about 1 in size.
double sway(double time, double period, double phase) {
  return 0.6 * std::sin(2 * std::numbers::pi * time / period + phase) +
         0.4 * std::sin(2 * std::numbers::pi * time / (0.37 * period) + 2 * phase);
}

/// A step to the side and a little forwards in an arc, eyes on the middle of the hall.
Rigid3 camera_at(double share, double time, double travel) {
  const double side = -1.4 + 2.8 * share;
  const Vector3d step(side + 0.03 * sway(time, 1.7, 0.3), 0.03 * sway(time, 1.1, 1.1),
                      0.9 * share + 0.25 * std::sin(std::numbers::pi * share) + 0.02 * sway(time, 2.3, 2.0));
  const Vector3d from = Vector3d(0, -1.7, camera_z) + travel * step;
  const Vector3d at(-0.3 + 0.5 * share + 0.06 * sway(time, 1.3, 0.7), -1.1 + 0.05 * sway(time, 1.9, 2.6), 6.5);
  return looking_at(from, at, 0.4 * degree * sway(time, 1.5, 1.9));
}

}  // namespace

void DungeonOptions::check() const {
  require(frames >= 1, "frames {} is below 1", frames);
  require(texture >= 0 && texture <= 1, "texture {} is outside 0..1", texture);
  require(travel >= 0 && travel <= 3, "travel {} is outside 0..3", travel);
  require(figure_distance >= 1 && figure_distance <= 9, "figure_distance {} is outside 1..9", figure_distance);
}

DungeonClip dungeon_clip(const std::string& models, Size size, const DungeonOptions& options) {
  options.check();
  Hall hall(models, options.texture);
  DungeonClip clip;
  build_walls(hall);
  furnish(hall);
  if (options.figure) {
    clip.figure = hall.count();
    animate(hall.put_figure(), options.figure_distance);
  }
  clip.scene = hall.take();
  for (int i = 0; i < options.frames; ++i) {
    const double share = options.frames > 1 ? static_cast<double>(i) / (options.frames - 1) : 0;
    clip.cameras.push_back(
        {Intrinsics::from_fov_x(62 * degree, size), camera_at(share, i / clip.fps, options.travel), size});
  }
  return clip;
}

SyntheticFrame render_frame(const DungeonClip& clip, int frame, ThreadPool& pool) {
  constexpr int rays = 2;  // a side
  return render(clip.scene, clip.cameras.at(static_cast<std::size_t>(frame)), frame / clip.fps, pool, rays);
}

TrueClip render_clip(const DungeonClip& clip, const std::string& name, ThreadPool& pool) {
  TrueClip out;
  out.name = name;
  out.cameras = clip.cameras;
  for (int i = 0; i < static_cast<int>(clip.cameras.size()); ++i) {
    SyntheticFrame frame = render_frame(clip, i, pool);
    out.frames.push_back(std::move(frame.colour));
    out.depths.push_back(std::move(frame.depth));
    if (clip.figure < 0) continue;
    ValidityMask at_rest(out.depths.back().size(), 1);
    for (std::size_t p = 0; p < at_rest.pixels().size(); ++p)
      at_rest.pixels()[p] = frame.object.pixels()[p] != clip.figure;
    out.static_pixels.push_back(std::move(at_rest));
  }
  return out;
}

}  // namespace uwv::bench
