// SPDX-License-Identifier: Apache-2.0
// How still the depth of static points stands, before and after relative depth is aligned to what structure from motion
// knows of a recording. Relative depth is the true depth with noise, or what multi-view stereo found, behind lines of
// inverse depth that drift slowly, as a video network's do, or jump from frame to frame, as an image network's do.
#include <algorithm>
#include <cmath>
#include <random>

#include "bench/geometry.h"
#include "uwv/core/depth.h"
#include "uwv/eval/depth_metrics.h"
#include "uwv/geometry/depth_alignment.h"

namespace uwv::bench {
namespace {

/// Depth known only where a reconstructed point was seen.
std::vector<DepthMap> sparse_depths(const SfmResult& scene) {
  std::vector<DepthMap> depths;
  for (const Camera& camera : scene.cameras) depths.emplace_back(camera.size);
  for (const ScenePoint& point : scene.points)
    for (const PointObservation& seen : point.observations) {
      const auto frame = static_cast<std::size_t>(seen.frame);
      const double z = (scene.cameras[frame].cam_from_world() * point.x_in_world).z();
      const int x = static_cast<int>(seen.pixel.x()), y = static_cast<int>(seen.pixel.y());
      if (z > 0 && depths[frame].contains(x, y)) depths[frame](x, y) = static_cast<float>(z);
    }
  return depths;
}

/// What a worse reconstruction knows: every frame is off by a factor of its own, 3 % on average.
std::vector<DepthMap> flickering(std::vector<DepthMap> depths) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal(0, 0.03);
  for (DepthMap& depth : depths) {
    const auto factor = static_cast<float>(std::exp(normal(random)));
    for (float& z : depth.pixels()) z *= factor;
  }
  return depths;
}

/// One line a frame, for depths whose inverse is about 1: 1/D = scale * v + shift.
std::vector<AlignmentLine> lines(std::size_t frames, bool jumping) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal(0, 1);
  std::vector<AlignmentLine> out;
  for (std::size_t i = 0; i < frames; ++i) {
    const double phase = 0.05 * static_cast<double>(i);
    const double wide = jumping ? 0.15 * normal(random) : 0.15 * std::sin(phase);
    const double up = jumping ? 0.1 * normal(random) : 0.1 * std::cos(0.7 * phase);
    out.push_back({0.4 * std::exp(wide), 0.2 + up});
  }
  return out;
}

/// Inverse depth in units of its median, so that lines mean the same for every recording; then what the line is drawn
/// from. 0 = unknown.
std::vector<Image<float>> relative(const std::vector<DepthMap>& depths, const std::vector<AlignmentLine>& lines,
                                   double noise) {
  const double unit = static_cast<double>(median_depth(depths.front()));
  std::mt19937 random(11);
  std::normal_distribution<double> normal(0, noise);
  std::vector<Image<float>> out;
  for (std::size_t f = 0; f < depths.size(); ++f) {
    out.emplace_back(depths[f].size());
    std::transform(depths[f].pixels().begin(), depths[f].pixels().end(), out.back().pixels().begin(), [&](float z) {
      if (!(z > 0)) return 0.0F;
      const double inverse = unit / static_cast<double>(z) * (noise > 0 ? std::exp(normal(random)) : 1);
      return static_cast<float>(std::max(0.0, (inverse - lines[f].shift) / lines[f].scale));
    });
  }
  return out;
}

struct Way {
  std::string name;
  AlignmentOptions options;
  bool first_line_for_all = false;  ///< Nothing is aligned but the unit.
};

