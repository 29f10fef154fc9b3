// SPDX-License-Identifier: Apache-2.0
// What aligning relative depth costs and how near it comes to the truth: losses and shares of samples on one frame,
// ways of smoothing on a clip whose reference flickers, and
// on a recording.
#include <algorithm>
#include <cmath>
#include <random>

#include "bench/accuracy.h"
#include "bench/geometry.h"
#include "bench/timing.h"
#include "uwv/geometry/depth_alignment.h"

namespace uwv::bench {
namespace {

constexpr AlignmentLine still{0.37, 0.05};

DepthMap scene_depth(const BenchOptions& options, Size size, ThreadPool& pool) {
  const StockScene scene = scene_named(options.scene, size);
  return render(scene.scene, scene.source, 0, pool).depth;
}

Image<float> relative_to(const DepthMap& depth, const AlignmentLine& line) {
  Image<float> v(depth.size());
  std::transform(depth.pixels().begin(), depth.pixels().end(), v.pixels().begin(), [&](float z) {
    return z > 0 ? static_cast<float>((1 / static_cast<double>(z) - line.shift) / line.scale) : 0.0F;
  });
  return v;
}

/// Noise of 2 %, and a share of depths that could be anything up to six times the nearest.
DepthMap spoilt(DepthMap depth, double outliers, double factor, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, 0.02);
  std::uniform_real_distribution<double> unit(0, 1);
  double nearest = HUGE_VAL;
  for (const float z : depth.pixels())
    if (z > 0) nearest = std::min(nearest, static_cast<double>(z));
  for (float& z : depth.pixels()) {
    const double right = static_cast<double>(z) * factor * std::exp(noise(random));
    z = static_cast<float>(unit(random) < outliers ? nearest * (0.5 + 5.5 * unit(random)) : right);
  }
  return depth;
}

/// Mean relative error of the inverse depth a line gives.
double error_of(const AlignmentLine& line, const Image<float>& v, const AlignmentLine& truth) {
  double sum = 0;
  std::size_t count = 0;
  for (const float value : v.pixels()) {
    if (!(value > 0)) continue;
    const double x = static_cast<double>(value), wanted = truth.scale * x + truth.shift;
    sum += std::fabs(line.scale * x + line.shift - wanted) / wanted;
    ++count;
  }
  return sum / static_cast<double>(count);
}

Table one_frame(const BenchOptions& options, ThreadPool& pool) {
  Table table("alignment of one frame", {"wrong_samples", "loss", "share", "ms", "error"});
  const DepthMap depth = scene_depth(options, options.size, pool);
  const Image<float> v = relative_to(depth, still);
  for (const double outliers : {0.0, 0.1, 0.9}) {
    const DepthMap reference = spoilt(depth, outliers, 1, 1);
    for (const AlignmentLoss loss : {AlignmentLoss::squared, AlignmentLoss::huber, AlignmentLoss::cauchy})
      for (const double share : {0.01, 0.25, 1.0}) {
        AlignmentOptions its;
        its.loss = loss;
        its.share = share;
        FrameAlignment found;
        const Timing timing = time(options.runs, [&] {
          DepthAligner aligner(its);
          aligner.add({&v, &reference, nullptr, nullptr});
          found = aligner.finish().frames.front();
        });
        table.add({outliers, std::string(to_string(loss)), share, timing.median_ms, error_of(found.own, v, still)});
      }
  }
  return table;
}

/// Every frame's reference is wrong by a factor of its own (5 %), and the true line drifts.
struct Flickering {
  std::vector<AlignmentLine> truth;
  std::vector<Image<float>> relatives;
  std::vector<DepthMap> references;
  std::vector<AlignmentFrame> frames;

  Flickering(const DepthMap& depth, double drift) {
    constexpr int count = 120;
    std::mt19937 random(5);
    std::normal_distribution<double> flicker(0, 0.05);
    for (int i = 0; i < count; ++i) {
      const double phase = 3.14159 * i / count;
      truth.push_back({0.37 * (1 + 0.2 * drift * std::sin(phase)), 0.05 * std::cos(drift * phase)});
      relatives.push_back(relative_to(depth, truth.back()));
      references.push_back(spoilt(depth, 0, std::exp(flicker(random)), static_cast<std::uint32_t>(i)));
    }
    for (std::size_t i = 0; i < truth.size(); ++i) frames.push_back({&relatives[i], &references[i], nullptr, nullptr});
  }
  double error(const AlignmentSummary& summary) const {
    double sum = 0;
    for (std::size_t i = 0; i < truth.size(); ++i) sum += error_of(summary.frames[i].line, relatives[i], truth[i]);
    return sum / static_cast<double>(truth.size());
  }
};

Table clips(const BenchOptions& options, ThreadPool& pool) {
  Table table("alignment of 120 flickering frames, an eighth as wide", {"drift", "smoothing", "ms", "error"});
  const Size size{std::max(16, options.size.width / 8), std::max(16, options.size.height / 8)};
  const DepthMap depth = scene_depth(options, size, pool);
  Monitor monitor;
  for (const double drift : {0.0, 0.3, 1.0}) {
    const Flickering clip(depth, drift);
    const auto row = [&](const std::string& name, const AlignmentOptions& its) {
      AlignmentSummary summary;
      const Timing timing = time(options.runs, [&] { summary = align_depth(clip.frames, its, pool, monitor); });
      table.add({drift, name, timing.median_ms, clip.error(summary)});
    };
    AlignmentOptions its;
    its.smoothing = AlignmentSmoothing::none;
    row("none", its);
    its.smoothing = AlignmentSmoothing::momentum;
    for (const double momentum : {0.99, 0.9, 0.8}) {
      its.momentum = momentum;
      row(fmt::format("momentum {}", momentum), its);
    }
    its.smoothing = AlignmentSmoothing::joint;
    for (const double frames : {5.0, 15.0, 30.0}) {
      its.smooth_frames = frames;
      row(fmt::format("joint, smooth_frames {}", frames), its);
    }
  }
  return table;
}

}  // namespace

std::vector<Table> alignment_accuracy(const BenchOptions& options) {
  options.check();
  ThreadPool pool(options.threads);
  std::vector<Table> tables{one_frame(options, pool), clips(options, pool)};
  if (options.recording.empty()) {
    fmt::print("flicker of a real clip left out: no recording given with --recording\n");
    return tables;
  }
  ResizePolicy own_size;
  own_size.mode = ResizePolicy::Mode::none;
  tables.push_back(alignment_flicker_table(
      read_true_clip(options.recording, {options.start, options.stride, options.frames}, own_size), pool));
  return tables;
}

}  // namespace uwv::bench
