// SPDX-License-Identifier: Apache-2.0
#include "uwv/geometry/depth_alignment.h"

#include <algorithm>
#include <cmath>

#include "geometry/alignment/frame_fit.h"
#include "geometry/alignment/joint.h"
#include "uwv/core/depth.h"

namespace uwv {
namespace {

using alignment::FrameFit;

/// The frame's own line may be used as it is.
bool speaks(const FrameAlignment& frame, const AlignmentOptions& options) {
  switch (frame.status) {
    case AlignmentStatus::solved:
    case AlignmentStatus::zero_empty: return true;
    case AlignmentStatus::negative_scale: return !options.refuse_negative;
    default: return false;
  }
}

void say_what_is_used(FrameAlignment& frame, const std::string& used) {
  frame.reason += frame.reason.empty() ? used : "; " + used;
}

/// Frames before the first line have no line before them; the first one is the nearest there is.
void fill_start(std::vector<FrameAlignment>& frames) {
  const auto first = std::find_if(frames.begin(), frames.end(), [](const FrameAlignment& f) { return f.usable; });
  for (auto frame = frames.begin(); frame != first; ++frame) {
    if (first == frames.end()) {
      say_what_is_used(*frame, "no frame determines a line");
      continue;
    }
    frame->line = first->line;
    frame->usable = true;
    say_what_is_used(*frame, fmt::format("the line of frame {} is used", first - frames.begin()));
  }
}

void pass_on(std::vector<FrameAlignment>& frames, const AlignmentOptions& options) {
  const double keep = options.smoothing == AlignmentSmoothing::momentum ? options.momentum : 0;
  AlignmentLine running;
  bool started = false;
  for (FrameAlignment& frame : frames) {
    if (speaks(frame, options)) {
      running = started ? AlignmentLine{keep * running.scale + (1 - keep) * frame.own.scale,
                                        keep * running.shift + (1 - keep) * frame.own.shift}
                        : frame.own;
      started = true;
    } else if (started) {
      say_what_is_used(frame, "the line before is kept");
    }
    frame.line = running;
    frame.usable = started;
  }
  fill_start(frames);
}

void solve_together(std::vector<FrameAlignment>& frames, const std::vector<FrameFit>& fits,
                    const AlignmentOptions& options) {
  std::vector<AlignmentLine> lines;
  const bool solved = alignment::solve_jointly(fits, options, lines);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    FrameAlignment& frame = frames[i];
    if (solved && (lines[i].scale > 0 || !options.refuse_negative)) {
      frame.line = lines[i];
      frame.usable = true;
      if (frame.status != AlignmentStatus::solved) say_what_is_used(frame, "the frames around decide");
    } else if (i > 0 && frames[i - 1].usable) {
      frame.line = frames[i - 1].line;
      frame.usable = true;
      say_what_is_used(frame, "the joint scale is not positive, the line before is kept");
    }
  }
  fill_start(frames);
}

}  // namespace

std::string_view to_string(AlignmentModel model) {
  switch (model) {
    case AlignmentModel::inverse_affine: return "inverse_affine";
    case AlignmentModel::inverse_scale: return "inverse_scale";
    case AlignmentModel::depth_affine: return "depth_affine";
    case AlignmentModel::depth_scale: return "depth_scale";
  }
  return "unknown";
}

std::string_view to_string(AlignmentLoss loss) {
  switch (loss) {
    case AlignmentLoss::squared: return "squared";
    case AlignmentLoss::huber: return "huber";
    case AlignmentLoss::cauchy: return "cauchy";
  }
  return "unknown";
}

std::string_view to_string(AlignmentSmoothing smoothing) {
  switch (smoothing) {
    case AlignmentSmoothing::none: return "none";
    case AlignmentSmoothing::momentum: return "momentum";
    case AlignmentSmoothing::joint: return "joint";
  }
  return "unknown";
}

std::string_view to_string(AlignmentStatus status) {
  switch (status) {
    case AlignmentStatus::solved: return "solved";
    case AlignmentStatus::kept_previous_empty: return "kept_previous_empty";
    case AlignmentStatus::too_few: return "too_few";
    case AlignmentStatus::kept_previous_singular: return "kept_previous_singular";
    case AlignmentStatus::negative_scale: return "negative_scale";
    case AlignmentStatus::zero_empty: return "zero_empty";
  }
  return "unknown";
}

