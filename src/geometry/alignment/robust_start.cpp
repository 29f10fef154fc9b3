// SPDX-License-Identifier: Apache-2.0
#include "geometry/alignment/robust_start.h"

#include <algorithm>
#include <limits>
#include <random>

namespace uwv::alignment {
namespace {

/// So many samples judge a line: with one right sample in ten, 100 of them agree where chance brings 40.
constexpr std::size_t judges = 1000;

/// Sum of squared residuals, each counting at most as one at the threshold: fewer and farther both cost.
double cost(const Samples& samples, const AlignmentLine& line, double threshold, double best) {
  double sum = 0;
  for (const Sample& s : samples) {
    const double r = relative_residual(line, s) / threshold;
    sum += s.weight * std::min(1.0, r * r);
    if (sum >= best) break;
  }
  return sum;
}

bool through(const Sample& p, const Sample& q, bool shift, AlignmentLine& line) {
  if (!shift) {
    line = {p.y / p.x, 0};
  } else {
    if (p.x == q.x) return false;
    const double scale = (q.y - p.y) / (q.x - p.x);
    line = {scale, p.y - scale * p.x};
  }
  return std::isfinite(line.scale) && std::isfinite(line.shift);
}

}  // namespace

bool robust_start(const Samples& samples, const AlignmentOptions& options, std::uint64_t seed, AlignmentLine& line) {
  if (samples.empty()) return false;
  const bool shift = has_shift(options.model);
  std::mt19937_64 random(seed);
  Samples judging = samples;
  draw(judging, 0, judges, random());
  double best = std::numeric_limits<double>::infinity();
  for (int trial = 0; trial < options.start_trials; ++trial) {
    const Sample& p = samples[random() % samples.size()];
    const Sample& q = samples[random() % samples.size()];
    AlignmentLine tried;
    if (!through(p, q, shift, tried) || (options.refuse_negative && !(tried.scale > 0))) continue;
    const double its = cost(judging, tried, options.loss_scale, best);
    if (its >= best) continue;
    best = its;
    line = tried;
  }
  return std::isfinite(best);
}

}  // namespace uwv::alignment
