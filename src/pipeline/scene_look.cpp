// SPDX-License-Identifier: Apache-2.0
#include "uwv/pipeline/scene_look.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace uwv {
namespace {

constexpr int samples_per_side = 48;  // enough to see every object worth seeing, and 2000 frames still take < 1 s
constexpr std::size_t frames_looked_at = 64;

struct Sample {
  int x, y;  ///< In the grid of samples.
  Eigen::Vector2d pixel;
  double depth;
};

std::vector<Sample> sample(const DepthMap& depth) {
  std::vector<Sample> samples;
  const int columns = std::min(depth.width(), samples_per_side);
  const int rows = std::min(depth.height(), samples_per_side);
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < columns; ++x) {
      const int px = (2 * x + 1) * depth.width() / (2 * columns);
      const int py = (2 * y + 1) * depth.height() / (2 * rows);
      samples.push_back({x, y, {px + 0.5, py + 0.5}, static_cast<double>(depth(px, py))});
    }
  return samples;
}

void find_range(const std::vector<Sample>& samples, SceneLook& look) {
  std::vector<double> depths;
  for (const Sample& s : samples)
    if (s.depth > 0) depths.push_back(s.depth);
  if (depths.empty()) return;
  std::sort(depths.begin(), depths.end());
  look.near_depth = depths[depths.size() / 20];
  look.far_depth = depths[depths.size() - 1 - depths.size() / 20];
}

/// Where points of the source camera land in a target camera.
class Warp {
 public:
  Warp(const Camera& source, const Camera& target)
      : source_(source), target_(target), target_from_source_(target_from_source(target, source)) {}
  bool operator()(const Eigen::Vector2d& pixel, double depth, Eigen::Vector2d& landed) const {
    return project(target_.intrinsics, target_from_source_ * unproject(source_.intrinsics, pixel, depth), landed);
  }
  bool moves() const { return !target_from_source_.translation.isZero(0); }
  /// What lands further outside than a picture's size says nothing about the picture.
  bool near_picture(const Eigen::Vector2d& p) const {
    return p.x() > -target_.size.width && p.x() < 2 * target_.size.width && p.y() > -target_.size.height &&
           p.y() < 2 * target_.size.height;
  }

 private:
  const Camera& source_;
  const Camera& target_;
  Rigid3 target_from_source_;
};

void measure(const Warp& warp, const std::vector<Sample>& samples, SceneLook& look) {
  const Sample* left = nullptr;
  Eigen::Vector2d left_landed = Eigen::Vector2d::Zero();
  for (const Sample& s : samples) {
    Eigen::Vector2d near_landed(0, 0), far_landed(0, 0), landed(0, 0);
    if (warp(s.pixel, look.near_depth, near_landed) && warp(s.pixel, look.far_depth, far_landed) &&
        warp.near_picture(near_landed) && warp.near_picture(far_landed))
      look.parallax_px = std::max(look.parallax_px, (near_landed - far_landed).norm());
    const bool valid = s.depth > 0 && warp(s.pixel, s.depth, landed) && warp.near_picture(landed);
    if (valid && left != nullptr && left->y == s.y) {
      const double gap = (landed - left_landed).norm() - (s.pixel - left->pixel).norm();
      look.disocclusion_px = std::max(look.disocclusion_px, gap);
    }
    left = valid ? &s : nullptr;
    left_landed = landed;
  }
}

}  // namespace

SceneLook look_at_scene(const DepthMap& depth, const TargetPath& path, const PathContext& context, ThreadPool& pool) {
  SceneLook look;
  look.edges = edge_sharpness(depth, pool);
  const PathSummary summary = summarize(path, context);
  look.max_rotation_deg = summary.max_rotation_deg;
  look.max_translation = summary.max_translation;
  look.first_return = summary.first_return;
  const std::vector<Sample> samples = sample(depth);
  find_range(samples, look);
  const std::size_t step = std::max<std::size_t>(1, path.frames.size() / frames_looked_at);
  for (std::size_t i = 0; i < path.frames.size(); ++i) {
    const TargetFrame& frame = path.frames[i];
    const auto pose = context.subject_from_source.size() == 1 ? 0 : static_cast<std::size_t>(frame.source_frame);
    const Camera source{context.intrinsics, context.subject_from_source[pose], depth.size()};
    const Warp warp(source, frame.camera);
    look.has_parallax |= warp.moves();
    const bool looked_at = i % step == 0 || i + 1 == path.frames.size();
    if (looked_at && warp.moves() && look.far_depth > 0) measure(warp, samples, look);
  }
  return look;
}

std::string SceneLook::brief() const {
  std::string text = fmt::format("depth {:.4g} to {:.4g}", near_depth, far_depth);
  if (has_parallax)
    text += fmt::format(", parallax up to {:.1f} px, gaps up to {:.1f} px", parallax_px, disocclusion_px);
  else
    text += ", no parallax: the camera only turns or zooms, nothing can be occluded";
  text += fmt::format(", turns {:.1f} deg, moves {:.3g} radii", max_rotation_deg, max_translation);
  if (edges.edges > 0) text += fmt::format(", {:.0f} % of depth edges smeared", 100 * edges.smeared_share());
  if (first_return >= 0) text += fmt::format(", comes back from frame {}", first_return);
  return text;
}

}  // namespace uwv
