// SPDX-License-Identifier: Apache-2.0
#include "geometry/sfm/result.h"

#include <algorithm>
#include <cmath>

#include "geometry/sfm/triangulation.h"

namespace uwv::sfm {
namespace {

Rigid3 between(const Rigid3& a, const Rigid3& b, double share) {
  const Eigen::Quaterniond qa(a.rotation), qb(b.rotation);
  return {qa.slerp(share, qb).toRotationMatrix(), (1 - share) * a.translation + share * b.translation};
}

/// Whether some static point, perhaps at infinity, explains at least half of what the track shows.
bool is_static(const Reconstruction& reconstruction, const Track& track, double max_error_px) {
  if (triangulate(reconstruction, track, max_error_px, 0)) return true;
  int seen = 0, agree = 0;
  std::optional<Eigen::Vector3d> direction;
  for (int f = track.first; f < track.end(); ++f) {
    const auto& pose = reconstruction.cam_from_world[static_cast<std::size_t>(f)];
    if (!pose) continue;
    if (!direction) direction = pose->rotation.transpose() * unproject(reconstruction.lens, track.at(f), 1);
    Eigen::Vector2d pixel;
    ++seen;
    if (project(reconstruction.lens, pose->rotation * *direction, pixel) && (pixel - track.at(f)).norm() < max_error_px)
      ++agree;
  }
  return 2 * agree >= seen;
}

}  // namespace

void fill_cameras(SfmResult& result, const Reconstruction& reconstruction, const Placement& placement) {
  const std::vector<int> measured = reconstruction.registered();
  Camera camera{reconstruction.lens.resized(placement.tracked, placement.full), Rigid3{}, placement.full};
  if (measured.empty()) return;
  const auto n = static_cast<std::size_t>(placement.clip_frames);
  result.cameras.assign(n, camera);
  result.registered.assign(n, 0);
  const Rigid3 world_from_old = *reconstruction.cam_from_world[static_cast<std::size_t>(measured.front())];
  const auto pose_at = [&](int f) {
    return world_from_old * reconstruction.cam_from_world[static_cast<std::size_t>(f)]->inverse();
  };
  for (int f = 0; f < placement.clip_frames; ++f) {
    const int local = f - placement.shot_begin;
    Rigid3& pose = result.cameras[static_cast<std::size_t>(f)].world_from_cam;
    const auto after = std::lower_bound(measured.begin(), measured.end(), local);
    if (after == measured.end()) {
      pose = pose_at(measured.back());
    } else if (*after == local || after == measured.begin()) {
      pose = pose_at(*after);
      result.registered[static_cast<std::size_t>(f)] = *after == local ? 1 : 0;
    } else {
      const int before = *(after - 1);
      pose = between(pose_at(before), pose_at(*after), static_cast<double>(local - before) / (*after - before));
    }
  }
}

void fill_errors(SfmResult& result, const Reconstruction& reconstruction, const std::vector<Track>& tracks,
                 double max_error_px, double scale) {
  double sum = 0;
  long inliers = 0, assessed = 0, moving = 0;
  for (std::size_t t = 0; t < tracks.size(); ++t) {
    int views = 0, good = 0;
    for (int f = tracks[t].first; f < tracks[t].end(); ++f) {
      if (!reconstruction.cam_from_world[static_cast<std::size_t>(f)]) continue;
      ++views;
      const double error = reconstruction.error(tracks[t], t, f);
      if (!(error < max_error_px)) continue;
      sum += error * error;
      ++inliers;
      ++good;
    }
    if (views < 3) continue;
    ++assessed;
    if (2 * good < views && !is_static(reconstruction, tracks[t], 2 * max_error_px)) ++moving;
  }
  result.rms_error_px = inliers > 0 ? scale * std::sqrt(sum / static_cast<double>(inliers)) : 0;
  result.moving_share = assessed > 0 ? static_cast<double>(moving) / static_cast<double>(assessed) : 0;
}

void fill_points(SfmResult& result, const Reconstruction& reconstruction, const std::vector<Track>& tracks,
                 double max_error_px, const Placement& placement) {
  const std::vector<int> measured = reconstruction.registered();
  const Rigid3 world_from_old = *reconstruction.cam_from_world[static_cast<std::size_t>(measured.front())];
  const double scale_x = static_cast<double>(placement.full.width) / placement.tracked.width;
  const double scale_y = static_cast<double>(placement.full.height) / placement.tracked.height;
  std::vector<double> first_depths, depths;
  for (std::size_t t = 0; t < tracks.size(); ++t) {
    if (!reconstruction.points[t]) continue;
    ScenePoint point;
    double sum = 0;
    for (int f = tracks[t].first; f < tracks[t].end(); ++f) {
      const double error = reconstruction.error(tracks[t], t, f);
      if (!(error < max_error_px)) continue;
      sum += error * error;
      point.observations.push_back(
          {f + placement.shot_begin, tracks[t].at(f).cwiseProduct(Eigen::Vector2d(scale_x, scale_y))});
    }
    if (point.observations.size() < 2) continue;
    point.x_in_world = world_from_old * *reconstruction.points[t];
    point.error_px = scale_x * std::sqrt(sum / static_cast<double>(point.observations.size()));
    if (point.observations.front().frame == measured.front() + placement.shot_begin)
      first_depths.push_back(point.x_in_world.z());
    depths.push_back(point.x_in_world.z());
    result.points.push_back(std::move(point));
  }
  const double depth = median(first_depths.empty() ? depths : first_depths);
  if (!(depth > 0)) return;
  for (Camera& camera : result.cameras) camera.world_from_cam.translation /= depth;
  for (ScenePoint& point : result.points) point.x_in_world /= depth;
}

}  // namespace uwv::sfm
