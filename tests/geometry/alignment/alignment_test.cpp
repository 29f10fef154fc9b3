// SPDX-License-Identifier: Apache-2.0
// What aligning depth promises: the closed form's answer, known lines found again, wrong samples survived.
#include <gmock/gmock.h>

#include "geometry/alignment/alignment_scene.h"
#include "support/matchers.h"

namespace uwv::testing {
namespace {

using ::testing::HasSubstr;

constexpr AlignmentLine truth{0.37, 0.05};

AlignmentOptions all_samples(AlignmentLoss loss = AlignmentLoss::squared) {
  AlignmentOptions options;
  options.share = 1;
  options.loss = loss;
  return options;
}

void expect_line(const AlignmentLine& found, const AlignmentLine& wanted, double relative) {
  EXPECT_NEAR(found.scale, wanted.scale, relative * std::fabs(wanted.scale));
  EXPECT_NEAR(found.shift, wanted.shift, relative * std::max(std::fabs(wanted.shift), std::fabs(wanted.scale)));
}

/// Weighted least squares by QR in long double, without any of the library's normalising.
AlignmentLine closed_form(const Image<float>& v, const DepthMap& depth, const Image<float>* weights) {
  using Matrix = Eigen::Matrix<long double, Eigen::Dynamic, 2>;
  using Vector = Eigen::Matrix<long double, Eigen::Dynamic, 1>;
  const auto n = static_cast<Eigen::Index>(v.pixels().size());
  Matrix rows(n, 2);
  Vector right(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto p = static_cast<std::size_t>(i);
    const long double root = weights == nullptr ? 1.0L : std::sqrt(static_cast<long double>(weights->pixels()[p]));
    rows(i, 0) = root * static_cast<long double>(v.pixels()[p]);
    rows(i, 1) = root;
    right(i) = root / static_cast<long double>(depth.pixels()[p]);
  }
  const Vector solution = rows.colPivHouseholderQr().solve(right);
  return {static_cast<double>(solution(0)), static_cast<double>(solution(1))};
}

TEST(DepthAlignment, squares_equal_the_closed_form) {
  DepthMap reference = ball_depth();
  const Image<float> v = relative_inverse(reference, truth);
  add_noise(reference, 0.05, 1);
  Image<float> weights(v.size());
  for (std::size_t p = 0; p < weights.pixels().size(); ++p) weights.pixels()[p] = static_cast<float>(1 + p % 7);
  const Image<float>* const all_alike = nullptr;
  for (const Image<float>* w : {all_alike, static_cast<const Image<float>*>(&weights)}) {
    const FrameAlignment frame = align_one(v, reference, all_samples(), nullptr, w);
    const AlignmentLine wanted = closed_form(v, reference, w);
    EXPECT_NEAR(frame.line.scale / wanted.scale, 1, 1e-10);
    EXPECT_NEAR(frame.line.shift / wanted.shift, 1, 1e-10);
    EXPECT_EQ(frame.status, AlignmentStatus::solved);
    EXPECT_EQ(frame.samples, v.size().pixels());
    EXPECT_EQ(frame.inliers, frame.samples);
    EXPECT_TRUE(frame.reason.empty()) << frame.reason;
  }
}

TEST(DepthAlignment, finds_the_line_of_every_model_and_loss) {
  const DepthMap reference = ball_depth();
  for (const auto loss : {AlignmentLoss::squared, AlignmentLoss::huber, AlignmentLoss::cauchy}) {
    for (const auto model : {AlignmentModel::inverse_affine, AlignmentModel::inverse_scale,
                             AlignmentModel::depth_affine, AlignmentModel::depth_scale}) {
      for (const auto relative : {RelativeDepth::inverse, RelativeDepth::depth}) {
        SCOPED_TRACE(fmt::format("{} {} {}", to_string(loss), to_string(model), static_cast<int>(relative)));
        const bool inverse = model == AlignmentModel::inverse_affine || model == AlignmentModel::inverse_scale;
        const bool shift = model == AlignmentModel::inverse_affine || model == AlignmentModel::depth_affine;
        const AlignmentLine line{0.37, shift ? 0.05 : 0.0};
        Image<float> picture(reference.size());
        for (std::size_t p = 0; p < picture.pixels().size(); ++p) {
          const double z = static_cast<double>(reference.pixels()[p]);
          const double x = ((inverse ? 1 / z : z) - line.shift) / line.scale;
          picture.pixels()[p] = static_cast<float>(inverse == (relative == RelativeDepth::inverse) ? x : 1 / x);
        }
        AlignmentOptions options = all_samples(loss);
        options.model = model;
        options.relative = relative;
        const FrameAlignment frame = align_one(picture, reference, options);
        expect_line(frame.line, line, 1e-5);
        EXPECT_DEPTH_NEAR(aligned_depth(picture, frame, options), reference, 1e-5);
      }
    }
  }
}

TEST(DepthAlignment, subset_is_seeded_sized_and_close_to_all) {
  DepthMap reference = ball_depth();
  const Image<float> v = relative_inverse(reference, truth);
  add_noise(reference, 0.02, 2);
  AlignmentOptions options;
  const FrameAlignment quarter = align_one(v, reference, options), again = align_one(v, reference, options);
  EXPECT_EQ(quarter.samples, v.size().pixels() / 4);
  EXPECT_EQ(quarter.candidates, v.size().pixels());
  EXPECT_EQ(quarter.line, again.line);
  options.seed = 7;
  const FrameAlignment other = align_one(v, reference, options);
  EXPECT_NE(other.line, quarter.line);
  expect_line(quarter.line, align_one(v, reference, all_samples()).line, 0.01);
  expect_line(other.line, quarter.line, 0.01);
}

TEST(DepthAlignment, huber_and_cauchy_survive_nine_wrong_samples_in_ten) {
  const DepthMap clean = ball_depth();
  const Image<float> v = relative_inverse(clean, truth);
  double squared_error = 0;
  for (std::uint32_t seed = 0; seed < 5; ++seed) {
    DepthMap reference = clean;
    add_noise(reference, 0.02, seed);
    add_outliers(reference, 0.9, 0.5, 6, seed + 100);
    for (const auto loss : {AlignmentLoss::huber, AlignmentLoss::cauchy}) {
      const FrameAlignment frame = align_one(v, reference, all_samples(loss));
      EXPECT_EQ(frame.status, AlignmentStatus::solved);
      expect_line(frame.line, truth, 0.05);
      EXPECT_LT(frame.inliers, frame.samples / 2);
    }
    squared_error += std::fabs(align_one(v, reference, all_samples()).own.scale - truth.scale) / truth.scale;
  }
  EXPECT_GT(squared_error / 5, 0.5) << "the test's wrong samples do no harm: it proves nothing";
}

TEST(DepthAlignment, mask_and_weights_choose_the_samples) {
  DepthMap reference = ball_depth();
  const Image<float> v = relative_inverse(reference, truth);
  ValidityMask mask(v.size());
  Image<float> weights(v.size());
  for (int y = 0; y < v.height(); ++y)
    for (int x = 0; x < v.width(); ++x) {
      const bool good = y % 3 == 0;
      mask(x, y) = good;
      weights(x, y) = good ? 2.0F : 0.0F;
      if (!good) reference(x, y) = static_cast<float>(1 + x);
    }
  for (const FrameAlignment& frame :
       {align_one(v, reference, all_samples(), &mask), align_one(v, reference, all_samples(), nullptr, &weights)}) {
    EXPECT_EQ(frame.candidates, mask.count());
    expect_line(frame.line, truth, 1e-5);
  }
}

TEST(DepthAlignment, momentum_is_the_running_mean_and_keeps_through_gaps) {
  Clip clip;
  const std::vector<AlignmentLine> lines{{0.4, 0.02}, {0.5, 0.03}, {0.3, 0.01}, {0.6, 0.05}};
  for (const AlignmentLine& line : lines) {
    clip.references.push_back(ball_depth());
    clip.relatives.push_back(relative_inverse(clip.references.back(), line));
    clip.masks.emplace_back(clip.references.back().size(), std::uint8_t{1});
  }
  clip.masks[2].fill(0);
  AlignmentOptions options = all_samples();
  options.momentum = 0.9;
  const AlignmentSummary summary = align(clip, options);
  AlignmentLine running = lines[0];
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (i > 0 && i != 2)
      running = {0.9 * running.scale + 0.1 * lines[i].scale, 0.9 * running.shift + 0.1 * lines[i].shift};
    expect_line(summary.frames[i].line, running, 1e-5);
  }
  EXPECT_EQ(summary.frames[2].status, AlignmentStatus::kept_previous_empty);
  EXPECT_THAT(summary.frames[2].reason, HasSubstr("line before is kept"));
  EXPECT_EQ(summary.brief(), "4 frames: 3 solved, 1 kept_previous_empty");
}

/// A clip whose true line drifts (1: by a fifth in scale, to the opposite in shift) while every frame's reference is
/// off by a scale of its own, as estimators flicker.
Clip flickering_clip(int frames, double flicker, double drift, std::vector<AlignmentLine>& lines) {
  Clip clip;
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0, flicker);
  const DepthMap clean = ball_depth(1, {48, 32});
  for (int i = 0; i < frames; ++i) {
    const double phase = 3.14159 * i / frames;
    lines.push_back({0.37 * (1 + 0.2 * drift * std::sin(phase)), 0.05 * std::cos(drift * phase)});
    clip.relatives.push_back(relative_inverse(clean, lines.back()));
    DepthMap reference = clean;
    const double wrong = std::exp(noise(random));
    for (float& z : reference.pixels()) z = static_cast<float>(static_cast<double>(z) * wrong);
    add_noise(reference, 0.02, static_cast<std::uint32_t>(i));
    clip.references.push_back(std::move(reference));
  }
  return clip;
}

