// SPDX-License-Identifier: Apache-2.0
#include "geometry/mvs/view_selection.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace uwv::mvs {
namespace {

constexpr std::size_t enough_points = 12;   // Below, percentiles of one frame's points mean nothing.
constexpr std::size_t sampled_points = 96;  // A mean over these is steady; all of them only take time.
constexpr double degree = std::numbers::pi / 180;

/// Inverse depths of the points inside the picture.
void append_inverse_depths(const SparseScene& scene, std::size_t frame, std::vector<double>& out) {
  const Camera& camera = scene.cameras[frame];
  const Rigid3 cam_from_world = camera.cam_from_world();
  for (const Eigen::Vector3d& point : scene.points) {
    const Eigen::Vector3d x = cam_from_world * point;
    Eigen::Vector2d pixel;
    if (!project(camera.intrinsics, x, pixel) || !std::isfinite(x.z())) continue;
    if (pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() <= camera.size.width && pixel.y() <= camera.size.height)
      out.push_back(1 / x.z());
  }
}

double percentile(std::vector<double>& values, double share) {
  const auto index = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1) + 0.5);
  std::nth_element(values.begin(), values.begin() + index, values.end());
  return values[static_cast<std::size_t>(index)];
}

/// Points for comparing views with a frame: those it sees, thinned; a grid of points at depth 1 when it sees none.
std::vector<Eigen::Vector3d> sample_of(const SparseScene& scene, std::size_t frame) {
  const Camera& camera = scene.cameras[frame];
  const Rigid3 cam_from_world = camera.cam_from_world();
  std::vector<Eigen::Vector3d> seen;
  for (const Eigen::Vector3d& point : scene.points) {
    const Eigen::Vector3d x = cam_from_world * point;
    Eigen::Vector2d pixel;
    if (project(camera.intrinsics, x, pixel) && pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() <= camera.size.width &&
        pixel.y() <= camera.size.height)
      seen.push_back(point);
  }
  if (seen.size() > sampled_points) {
    for (std::size_t i = 0; i < sampled_points; ++i) seen[i] = seen[i * seen.size() / sampled_points];
    seen.resize(sampled_points);
  }
  if (!seen.empty()) return seen;
  for (const double v : {0.2, 0.5, 0.8}) {
    for (const double u : {0.2, 0.5, 0.8}) {
      const Eigen::Vector2d pixel(u * camera.size.width, v * camera.size.height);
      seen.push_back(camera.world_from_cam * unproject(camera.intrinsics, pixel, 1.0));
    }
  }
  return seen;
}

/// 1 between 2 and 10 degrees with its best at the lower middle, less outside: below, depth is imprecise; above,
/// surfaces look different and hide each other.
double worth_of_angle(double angle) {
  const double best = 4 * degree;
  const double spread = angle < best ? 1.7 * degree : 5 * degree;
  const double t = (angle - best) / spread;
  return std::exp(-0.5 * t * t);
}

struct Candidate {
  int frame;
  double worth;
};

/// How good a frame is as a neighbour, by overlap and angle; 0 = useless.
double worth_of_view(const SparseScene& scene, const std::vector<Eigen::Vector3d>& sample, std::size_t frame,
                     std::size_t other) {
  const Camera& camera = scene.cameras[other];
  const Rigid3 cam_from_world = camera.cam_from_world();
  double sum = 0;
  for (const Eigen::Vector3d& point : sample) {
    Eigen::Vector2d pixel;
    if (!project(camera.intrinsics, cam_from_world * point, pixel)) continue;
    if (pixel.x() < 0 || pixel.y() < 0 || pixel.x() > camera.size.width || pixel.y() > camera.size.height) continue;
    const Eigen::Vector3d a = point - scene.cameras[frame].world_from_cam.translation;
    const Eigen::Vector3d b = point - camera.world_from_cam.translation;
    const double angle = std::atan2(a.cross(b).norm(), a.dot(b));
    // Less than this moves nothing by a tenth of a pixel in any usual picture.
    if (angle > 0.02 * degree) sum += worth_of_angle(angle) + 1e-3;
  }
  return sum / static_cast<double>(sample.size());
}

