// SPDX-License-Identifier: Apache-2.0
#include "geometry/sfm/resection.h"

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>

namespace uwv::sfm {
namespace {

int inliers_of(const Reconstruction& reconstruction, const std::vector<Track>& tracks,
               const std::vector<std::size_t>& seen, int frame, double max_error_px) {
  int count = 0;
  for (const std::size_t t : seen) count += reconstruction.error(tracks[t], t, frame) < max_error_px ? 1 : 0;
  return count;
}

/// The pose by minimal sets; empty when none is found.
std::optional<Rigid3> ransac_pose(const Reconstruction& reconstruction, const std::vector<Track>& tracks,
                                  const std::vector<std::size_t>& seen, int frame, double max_error_px) {
  std::vector<cv::Point3d> points;
  std::vector<cv::Point2d> pixels;
  for (const std::size_t t : seen) {
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

/// The registered pose nearest in time.
std::optional<Rigid3> neighbour(const Reconstruction& reconstruction, int frame) {
  const int n = static_cast<int>(reconstruction.cam_from_world.size());
  for (int gap = 1; gap < n; ++gap)
    for (const int f : {frame - gap, frame + gap})
      if (f >= 0 && f < n && reconstruction.cam_from_world[static_cast<std::size_t>(f)])
        return reconstruction.cam_from_world[static_cast<std::size_t>(f)];
  return std::nullopt;
}

}  // namespace

bool resect(Reconstruction& reconstruction, const std::vector<Track>& tracks, int frame, double max_error_px,
            int least) {
  std::vector<std::size_t> seen;
  for (std::size_t t = 0; t < tracks.size(); ++t)
    if (tracks[t].in(frame) && reconstruction.points[t]) seen.push_back(t);
  if (static_cast<int>(seen.size()) < least) return false;
  auto& pose = reconstruction.cam_from_world[static_cast<std::size_t>(frame)];
  const int needed = std::max(least, static_cast<int>(seen.size()) * 3 / 10);

  const std::optional<Rigid3> near = neighbour(reconstruction, frame);
  pose = near;
  // The gates narrow: a neighbour may be tens of pixels off.
  for (const double gate : {30 * max_error_px, 4 * max_error_px})
    if (pose) adjust_camera(reconstruction, tracks, frame, gate);
  int agree = pose ? inliers_of(reconstruction, tracks, seen, frame, max_error_px) : 0;
  if (agree < static_cast<int>(seen.size()) * 7 / 10) {
    const std::optional<Rigid3> warm = pose;
    pose = ransac_pose(reconstruction, tracks, seen, frame, max_error_px);
    if (pose) adjust_camera(reconstruction, tracks, frame, 4 * max_error_px);
    const int other = pose ? inliers_of(reconstruction, tracks, seen, frame, max_error_px) : 0;
    if (other < agree) pose = warm;
    agree = std::max(agree, other);
  }
  if (agree >= needed) return true;
  pose.reset();
  return false;
}

}  // namespace uwv::sfm