/// Mean relative error of aligned inverse depth over the clip.
double error_of(const AlignmentSummary& summary, const Clip& clip, const std::vector<AlignmentLine>& lines) {
  double sum = 0, count = 0;
  for (std::size_t i = 0; i < lines.size(); ++i)
    for (const float value : clip.relatives[i].pixels()) {
      const double x = static_cast<double>(value), wanted = lines[i].scale * x + lines[i].shift;
      sum += std::fabs(summary.frames[i].line.scale * x + summary.frames[i].line.shift - wanted) / wanted;
      ++count;
    }
  return sum / count;
}

TEST(DepthAlignment, joint_is_closer_to_truth_than_momentum_on_flickering_clips) {
  for (const double drift : {0.0, 0.3, 1.0}) {
    SCOPED_TRACE(fmt::format("drift {}", drift));
    std::vector<AlignmentLine> lines;
    const Clip clip = flickering_clip(120, 0.05, drift, lines);
    AlignmentOptions options;
    options.smoothing = AlignmentSmoothing::none;
    const double none = error_of(align(clip, options), clip, lines);
    options.smoothing = AlignmentSmoothing::momentum;
    const double official = error_of(align(clip, options), clip, lines);
    double best = official;
    for (const double keep : {0.5, 0.7, 0.8, 0.9, 0.95}) {
      options.momentum = keep;
      best = std::min(best, error_of(align(clip, options), clip, lines));
    }
    options.smoothing = AlignmentSmoothing::joint;
    const double joint = error_of(align(clip, options), clip, lines);
    const std::string figures = fmt::format("none {:.4f}, momentum 0.99 {:.4f}, best momentum {:.4f}, joint {:.4f}",
                                            none, official, best, joint);
    RecordProperty(fmt::format("drift_{}", drift), figures);
    EXPECT_LT(joint, 0.4 * none) << figures;
    EXPECT_LT(joint, (drift > 0 ? 0.5 : 0.95) * best) << figures;
    EXPECT_LT(joint, (drift > 0 ? 0.3 : 0.95) * official) << figures;
  }
}

