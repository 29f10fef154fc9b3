// SPDX-License-Identifier: Apache-2.0
// Brings relative depth (a video network's, consistent but without unit) onto reference depth (metric, or of
// a multi-view reconstruction): one scale and shift per frame, found by Ceres.
//
// Paper: the foreground of D comes from a video depth network aligned to the scene's depth; geometry sheet 4.5 has what
// the official code does. With v the relative inverse depth and D the reference, a frame's line is
//     (a, b) = argmin  sum over samples of  w * rho(a * v + b - 1 / D),
// with rho the plain square unless told otherwise (other losses count residuals as shares of 1/D). Everything is
// computed in double on centred, scaled values, so magnitudes from 1e-8 to 1e8 cost no digits. No result is ever NaN or
// infinite: a frame that determines no line keeps the one before it and says why.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "uwv/core/mask.h"
#include "uwv/core/monitor.h"
#include "uwv/core/thread_pool.h"
#include "uwv/geometry/layers.h"
#include "uwv/geometry/reliability.h"

namespace uwv {

/// What is a straight line of what.
enum class AlignmentModel {
  inverse_affine,  ///< 1/D = a v + b: networks that predict inverse depth up to scale and shift.
  inverse_scale,   ///< 1/D = a v: inverse depth up to scale.
  depth_affine,    ///< D = a d + b, d = 1/v: networks that predict depth up to scale and shift.
  depth_scale,     ///< D = a d: depth up to scale, such as a reconstruction's.
};
/// How a sample's residual counts.
enum class AlignmentLoss {
  squared,  ///< Plain least squares, as the paper; equals the closed form.
  huber,    ///< Linear beyond `loss_scale`.
  cauchy,   ///< Logarithmic beyond `loss_scale`: far samples hardly count.
};
/// How a clip's lines hang together.
enum class AlignmentSmoothing {
  none,      ///< Each frame its own.
  momentum,  ///< A running mean, as the official code: causal, lags behind changes.
  joint,     ///< All frames solved at once with a price on unsteady change: looks ahead as well, has no lag.
};
/// What the pictures given as `relative` hold.
enum class RelativeDepth {
  inverse,  ///< v, larger = nearer.
  depth,    ///< d = 1/v, larger = farther; 0 = unknown.
};
std::string_view to_string(AlignmentModel model);
std::string_view to_string(AlignmentLoss loss);
std::string_view to_string(AlignmentSmoothing smoothing);

struct AlignmentOptions {
  /// What the official code fits.
  AlignmentModel model = AlignmentModel::inverse_affine;
  /// What the video depth network of the paper delivers.
  RelativeDepth relative = RelativeDepth::inverse;
  /// The paper's. One wrong pixel in ten already bends it; huber and cauchy survive nine in ten.
  AlignmentLoss loss = AlignmentLoss::squared;
  /// huber, cauchy: residuals are called large from here on, as a share of the sample's own reference value (noise of
  /// depth grows with depth). 0.02 is the noise of good reference depth.
  double loss_scale = 0.02;
  /// huber, cauchy: samples farther than this many `loss_scale` from the line found so far are left out, and the line
  /// is found again until that changes nothing. Without it, nine wrong samples in ten would outvote the right one.
  double gate = 3;
  /// huber, cauchy: pairs of samples tried for the first line. With nine wrong samples in ten a pair is right once in a
  /// hundred; 1000 miss all right ones with a chance of 4e-5.
  int start_trials = 1000;
  /// Share of the samples that is used, drawn with `seed`: 0.25 as the official code, which draws anew each time. 1
  /// uses all: slower by the same factor.
  double share = 0.25;
  std::uint64_t seed = 0;
  /// Fewer samples than this determine nothing. 2 determine a line, if barely.
  int min_samples = 2;
  /// A line that falls turns near into far: the frame before it is trusted instead. The official code uses it; false
  /// does so too.
  bool refuse_negative = true;
  /// The official code takes (0, 0) for the line of an empty frame and mixes it in. True does so too, for comparing.
  bool official_empty = false;
  /// The official code's.
  AlignmentSmoothing smoothing = AlignmentSmoothing::momentum;
  /// Share of the line before in a running mean, [0, 1). The first line counts fully.
  double momentum = 0.99;
  /// joint: about how many frames to each side a line is averaged with; drift that is steady over so many is followed.
  /// 15 halves what the best running mean errs on clips that drift, and beats it on clips that do not.
  double smooth_frames = 15;
  /// aligned_depth(): inverse depth is raised to at least this, so that what should lie behind infinity becomes a far
  /// wall. The official code says 1e-3, which presumes metres. 0 = no such wall: those pixels become invalid (0).
  double inverse_floor = 0;
  void check() const;
};

/// One frame's input; all pictures of one size. `relative`: values that are not finite or not positive are no samples.
struct AlignmentFrame {
  const Image<float>* relative = nullptr;
  const DepthMap* reference = nullptr;
  const ValidityMask* mask = nullptr;     ///< 1 = may be a sample; null = all.
  const Image<float>* weights = nullptr;  ///< Relative weights; not finite or not positive = no sample; null = all 1.
};

enum class AlignmentStatus {
  solved,
  kept_previous_empty,     ///< No sample at all.
  too_few,                 ///< Fewer samples than `min_samples` or than the model has unknowns; previous kept.
  kept_previous_singular,  ///< All samples at one depth: any line through one point would do; previous kept.
  negative_scale,          ///< Solved, but falling; previous kept if `refuse_negative`.
  zero_empty,              ///< No sample, `official_empty`: the frame's own line is (0, 0).
};
std::string_view to_string(AlignmentStatus status);

/// target = scale * x + shift, in the model's own terms.
struct AlignmentLine {
  double scale = 0, shift = 0;
  friend bool operator==(const AlignmentLine&, const AlignmentLine&) = default;
};

struct FrameAlignment {
  AlignmentLine line;  ///< To be used: smoothed or kept. (0, 0) when not `usable`.
  AlignmentLine own;   ///< What this frame's samples say alone; (0, 0) when they say nothing.
  AlignmentStatus status = AlignmentStatus::kept_previous_empty;
  bool usable = false;         ///< False when no frame so far (nor later) determined a line.
  std::size_t candidates = 0;  ///< Pixels that could be samples.
  std::size_t samples = 0;     ///< Drawn from them.
  std::size_t inliers = 0;     ///< Samples within the gate (huber, cauchy); else all.
  double rms = 0;              ///< Root mean square residual of the own line over its inliers, in the target's unit.
  std::string reason;          ///< One sentence unless simply solved.
};

struct AlignmentSummary {
  std::vector<FrameAlignment> frames;
  std::size_t count(AlignmentStatus status) const;
  /// One line: frames, how many were solved and what became of the others.
  std::string brief() const;
};

/// Frame by frame: keeps a few numbers of each frame, no pictures.
class DepthAligner {
 public:
  explicit DepthAligner(const AlignmentOptions& options);
  ~DepthAligner();
  DepthAligner(const DepthAligner&) = delete;
  DepthAligner& operator=(const DepthAligner&) = delete;
  /// Throws std::invalid_argument when pictures are missing or their sizes differ.
  void add(const AlignmentFrame& frame);
  /// The lines of all frames added so far. Frames before the first solved one take its line.
  AlignmentSummary finish() const;