double median_flow(const SparseScene& scene, std::size_t a, std::size_t b) {
  const Rigid3 b_from_a = target_from_source(scene.cameras[b], scene.cameras[a]);
  std::vector<double> flows;
  for (const Eigen::Vector3d& point : sample_of(scene, a)) {
    const Eigen::Vector3d x = scene.cameras[a].cam_from_world() * point;
    Eigen::Vector2d from;
    Eigen::Vector2d to;
    if (project(scene.cameras[a].intrinsics, x, from) && project(scene.cameras[b].intrinsics, b_from_a * x, to))
      flows.push_back((to - from).norm());
  }
  return flows.empty() ? std::numeric_limits<double>::infinity() : percentile(flows, 0.5);
}

}  // namespace

DepthRange depth_range(const SparseScene& scene, std::size_t frame) {
  std::vector<double> inverse;
  append_inverse_depths(scene, frame, inverse);
  if (inverse.size() < enough_points)
    for (std::size_t i = 0; i < scene.cameras.size(); ++i) append_inverse_depths(scene, i, inverse);
  if (inverse.empty()) {
    // The normalised depth 1 is then a guess from the cameras' distances; look wide around it.
    return {0.05F, 4.0F};
  }
  // A point on the camera or at infinity is no bound.
  const double farthest = std::clamp(percentile(inverse, 0.02), 1e-6, 1e6);
  const double nearest = std::clamp(percentile(inverse, 0.98), 1e-6, 1e6);
  const double margin = 0.15 * (nearest - farthest);
  return {static_cast<float>(std::max(0.6 * farthest, farthest / 1.1 - margin)),
          static_cast<float>(std::min(1.6 * nearest, nearest * 1.1 + margin))};
}

std::vector<int> choose_neighbours(const SparseScene& scene, std::size_t frame, int count) {
  constexpr std::size_t reach = 60;  // Farther away in time, pictures seldom overlap.
  const std::vector<Eigen::Vector3d> sample = sample_of(scene, frame);
  std::vector<Candidate> candidates;
  for (std::size_t other = frame > reach ? frame - reach : 0; other < std::min(scene.cameras.size(), frame + reach + 1);
       ++other) {
    if (other == frame) continue;
    const double worth = worth_of_view(scene, sample, frame, other);
    if (worth > 0) candidates.push_back({static_cast<int>(other), worth});
  }
  std::vector<int> chosen;
  while (!candidates.empty() && static_cast<int>(chosen.size()) < count) {
    const auto worse = [](const Candidate& a, const Candidate& b) {
      return a.worth < b.worth || (a.worth == b.worth && a.frame > b.frame);
    };
    const auto best = std::max_element(candidates.begin(), candidates.end(), worse);
    const int taken = best->frame;
    chosen.push_back(taken);
    candidates.erase(best);
    // A view from where another one stands adds little: occlusion is helped by views from other sides.
    const Eigen::Vector3d& centre = scene.cameras[static_cast<std::size_t>(taken)].world_from_cam.translation;
    for (Candidate& candidate : candidates) {
      const double distance =
          (scene.cameras[static_cast<std::size_t>(candidate.frame)].world_from_cam.translation - centre).norm();
      candidate.worth *= std::min(1.0, 0.1 + distance / (2.5 * degree));
    }
  }
  return chosen;
}

int choose_key_stride(const SparseScene& scene) {
  constexpr int longest = 4;
  constexpr double max_flow_share = 0.02;
  for (int stride = longest; stride > 1; --stride) {
    std::vector<double> flows;
    for (std::size_t i = 0; i + static_cast<std::size_t>(stride) < scene.cameras.size();
         i += static_cast<std::size_t>(stride))
      flows.push_back(median_flow(scene, i, i + static_cast<std::size_t>(stride)));
    if (!flows.empty() && percentile(flows, 0.8) <= max_flow_share * scene.cameras.front().size.width) return stride;
  }
  return 1;
}

}  // namespace uwv::mvs