TEST(DepthAlignment, joint_without_smoothness_is_each_frame_alone) {
  std::vector<AlignmentLine> lines;
  const Clip clip = flickering_clip(6, 0.05, 1, lines);
  AlignmentOptions options = all_samples();
  options.smoothing = AlignmentSmoothing::joint;
  options.smooth_frames = 0;
  const AlignmentSummary summary = align(clip, options);
  for (const FrameAlignment& frame : summary.frames) expect_line(frame.line, frame.own, 1e-9);
}

TEST(DepthAlignment, joint_fills_empty_and_flat_frames_from_both_sides) {
  Clip clip;
  for (int i = 0; i < 9; ++i) {
    clip.references.push_back(ball_depth());
    clip.relatives.push_back(relative_inverse(clip.references.back(), truth));
    clip.masks.emplace_back(clip.references.back().size(), std::uint8_t{1});
  }
  clip.masks[0].fill(0);
  clip.masks[4].fill(0);
  clip.references[6].fill(2);
  clip.relatives[6].fill(static_cast<float>((0.5 - truth.shift) / truth.scale));
  AlignmentOptions options = all_samples();
  options.smoothing = AlignmentSmoothing::joint;
  const AlignmentSummary summary = align(clip, options);
  for (const FrameAlignment& frame : summary.frames) {
    EXPECT_TRUE(frame.usable);
    expect_line(frame.line, truth, 1e-4);
  }
  EXPECT_EQ(summary.frames[0].status, AlignmentStatus::kept_previous_empty);
  EXPECT_EQ(summary.frames[6].status, AlignmentStatus::kept_previous_singular);
}