std::vector<Way> ways() {
  std::vector<Way> all;
  const auto add = [&](std::string name, AlignmentSmoothing smoothing, double momentum = 0.99) {
    AlignmentOptions options;
    options.loss = AlignmentLoss::cauchy;  // points on edges land on the wrong side of them
    options.share = 1;                     // points are few
    options.smoothing = smoothing;
    options.momentum = momentum;
    all.push_back({std::move(name), options});
  };
  add("none: the first frame's line", AlignmentSmoothing::none);
  all.back().first_line_for_all = true;
  add("each frame its own", AlignmentSmoothing::none);
  add("momentum=0.99", AlignmentSmoothing::momentum);
  add("momentum=0.9", AlignmentSmoothing::momentum, 0.9);
  add("joint", AlignmentSmoothing::joint);
  return all;
}

std::vector<FrameGeometry> aligned(const std::vector<Image<float>>& relative, const std::vector<DepthMap>& reference,
                                   const Way& way, ThreadPool& pool) {
  std::vector<AlignmentFrame> frames;
  for (std::size_t i = 0; i < relative.size(); ++i) frames.push_back({&relative[i], &reference[i], nullptr, nullptr});
  Monitor monitor;
  const AlignmentSummary summary = align_depth(frames, way.options, pool, monitor);
  std::vector<FrameGeometry> out;
  for (std::size_t i = 0; i < relative.size(); ++i) {
    const FrameAlignment& line = summary.frames[way.first_line_for_all ? 0 : i];
    out.push_back({aligned_depth(relative[i], line, way.options), ConfidenceMap(relative[i].size(), 1.0F)});
  }
  return out;
}

DepthFlicker flicker_of(const std::vector<FrameGeometry>& found, const TrueClip& truth, double scale) {
  std::vector<DepthMap> depths;
  for (const FrameGeometry& frame : found) {
    depths.push_back(frame.depth);
    for (float& z : depths.back().pixels()) z = static_cast<float>(scale * static_cast<double>(z));
  }
  return temporal_flicker(depths, truth.cameras, truth.static_pixels);
}

}  // namespace

Table alignment_flicker_table(const TrueClip& truth, ThreadPool& pool) {
  Table table("relative depth of " + truth.name + ", aligned to reconstructed points",
              {"relative", "lines", "points", "alignment", "flicker", "jump_share", "abs_rel", "delta_125"});
  Monitor monitor;
  SfmOptions lens;
  lens.intrinsics = truth.cameras.front().intrinsics;
  const SfmResult scene = structure_from_motion(truth.frames, lens, pool, monitor);
  if (scene.motion != ClipMotion::moving) {
    fmt::print("{} left out: {}\n", truth.name, scene.reason);
    return table;
  }
  const std::vector<DepthMap> steady = sparse_depths(scene), unsteady = flickering(steady);
  std::vector<FrameGeometry> stereo;
  multi_view_stereo(truth.frames, scene.cameras, scene.points, truth.static_pixels, {}, pool, monitor, stereo);
  std::vector<DepthMap> measured;
  for (FrameGeometry& frame : stereo) measured.push_back(std::move(frame.depth));
  const auto add = [&](const char* source, const char* line, const char* points, const std::string& way,
                       const std::vector<FrameGeometry>& found) {
    const DepthScore score = score_depth(found, truth, 0);
    const DepthFlicker flicker = flicker_of(found, truth, score.scale);
    table.add({source, line, points, way, figure(flicker.mean), figure(flicker.jump_share), figure(score.abs_rel),
               figure(score.delta_125)});
  };
  constexpr double noise = 0.005;
  for (const auto& [name, depths, its_noise] :
       {std::tuple("true depth, 0.5 % noise", &truth.depths, noise), {"stereo", &measured, 0.0}})
    for (const bool jumping : {false, true}) {
      const std::vector<Image<float>> seen = relative(*depths, lines(depths->size(), jumping), its_noise);
      for (const auto& [points, at_points] : {std::pair("good", &steady), {"flickering", &unsteady}})
        for (const Way& way : ways())
          add(name, jumping ? "jumping" : "drifting", points, way.name, aligned(seen, *at_points, way, pool));
    }
  return table;
}

}  // namespace uwv::bench
