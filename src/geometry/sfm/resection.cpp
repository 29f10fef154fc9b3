// SPDX-License-Identifier: Apache-2.0
#include "geometry/sfm/resection.h"

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>

namespace uwv::sfm {
namespace {

int inliers_of(const Reconstruction& reconstruction, const std::vector<Track>& tracks,
               const std::vector<std::size_t>& seen, int frame, const Rigid3& pose, double max_error_px) {
  int count = 0;
  for (const std::size_t t : seen) count += reconstruction.error_from(pose, tracks[t], t, frame) < max_error_px ? 1 : 0;
  return count;
}

/// The pose by minimal sets; empty when none is found.
std::optional<Rigid3> ransac_pose(const Reconstruction& reconstruction, const std::vector<Track>& tracks,
                                  const std::vector<std::size_t>& seen, int frame, double max_error_px,
                                  std::uint64_t seed) {
  std::vector<cv::Point3d> points;
  std::vector<cv::Point2d> pixels;
  for (const std::size_t i : drawing_order(seen.size(), seed)) {
    const std::size_t t = seen[i];
    const Eigen::Vector3d& x = *reconstruction.points[t];
    points.emplace_back(x.x(), x.y(), x.z());
    pixels.emplace_back(tracks[t].at(frame).x(), tracks[t].at(frame).y());
  }
  const Intrinsics& lens = reconstruction.lens;
  const cv::Matx33d k(lens.fx, 0, lens.cx, 0, lens.fy, lens.cy, 0, 0, 1);
  cv::Mat turn, shift, inliers;
  const auto threshold = static_cast<float>(2 * max_error_px);
  const bool found = cv::solvePnPRansac(points, pixels, k, cv::noArray(), turn, shift, false, 200, threshold, 0.999,
                                        inliers, cv::SOLVEPNP_EPNP);
  if (!found) return std::nullopt;
  cv::Mat rotation;
  cv::Rodrigues(turn, rotation);
  Rigid3 pose;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) pose.rotation(r, c) = rotation.at<double>(r, c);
    pose.translation[r] = shift.at<double>(r);
  }
  if (!pose.rotation.allFinite() || !pose.translation.allFinite()) return std::nullopt;
  return pose;
}

/// The registered poses nearest in time, before and after.
std::vector<Rigid3> neighbours(const Reconstruction& reconstruction, int frame) {
  const auto& poses = reconstruction.cam_from_world;
  std::vector<Rigid3> out;
  for (const int step : {-1, 1})
    for (int f = frame + step; f >= 0 && f < static_cast<int>(poses.size()); f += step)
      if (poses[static_cast<std::size_t>(f)]) {
        out.push_back(*poses[static_cast<std::size_t>(f)]);
        break;
      }
  return out;
}

}  // namespace

std::optional<Rigid3> find_pose(const Reconstruction& reconstruction, const std::vector<Track>& tracks, int frame,
                                double max_error_px, std::uint64_t seed) {
  constexpr int least = 10;  // tracks that carry a pose
  std::vector<std::size_t> seen;
  for (std::size_t t = 0; t < tracks.size(); ++t)
    if (tracks[t].in(frame) && reconstruction.points[t]) seen.push_back(t);
  const auto total = static_cast<int>(seen.size());
  if (total < least) return std::nullopt;
  const int needed = std::max(least, total * 3 / 10), plenty = total * 7 / 10;
  std::optional<Rigid3> best;
  int agree = -1;
  const auto consider = [&](Rigid3 pose, std::initializer_list<double> gates) {
    for (const double gate : gates) pose = adjusted_camera(reconstruction, tracks, seen, frame, pose, gate);
    const int count = inliers_of(reconstruction, tracks, seen, frame, pose, max_error_px);
    if (count <= agree) return;
    agree = count;
    best = pose;
  };
  // The gates narrow: a neighbour may be tens of pixels off.
  for (const Rigid3& near : neighbours(reconstruction, frame))
    if (agree < plenty) consider(near, {30 * max_error_px, 4 * max_error_px});
  if (agree < plenty)
    if (const auto pose = ransac_pose(reconstruction, tracks, seen, frame, max_error_px, seed))
      consider(*pose, {4 * max_error_px});
  if (agree < needed) return std::nullopt;
  return best;
}

bool resect(Reconstruction& reconstruction, const std::vector<Track>& tracks, int frame, double max_error_px,
            std::uint64_t seed) {
  const std::optional<Rigid3> pose = find_pose(reconstruction, tracks, frame, max_error_px, seed);
  reconstruction.cam_from_world[static_cast<std::size_t>(frame)] = pose;
  return pose.has_value();
}

}  // namespace uwv::sfm