TEST(DepthAlignment, threads_do_not_change_the_result_and_the_monitor_can_stop) {
  std::vector<AlignmentLine> lines;
  const Clip clip = flickering_clip(7, 0.05, 1, lines);
  for (const auto loss : {AlignmentLoss::squared, AlignmentLoss::cauchy}) {
    AlignmentOptions options;
    options.loss = loss;
    const AlignmentSummary one = align(clip, options, 1), three = align(clip, options, 3);
    for (std::size_t i = 0; i < one.frames.size(); ++i) EXPECT_EQ(one.frames[i].line, three.frames[i].line);
  }
  struct Impatient : Monitor {
    bool progress(std::string_view, long done, long) override { return done < 2; }
  } impatient;
  ThreadPool pool(1);
  EXPECT_THROW(align_depth(clip.frames(), {}, pool, impatient), Error);
}

TEST(DepthAlignment, floor_makes_a_far_wall_or_invalid) {
  Image<float> v(3, 1);
  v(0, 0) = 1;
  v(1, 0) = 0.1F;
  v(2, 0) = std::numeric_limits<float>::quiet_NaN();
  FrameAlignment frame;
  frame.line = {1, -0.5};
  frame.usable = true;
  AlignmentOptions options;
  DepthMap depth = aligned_depth(v, frame, options);
  EXPECT_FLOAT_EQ(depth(0, 0), 2);
  EXPECT_EQ(depth(1, 0), 0);
  EXPECT_EQ(depth(2, 0), 0);
  options.inverse_floor = 1e-3;
  depth = aligned_depth(v, frame, options);
  EXPECT_FLOAT_EQ(depth(1, 0), 1000);
  EXPECT_EQ(depth(2, 0), 0);
}

TEST(DepthAlignment, sample_selection_shrinks_filters_and_cuts) {
  ThreadPool pool(1);
  Image<float> v(40, 30, 0.5F);
  for (int y = 0; y < 30; ++y) v(20, y) = 0.9F;
  v(30, 15) = 1e-4F;
  ForegroundMask foreground(40, 30);
  for (int y = 5; y < 25; ++y)
    for (int x = 5; x < 35; ++x) foreground(x, y) = 1;
  const ValidityMask samples = alignment_samples(v, foreground, {}, pool);
  EXPECT_EQ(samples(8, 15), 0);  // shrunk by 4
  EXPECT_EQ(samples(9, 15), 1);
  EXPECT_EQ(samples(18, 15), 0);  // beside the edge
  EXPECT_EQ(samples(17, 15), 1);
  EXPECT_EQ(samples(30, 15), 0);
}

TEST(DepthAlignment, refuses_options_and_pictures_that_make_no_sense) {
  AlignmentOptions options;
  options.share = 0;
  EXPECT_THROW(DepthAligner{options}, std::invalid_argument);
  options = {};
  options.momentum = 1;
  EXPECT_THROW(DepthAligner{options}, std::invalid_argument);
  options = {};
  options.loss_scale = std::nan("");
  EXPECT_THROW(DepthAligner{options}, std::invalid_argument);
  DepthAligner aligner({});
  const Image<float> v(3, 2);
  const DepthMap other(2, 3);
  EXPECT_THROW(aligner.add({&v, nullptr, nullptr, nullptr}), std::invalid_argument);
  EXPECT_THROW(aligner.add({&v, &other, nullptr, nullptr}), std::invalid_argument);
}

}  // namespace
}  // namespace uwv::testing
