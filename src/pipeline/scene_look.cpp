// SPDX-License-Identifier: Apache-2.0
#include "uwv/pipeline/scene_look.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "uwv/render/occlusion.h"

namespace uwv {
namespace {

constexpr int samples_per_side = 48;  // enough to see every object worth seeing, and 2000 frames still take < 1 s
constexpr std::size_t frames_looked_at = 64;
constexpr int probe_width = 160;  // shares of the picture come out within a tenth of their value
constexpr std::size_t frames_probed = 16;

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

/// The depth at every n-th pixel, so that no depth is made up.
DepthMap smaller(const DepthMap& depth) {
  const int step = std::max(1, depth.width() / probe_width);
  DepthMap small(std::max(1, depth.width() / step), std::max(1, depth.height() / step));
  for (int y = 0; y < small.height(); ++y)
    for (int x = 0; x < small.width(); ++x)
      small(x, y) =
          depth((2 * x + 1) * depth.width() / (2 * small.width()), (2 * y + 1) * depth.height() / (2 * small.height()));
  return small;
}

Camera source_camera(const PathContext& context, const TargetFrame& frame, Size size) {
  const auto pose = context.subject_from_source.size() == 1 ? 0 : static_cast<std::size_t>(frame.source_frame);
  return {context.intrinsics, context.subject_from_source[pose], size};
}

Camera at_size(const Camera& camera, Size size) {
  return {camera.intrinsics.resized(camera.size, size), camera.world_from_cam, size};
}

double uncovered(const DepthMap& depth, const TargetPath& path, const PathContext& context, ThreadPool& pool) {
  const DepthMap small = smaller(depth);
  const ImageRgb colour(small.size());
  const auto rasterizer = make_cpu_rasterizer(pool);
  OcclusionOptions options;
  options.kernel = Kernel::nearest;
  options.accumulation = Accumulation::none;
  const std::size_t probes = std::min(path.frames.size(), frames_probed);
  double open = 0;
  RenderedFrame seen;
  for (std::size_t i = 0; i < probes; ++i) {
    const TargetFrame& frame = path.frames[probes > 1 ? i * (path.frames.size() - 1) / (probes - 1) : 0];
    const Camera source = source_camera(context, frame, depth.size());
    if (WarpMap::between(source, frame.camera).identity) continue;  // that frame will be the source picture
    OcclusionRenderer renderer(*rasterizer, pool, options);
    renderer.render({.index = 0,
                     .camera = at_size(source, small.size()),
                     .colour = &colour,
                     .depth = &small,
                     .slopes = nullptr,
                     .valid = nullptr,
                     .foreground = nullptr},
                    at_size(frame.camera, small.size()), seen);
    open += 1 - static_cast<double>(seen.valid.count()) / static_cast<double>(small.size().pixels());
  }
  return open / static_cast<double>(probes);
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
    const Camera source = source_camera(context, frame, depth.size());
    const Warp warp(source, frame.camera);
    look.has_parallax |= warp.moves();
    const bool looked_at = i % step == 0 || i + 1 == path.frames.size();
    if (looked_at && warp.moves() && look.far_depth > 0) measure(warp, samples, look);
  }
  look.uncovered_share = uncovered(depth, path, context, pool);
  return look;
}

std::string SceneLook::brief() const {
  std::string text = fmt::format("depth {:.4g} to {:.4g}", near_depth, far_depth);
  if (has_parallax)
    text += fmt::format(", parallax up to {:.1f} px, gaps up to {:.1f} px", parallax_px, disocclusion_px);
  else
    text += ", no parallax: the camera only turns or zooms, nothing can be occluded";
  text += fmt::format(", {:.1f} % of the path uncovered", 100 * uncovered_share);
  text += fmt::format(", turns {:.1f} deg, moves {:.3g} radii", max_rotation_deg, max_translation);
  if (edges.edges > 0) text += fmt::format(", {:.0f} % of depth edges smeared", 100 * edges.smeared_share());
  if (first_return >= 0) text += fmt::format(", comes back from frame {}", first_return);
  return text;
}

}  // namespace uwv