 private:
  friend AlignmentSummary align_depth(std::span<const AlignmentFrame>, const AlignmentOptions&, ThreadPool&, Monitor&);
  struct State;
  std::unique_ptr<State> state_;
};

/// All frames at once, several at a time; the same result for any number of threads. Stage "align depth".
AlignmentSummary align_depth(std::span<const AlignmentFrame> frames, const AlignmentOptions& options, ThreadPool& pool,
                             Monitor& monitor);

/// Relative depth brought onto the reference's unit; `relative` and options as in the fit. Not finite, not positive or
/// out of range = 0 (invalid); all 0 when the frame is not usable.
DepthMap aligned_depth(const Image<float>& relative, const FrameAlignment& frame, const AlignmentOptions& options);

/// Which pixels the official code takes samples from (geometry sheet 4.5).
struct SampleSelection {
  int erode_window = 5;            ///< Side of the square the foreground is shrunk by, odd.
  int erode_iterations = 2;        ///< How often; borders of masks are often a few pixels off.
  ReliabilityOptions reliability;  ///< Of 1/v.
  float min_relative = 1e-3F;      ///< v must exceed this: below it is noise.
  void check() const;
};
/// E and reliable(1/v) and v > min: E the shrunk `foreground`. `relative_inverse` holds v.
ValidityMask alignment_samples(const Image<float>& relative_inverse, const ForegroundMask& foreground,
                               const SampleSelection& selection, ThreadPool& pool);

}  // namespace uwv