void AlignmentOptions::check() const {
  require(std::isfinite(loss_scale) && loss_scale > 0, "loss_scale {} is not positive", loss_scale);
  require(std::isfinite(gate) && gate > 0, "gate {} is not positive", gate);
  require(start_trials >= 1, "start_trials {} is not positive", start_trials);
  require(share > 0 && share <= 1, "share {} is not in (0, 1]", share);
  require(min_samples >= 1, "min_samples {} is not positive", min_samples);
  require(momentum >= 0 && momentum < 1, "momentum {} is not in [0, 1)", momentum);
  require(smooth_frames >= 0 && smooth_frames <= 1000, "smooth_frames {} is not in [0, 1000]", smooth_frames);
  require(std::isfinite(inverse_floor) && inverse_floor >= 0, "inverse_floor {} is negative", inverse_floor);
}

std::size_t AlignmentSummary::count(AlignmentStatus status) const {
  return static_cast<std::size_t>(
      std::count_if(frames.begin(), frames.end(), [&](const FrameAlignment& f) { return f.status == status; }));
}

std::string AlignmentSummary::brief() const {
  std::string text = fmt::format("{} frames: {} solved", frames.size(), count(AlignmentStatus::solved));
  for (const auto status :
       {AlignmentStatus::kept_previous_empty, AlignmentStatus::too_few, AlignmentStatus::kept_previous_singular,
        AlignmentStatus::negative_scale, AlignmentStatus::zero_empty})
    if (count(status) > 0) text += fmt::format(", {} {}", count(status), to_string(status));
  const auto lost = std::count_if(frames.begin(), frames.end(), [](const FrameAlignment& f) { return !f.usable; });
  if (lost > 0) text += fmt::format("; {} without any line", lost);
  return text;
}

struct DepthAligner::State {
  AlignmentOptions options;
  std::vector<FrameFit> fits;
};

DepthAligner::DepthAligner(const AlignmentOptions& options) : state_(std::make_unique<State>()) {
  options.check();
  state_->options = options;
}
DepthAligner::~DepthAligner() = default;

void DepthAligner::add(const AlignmentFrame& frame) {
  state_->fits.push_back(alignment::fit_frame(frame, state_->options, state_->fits.size()));
}

AlignmentSummary DepthAligner::finish() const {
  AlignmentSummary summary;
  for (const FrameFit& fit : state_->fits) summary.frames.push_back(fit.report);
  if (state_->options.smoothing == AlignmentSmoothing::joint)
    solve_together(summary.frames, state_->fits, state_->options);
  else
    pass_on(summary.frames, state_->options);
  return summary;
}

AlignmentSummary align_depth(std::span<const AlignmentFrame> frames, const AlignmentOptions& options, ThreadPool& pool,
                             Monitor& monitor) {
  DepthAligner aligner(options);
  std::vector<FrameFit>& fits = aligner.state_->fits;
  fits.resize(frames.size());
  const auto batch = static_cast<std::size_t>(pool.size());
  for (std::size_t from = 0; from < frames.size(); from += batch) {
    const std::size_t to = std::min(frames.size(), from + batch);
    pool.run(static_cast<int>(to - from), [&](int part) {
      const std::size_t i = from + static_cast<std::size_t>(part);
      fits[i] = alignment::fit_frame(frames[i], options, i);
    });
    monitor.step("align depth", static_cast<long>(to), static_cast<long>(frames.size()));
  }
  return aligner.finish();
}

DepthMap aligned_depth(const Image<float>& relative, const FrameAlignment& frame, const AlignmentOptions& options) {
  DepthMap depth(relative.size());
  if (!frame.usable) return depth;
  const bool inverse = alignment::of_inverse(options.model);
  const bool invert_x = inverse != (options.relative == RelativeDepth::inverse);
  for (std::size_t p = 0; p < depth.pixels().size(); ++p) {
    const double value = static_cast<double>(relative.pixels()[p]);
    if (!std::isfinite(value) || (invert_x && !(value > 0))) continue;
    const double x = invert_x ? 1 / value : value;
    const double y = frame.line.scale * x + frame.line.shift;
    depth.pixels()[p] = static_cast<float>(inverse ? 1 / std::max(y, options.inverse_floor) : y);
  }
  sanitize_depth(depth);
  return depth;
}

}  // namespace uwv
