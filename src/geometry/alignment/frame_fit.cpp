// SPDX-License-Identifier: Apache-2.0
#include "geometry/alignment/frame_fit.h"

#include <algorithm>
#include <cmath>

#include "geometry/alignment/robust_start.h"

namespace uwv::alignment {
namespace {

class FrameFitter {
 public:
  FrameFitter(const AlignmentOptions& options, std::uint64_t seed)
      : options_(options), seed_(seed), shift_(has_shift(options.model)) {}

  FrameFit run(const AlignmentFrame& frame) {
    Samples samples = candidates_of(frame, options_);
    report().candidates = samples.size();
    if (samples.empty()) return give_up(empty_status(), "no pixel with both depths inside the mask");
    draw(samples, options_.share, least(), seed_);
    report().samples = report().inliers = samples.size();
    if (samples.size() < least())
      return give_up(AlignmentStatus::too_few, fmt::format("{} samples, {} are needed", samples.size(), least()));
    return options_.loss == AlignmentLoss::squared ? plain(samples) : robust(samples);
  }

 private:
  FrameAlignment& report() { return fit_.report; }
  std::size_t least() const {
    return std::max<std::size_t>(static_cast<std::size_t>(options_.min_samples), shift_ ? 2 : 1);
  }
  AlignmentStatus empty_status() const {
    return options_.official_empty ? AlignmentStatus::zero_empty : AlignmentStatus::kept_previous_empty;
  }
  FrameFit give_up(AlignmentStatus status, std::string reason) {
    report().status = status;
    report().reason = std::move(reason);
    return fit_;
  }

  FrameFit plain(const Samples& samples) {
    fit_.moments = moments_of(samples);
    if (is_singular(fit_.moments, shift_)) return singular();
    AlignmentLine line;
    if (!fit_line(samples, fit_.moments, {}, shift_, line)) return unsolved();
    return accept(samples, line);
  }

  FrameFit robust(const Samples& samples) {
    if (is_singular(moments_of(samples), shift_)) return singular();
    const Loss loss{options_.loss, options_.loss_scale};
    AlignmentLine line;
    if (!robust_start(samples, options_, seed_ ^ 1U, line)) return unsolved();
    // A handful of rounds settles which samples are inside the gate; more would only chase single ones at its rim.
    constexpr int rounds = 5;
    Samples inside;
    for (int round = 0; round < rounds; ++round) {
      const std::size_t before = inside.size();
      inside.clear();
      std::copy_if(samples.begin(), samples.end(), std::back_inserter(inside), [&](const Sample& s) {
        return std::fabs(relative_residual(line, s)) <= options_.gate * loss.scale;
      });
      report().inliers = inside.size();
      if (inside.size() < least())
        return give_up(AlignmentStatus::too_few,
                       fmt::format("{} samples agree, {} are needed", inside.size(), least()));
      if (inside.size() == before) break;
      const Moments moments = moments_of(inside);
      if (is_singular(moments, shift_)) return singular();
      if (!fit_line(inside, moments, loss, shift_, line)) return unsolved();
    }
    fit_.moments = moments_of(inside, [&](const Sample& s) {
      return robust_weight(loss, relative_residual(line, s)) / (s.unit() * s.unit());
    });
    return accept(inside, line);
  }

  FrameFit singular() {
    return give_up(AlignmentStatus::kept_previous_singular, "all samples lie at one depth, which fixes no scale");
  }
  FrameFit unsolved() {
    return give_up(AlignmentStatus::kept_previous_singular, "no line with a finite scale fits the samples");
  }

  FrameFit accept(const Samples& inside, const AlignmentLine& line) {
    double sum = 0, weight = 0;
    for (const Sample& s : inside) {
      sum += s.weight * std::pow(residual(line, s), 2);
      weight += s.weight;
    }
    report().own = line;
    report().rms = std::sqrt(sum / weight);
    report().status = AlignmentStatus::solved;
    if (line.scale > 0) return fit_;
    return give_up(AlignmentStatus::negative_scale, fmt::format("scale {:.3g} would turn near into far", line.scale));
  }

  const AlignmentOptions& options_;
  std::uint64_t seed_;
  bool shift_;
  FrameFit fit_;
};

}  // namespace

FrameFit fit_frame(const AlignmentFrame& frame, const AlignmentOptions& options, std::uint64_t index) {
  return FrameFitter(options, mixed(options.seed, index)).run(frame);
}

}  // namespace uwv::alignment
