// SPDX-License-Identifier: Apache-2.0
#include "geometry/sfm/reconstruction.h"

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>

#include "geometry/sfm/two_view.h"

namespace uwv::sfm {
namespace {

constexpr double key_shift = 0.04;            // of the picture's width: large against noise, small against overlap
constexpr std::size_t max_keys = 40;
constexpr std::size_t enough_for_pose = 15;
constexpr double start_angle = 0.07;          // 4 degrees: what start pairs aim at
constexpr double min_point_angle = 0.01;      // rays closer than 0.6 degrees place a point too loosely to resect by

class Builder {
 public:
  Builder(const std::vector<Track>& tracks, const SfmOptions& options, int threads)
      : tracks_(tracks), options_(options), threads_(threads) {}

  Model model;

  void begin(const Intrinsics& intrinsics) {
    model = {};
    model.intrinsics = intrinsics;
    model.points.assign(tracks_.size(), Eigen::Vector3d::Zero());
    model.known.assign(tracks_.size(), 0);
  }

  /// Starts from the pair of key frames with the widest angle among many inliers.
  bool start(const std::vector<int>& keys) {
    double best_score = 0;
    RelativePose best;
    int best_a = 0, best_b = 0;
    const std::size_t step = std::max<std::size_t>(1, keys.size() / 6);
    for (std::size_t a = 0; a + 1 < keys.size(); a += step)
      for (std::size_t b = a + 1; b < keys.size(); b += std::max<std::size_t>(1, (b - a) / 2)) {
        const std::vector<Pair> pairs = common_tracks(tracks_, keys[a], keys[b]);
        if (pairs.size() < 40) break;
        const auto pose = relative_pose(pairs, model.intrinsics, options_.max_error_px);
        if (!pose) continue;
        const double share = static_cast<double>(pose->inliers.size()) / static_cast<double>(pairs.size());
        const double score = std::min(pose->median_angle / start_angle, 1.0) * share *
                             std::sqrt(static_cast<double>(pose->inliers.size()));
        if (score > best_score) best_score = score, best = *pose, best_a = keys[a], best_b = keys[b];
      }
    if (best_score == 0) return false;
    model.cam_from_world[best_a] = {};
    model.cam_from_world[best_b] = best.b_from_a;
    place_points();
    adjust_all(false, 30);
    drop_outliers();
    return static_cast<std::size_t>(std::count(model.known.begin(), model.known.end(), 1)) >= enough_for_pose;
  }

  /// The frame among `frames` that sees most known points, or -1.
  int next(const std::vector<int>& frames) const {
    int best = -1;
    std::size_t most = enough_for_pose - 1;
    for (const int frame : frames) {
      if (model.cam_from_world.contains(frame) || failed_.contains(frame)) continue;
      const std::size_t seen = visible(frame).size();
      if (seen > most) most = seen, best = frame;
    }
    return best;
  }

  bool resect(int frame) {
    const std::vector<std::size_t> seen = visible(frame);
    std::vector<cv::Point3d> points;
    std::vector<cv::Point2d> pixels;
    for (const std::size_t t : seen) {
      points.emplace_back(model.points[t].x(), model.points[t].y(), model.points[t].z());
      pixels.emplace_back(tracks_[t].at(frame).x(), tracks_[t].at(frame).y());
    }
    const Rigid3 guess = nearest_pose(frame);
    cv::Mat turn, translation, inliers, k;
    Eigen::Matrix3d rotation = guess.rotation;
    cv::Mat rotation_cv;
    cv::eigen2cv(rotation, rotation_cv);
    cv::Rodrigues(rotation_cv, turn);
    cv::eigen2cv(guess.translation, translation);
    cv::eigen2cv(model.intrinsics.matrix(), k);
    const bool found = points.size() >= enough_for_pose &&
                       cv::solvePnPRansac(points, pixels, k, cv::noArray(), turn, translation, true, 200,
                                          static_cast<float>(2 * options_.max_error_px), 0.999, inliers,
                                          cv::SOLVEPNP_ITERATIVE);
    if (!found || static_cast<std::size_t>(inliers.rows) < std::max(enough_for_pose, seen.size() / 3)) {
      failed_[frame] = true;
      return false;
    }
    Rigid3 pose;
    cv::Rodrigues(turn, rotation_cv);
    cv::cv2eigen(rotation_cv, pose.rotation);
    Eigen::Vector3d t;
    cv::cv2eigen(translation, t);
    pose.translation = t;
    model.cam_from_world[frame] = pose;
    return true;
  }

  /// Triangulates every unknown track that registered frames see from different enough sides.
  void place_points() {
    for (std::size_t t = 0; t < tracks_.size(); ++t) {
      if (model.known[t] != 0) continue;
      std::vector<Rigid3> poses;
      std::vector<Eigen::Vector2d> pixels;
      for (const auto& [frame, pose] : model.cam_from_world)
        if (tracks_[t].covers(frame)) poses.push_back(pose), pixels.push_back(tracks_[t].at(frame));
      if (poses.size() < 2) continue;
      const auto point = triangulate(poses, pixels, model.intrinsics);
      if (!point || widest_angle(poses, *point) < min_point_angle) continue;
      model.points[t] = *point;
      model.known[t] = 1;
      if (worst_error(t) > 2 * options_.max_error_px) model.known[t] = 0;
    }
  }

  void adjust_all(bool focal, int iterations, double prior_focal = 0) {
    adjust(tracks_, {.focal = focal, .prior_focal = prior_focal, .iterations = iterations, .threads = threads_}, model);
  }

