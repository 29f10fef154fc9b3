// SPDX-License-Identifier: Apache-2.0
#include "geometry/sfm/triangulation.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace uwv::sfm {
namespace {

struct Ray {
  int frame;
  Eigen::Vector3d origin, direction;  // world, unit direction
};

std::vector<Ray> rays_of(const Reconstruction& reconstruction, const Track& track) {
  std::vector<Ray> out;
  for (int f = track.first; f < track.end(); ++f) {
    const auto& pose = reconstruction.cam_from_world[static_cast<std::size_t>(f)];
    if (!pose) continue;
    const Rigid3 world_from_cam = pose->inverse();
    const Eigen::Vector3d ray = world_from_cam.rotation * unproject(reconstruction.lens, track.at(f), 1);
    out.push_back({f, world_from_cam.translation, ray.normalized()});
  }
  return out;
}

/// Least squares of distances to the rays, each divided by the point's distance: angles, as pixels measure them.
Eigen::Vector3d nearest_point(const std::vector<Ray>& rays) {
  Eigen::Vector3d x = Eigen::Vector3d::Zero();
  std::vector<double> weights(rays.size(), 1);
  for (int round = 0; round < 3; ++round) {
    Eigen::Matrix3d a = Eigen::Matrix3d::Zero();
    Eigen::Vector3d b = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const Eigen::Matrix3d across =
          weights[i] * (Eigen::Matrix3d::Identity() - rays[i].direction * rays[i].direction.transpose());
      a += across;
      b += across * rays[i].origin;
    }
    x = a.ldlt().solve(b);
    for (std::size_t i = 0; i < rays.size(); ++i) weights[i] = 1 / std::max(1e-12, (x - rays[i].origin).squaredNorm());
  }
  return x;
}

}  // namespace

std::optional<Eigen::Vector3d> triangulate(const Reconstruction& reconstruction, const Track& track, double max_error,
                                           double min_angle) {
  const std::vector<Ray> rays = rays_of(reconstruction, track);
  if (rays.size() < 2) return std::nullopt;
  double least_cosine = 1;
  for (const Ray& a : rays) {
    least_cosine = std::min(least_cosine, a.direction.dot(rays.front().direction));
    least_cosine = std::min(least_cosine, a.direction.dot(rays.back().direction));
  }
  if (least_cosine > std::cos(min_angle)) return std::nullopt;
  const Eigen::Vector3d x = nearest_point(rays);
  if (!x.allFinite()) return std::nullopt;
  std::size_t agree = 0;
  for (const Ray& ray : rays) {
    Eigen::Vector2d pixel;
    if (!project(reconstruction.lens, *reconstruction.cam_from_world[static_cast<std::size_t>(ray.frame)] * x, pixel))
      return std::nullopt;
    if ((pixel - track.at(ray.frame)).norm() < max_error) ++agree;
  }
  if (agree < 2 || 2 * agree < rays.size()) return std::nullopt;
  return x;
}

int triangulate_all(Reconstruction& reconstruction, const std::vector<Track>& tracks, double max_error,
                    double min_angle) {
  int count = 0;
  for (std::size_t t = 0; t < tracks.size(); ++t) {
    int seen = 0, good = 0;
    for (int f = tracks[t].first; f < tracks[t].end(); ++f) {
      if (!reconstruction.cam_from_world[static_cast<std::size_t>(f)]) continue;
      ++seen;
      if (reconstruction.error(tracks[t], t, f) < max_error) ++good;
    }
    if (good < 2 || 2 * good < seen)
      reconstruction.points[t] = triangulate(reconstruction, tracks[t], max_error, min_angle);
    if (reconstruction.points[t]) ++count;
  }
  return count;
}

}  // namespace uwv::sfm