  void drop_outliers() {
    for (std::size_t t = 0; t < tracks_.size(); ++t)
      if (model.known[t] != 0 && worst_error(t) > options_.max_error_px) model.known[t] = 0;
  }

  void forgive() { failed_.clear(); }

 private:
  std::vector<std::size_t> visible(int frame) const {
    std::vector<std::size_t> seen;
    for (std::size_t t = 0; t < tracks_.size(); ++t)
      if (model.known[t] != 0 && tracks_[t].covers(frame)) seen.push_back(t);
    return seen;
  }

  Rigid3 nearest_pose(int frame) const {
    const auto after = model.cam_from_world.lower_bound(frame);
    if (after == model.cam_from_world.end()) return std::prev(after)->second;
    if (after == model.cam_from_world.begin()) return after->second;
    const auto before = std::prev(after);
    return frame - before->first < after->first - frame ? before->second : after->second;
  }

  static double widest_angle(const std::vector<Rigid3>& poses, const Eigen::Vector3d& point) {
    double widest = 0;
    const Eigen::Vector3d first = (point - poses.front().inverse().translation).normalized();
    for (const Rigid3& pose : poses) {
      const Eigen::Vector3d ray = (point - pose.inverse().translation).normalized();
      widest = std::max(widest, std::atan2(first.cross(ray).norm(), first.dot(ray)));
    }
    return widest;
  }

  double worst_error(std::size_t t) const {
    double worst = 0;
    for (const auto& [frame, pose] : model.cam_from_world) {
      if (!tracks_[t].covers(frame)) continue;
      const double error = reprojection_error(model, tracks_[t], t, frame);
      worst = std::max(worst, error < 0 ? 1e9 : error);
    }
    return worst;
  }

  const std::vector<Track>& tracks_;
  const SfmOptions& options_;
  int threads_;
  std::map<int, bool> failed_;
};

Reconstruction measured(Model model, const std::vector<Track>& tracks) {
  Reconstruction result;
  double squares = 0;
  for (std::size_t t = 0; t < tracks.size(); ++t) {
    if (model.known[t] == 0) continue;
    for (const auto& [frame, pose] : model.cam_from_world) {
      if (!tracks[t].covers(frame)) continue;
      const double error = reprojection_error(model, tracks[t], t, frame);
      squares += error * error;
      ++result.observations;
    }
  }
  result.rms_px = std::sqrt(squares / static_cast<double>(std::max<std::size_t>(1, result.observations)));
  result.model = std::move(model);
  return result;
}

}  // namespace

std::vector<int> key_frames(const std::vector<double>& shift_px, const Shot& shot, double picture_width) {
  double total = 0;
  for (int i = shot.first + 1; i <= shot.last; ++i) total += shift_px[static_cast<std::size_t>(i)];
  const double step = std::max(key_shift * picture_width, total / static_cast<double>(max_keys - 1));
  std::vector<int> keys = {shot.first};
  double since = 0;
  for (int i = shot.first + 1; i < shot.last; ++i) {
    since += shift_px[static_cast<std::size_t>(i)];
    if (since >= step) keys.push_back(i), since = 0;
  }
  keys.push_back(shot.last);
  // A slow or short clip has few: then the times between count, not the shifts.
  for (int parts = 4; keys.size() < 5 && shot.frames() > static_cast<int>(keys.size()) && parts <= 4; ++parts) {
    keys.clear();
    for (int p = 0; p <= parts; ++p) keys.push_back(shot.first + p * (shot.frames() - 1) / parts);
  }
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
  return keys;
}

std::optional<Reconstruction> reconstruct(const std::vector<Track>& tracks, const std::vector<int>& keys,
                                          const Intrinsics& intrinsics, bool adjust_focal, const SfmOptions& options,
                                          int threads, Monitor& monitor) {
  Builder builder(tracks, options, threads);
  builder.begin(intrinsics);
  if (!builder.start(keys)) return std::nullopt;
  long added = 2;
  const auto count = static_cast<long>(keys.size());
  for (int frame = builder.next(keys); frame >= 0; frame = builder.next(keys)) {
    monitor.step("cameras", added, count);
    if (!builder.resect(frame)) continue;
    builder.place_points();
    if (++added % 5 == 0) {
      builder.adjust_all(adjust_focal && added >= 5, 8, intrinsics.fx);
      builder.drop_outliers();
      builder.forgive();
    }
  }
  for (int round = 0; round < 2; ++round) {
    builder.adjust_all(adjust_focal, 25, intrinsics.fx);
    builder.drop_outliers();
    builder.place_points();
  }
  builder.drop_outliers();
  return measured(std::move(builder.model), tracks);
}

void register_rest(const std::vector<Track>& tracks, const Shot& shot, bool adjust_focal, const SfmOptions& options,
                   int threads, Monitor& monitor, Reconstruction& reconstruction) {
  Builder builder(tracks, options, threads);
  builder.model = std::move(reconstruction.model);
  std::vector<int> frames;
  for (int i = shot.first; i <= shot.last; ++i) frames.push_back(i);
  for (int frame = builder.next(frames); frame >= 0; frame = builder.next(frames)) builder.resect(frame);
  const long rounds = 2;
  for (long round = 0; round < rounds; ++round) {
    monitor.step("bundle adjustment", round, rounds);
    builder.drop_outliers();
    builder.place_points();
    builder.adjust_all(adjust_focal, 12, builder.model.intrinsics.fx);
  }
  builder.drop_outliers();
  reconstruction = measured(std::move(builder.model), tracks);
}

}  // namespace uwv::sfm
