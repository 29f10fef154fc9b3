// SPDX-License-Identifier: Apache-2.0
// Aligning depth where there is little or nothing to align: every answer finite, every shortage said.
#include <gmock/gmock.h>

#include <limits>

#include "geometry/alignment/alignment_scene.h"
#include "support/matchers.h"

namespace uwv::testing {
namespace {

using ::testing::HasSubstr;

constexpr float nan_value = std::numeric_limits<float>::quiet_NaN();
constexpr float inf_value = std::numeric_limits<float>::infinity();
constexpr AlignmentLine truth{0.37, 0.05};

const std::vector<AlignmentLoss> losses{AlignmentLoss::squared, AlignmentLoss::huber, AlignmentLoss::cauchy};
const std::vector<AlignmentSmoothing> smoothings{AlignmentSmoothing::none, AlignmentSmoothing::momentum,
                                                 AlignmentSmoothing::joint};

/// Calls body(options) for every loss and smoothing.
template <class Body>
void for_all_options(const Body& body) {
  for (const AlignmentLoss loss : losses)
    for (const AlignmentSmoothing smoothing : smoothings) {
      SCOPED_TRACE(fmt::format("{} {}", to_string(loss), to_string(smoothing)));
      AlignmentOptions options;
      options.share = 1;
      options.loss = loss;
      options.smoothing = smoothing;
      body(options);
    }
}

void expect_finite(const AlignmentSummary& summary) {
  for (const FrameAlignment& f : summary.frames)
    for (const double value : {f.line.scale, f.line.shift, f.own.scale, f.own.shift, f.rms})
      EXPECT_TRUE(std::isfinite(value));
}

Clip clip_of(std::vector<Image<float>> relatives, std::vector<DepthMap> references) {
  Clip clip;
  clip.relatives = std::move(relatives);
  clip.references = std::move(references);
  return clip;
}

TEST(DepthAlignmentExtremes, magnitudes_cost_no_digits) {
  for (const double unit : {1e-8, 1e-3, 1.0, 1e3, 1e8})
    for (const double size_of_v : {1e-8, 1.0, 1e8})
      for_all_options([&](const AlignmentOptions& options) {
        SCOPED_TRACE(fmt::format("unit {}, v {}", unit, size_of_v));
        const AlignmentLine line{0.37 / unit / size_of_v, 0.05 / unit};
        const DepthMap reference = ball_depth(unit, {32, 24});
        const Image<float> v = relative_inverse(reference, line);
        const FrameAlignment frame = align_one(v, reference, options);
        EXPECT_EQ(frame.status, AlignmentStatus::solved);
        EXPECT_NEAR(frame.line.scale / line.scale, 1, 1e-5);
        EXPECT_NEAR(frame.line.shift / line.shift, 1, 1e-4);
        EXPECT_DEPTH_NEAR(aligned_depth(v, frame, options), reference, 1e-5);
      });
}

TEST(DepthAlignmentExtremes, large_offset_leaves_what_float_leaves) {
  // v around 1e4 with a spread of 1: float keeps 1e-3 of it.
  const DepthMap reference = ball_depth();
  const AlignmentLine line{0.37, 0.05 - 3700};
  const FrameAlignment frame = align_one(relative_inverse(reference, line), reference, [] {
    AlignmentOptions options;
    options.share = 1;
    return options;
  }());
  EXPECT_EQ(frame.status, AlignmentStatus::solved);
  EXPECT_NEAR(frame.line.scale, line.scale, 1e-3 * line.scale);
}

TEST(DepthAlignmentExtremes, constant_depth_keeps_the_line_before) {
  const DepthMap reference = ball_depth();
  const Image<float> v = relative_inverse(reference, truth);
  for_all_options([&](const AlignmentOptions& options) {
    for (const bool flat_reference : {true, false})
      for (const bool flat_relative : {true, false}) {
        if (!flat_reference && !flat_relative) continue;
        Image<float> second = v;
        DepthMap second_reference = reference;
        if (flat_relative) second.fill(0.7F);
        if (flat_reference) second_reference.fill(3);
        const AlignmentSummary summary = align(clip_of({v, second}, {reference, second_reference}), options);
        expect_finite(summary);
        EXPECT_EQ(summary.frames[1].status, AlignmentStatus::kept_previous_singular);
        EXPECT_THAT(summary.frames[1].reason, HasSubstr("one depth"));
        EXPECT_TRUE(summary.frames[1].usable);
        if (options.smoothing != AlignmentSmoothing::joint) {
          EXPECT_EQ(summary.frames[1].line, summary.frames[0].line);
        }
      }
  });
}

TEST(DepthAlignmentExtremes, constant_depth_is_enough_for_a_scale_alone) {
  for_all_options([](AlignmentOptions options) {
    options.model = AlignmentModel::inverse_scale;
    const FrameAlignment frame = align_one(Image<float>(8, 8, 0.5F), DepthMap(8, 8, 4.0F), options);
    EXPECT_EQ(frame.status, AlignmentStatus::solved);
    EXPECT_NEAR(frame.line.scale, 0.5, 1e-9);
    EXPECT_EQ(frame.line.shift, 0);
  });
}

TEST(DepthAlignmentExtremes, two_pixels_make_a_line_one_does_not) {
  Image<float> v(2, 1);
  v(0, 0) = 1;
  v(1, 0) = 2;
  DepthMap reference(2, 1);
  reference(0, 0) = 2;      // 0.5
  reference(1, 0) = 1.25F;  // 0.8
  for_all_options([&](AlignmentOptions options) {
    options.share = 0.01;  // never below what a line wants
    FrameAlignment frame = align_one(v, reference, options);
    EXPECT_EQ(frame.status, AlignmentStatus::solved);
    EXPECT_NEAR(frame.line.scale, 0.3, 1e-9);
    EXPECT_NEAR(frame.line.shift, 0.2, 1e-9);
    options.min_samples = 3;
    frame = align_one(v, reference, options);
    EXPECT_EQ(frame.status, AlignmentStatus::too_few);
    options.min_samples = 1;
    frame = align_one(Image<float>(1, 1, 1.0F), DepthMap(1, 1, 2.0F), options);
    EXPECT_EQ(frame.status, AlignmentStatus::too_few);
    EXPECT_FALSE(frame.usable);
    options.model = AlignmentModel::inverse_scale;
    frame = align_one(Image<float>(1, 1, 1.0F), DepthMap(1, 1, 2.0F), options);
    EXPECT_EQ(frame.status, AlignmentStatus::solved);
    EXPECT_NEAR(frame.line.scale, 0.5, 1e-12);
  });
}

TEST(DepthAlignmentExtremes, an_empty_first_frame_takes_the_first_line) {
  const DepthMap reference = ball_depth();
  const Image<float> v = relative_inverse(reference, truth);
  for_all_options([&](const AlignmentOptions& options) {
    const DepthMap unknown(v.size());
    const AlignmentSummary summary = align(clip_of({v, v, v}, {unknown, unknown, reference}), options);
    expect_finite(summary);
    EXPECT_EQ(summary.frames[0].status, AlignmentStatus::kept_previous_empty);
    for (const FrameAlignment& frame : summary.frames) {
      EXPECT_TRUE(frame.usable);
      EXPECT_NEAR(frame.line.scale, truth.scale, 1e-5);
    }
    EXPECT_FALSE(summary.frames[0].reason.empty());
  });
}

TEST(DepthAlignmentExtremes, a_clip_without_any_line_is_said_and_gives_no_depth) {
  for_all_options([](const AlignmentOptions& options) {
    const Image<float> v(8, 8, 1.0F);
    const AlignmentSummary summary = align(clip_of({v, v}, {DepthMap(8, 8), DepthMap(8, 8, 2.0F)}), options);
    expect_finite(summary);
    for (const FrameAlignment& frame : summary.frames) {
      EXPECT_FALSE(frame.usable);
      EXPECT_THAT(frame.reason, HasSubstr("no frame determines a line"));
      EXPECT_EQ(aligned_depth(v, frame, options), DepthMap(8, 8));
    }
    EXPECT_THAT(summary.brief(), HasSubstr("2 without any line"));
  });
  EXPECT_EQ(align({}, {}).brief(), "0 frames: 0 solved");
  EXPECT_FALSE(align(clip_of({Image<float>()}, {DepthMap()}), {}).frames[0].usable);
}

TEST(DepthAlignmentExtremes, a_falling_line_is_flagged_and_refused) {
  const DepthMap reference = ball_depth();
  const Image<float> v = relative_inverse(reference, truth), falling = relative_inverse(reference, {-0.37, 0.9});
  for (const AlignmentSmoothing smoothing : smoothings) {
    AlignmentOptions options;
    options.smoothing = smoothing;
    const AlignmentSummary kept = align(clip_of({v, falling}, {reference, reference}), options);
    EXPECT_EQ(kept.frames[1].status, AlignmentStatus::negative_scale);
    EXPECT_NEAR(kept.frames[1].own.scale, -0.37, 1e-5);
    if (smoothing != AlignmentSmoothing::joint) {
      EXPECT_EQ(kept.frames[1].line, kept.frames[0].line);
    }
    EXPECT_FALSE(align_one(falling, reference, options).usable);
  }
  AlignmentOptions options;
  options.refuse_negative = false;
  options.smoothing = AlignmentSmoothing::none;
  const FrameAlignment used = align_one(falling, reference, options);
  EXPECT_EQ(used.status, AlignmentStatus::negative_scale);
  EXPECT_TRUE(used.usable);
  EXPECT_NEAR(used.line.scale, -0.37, 1e-5);
}

TEST(DepthAlignmentExtremes, nan_inf_zero_and_negative_are_no_samples) {
  DepthMap reference = ball_depth();
  Image<float> v = relative_inverse(reference, truth);
  Image<float> weights(v.size(), 1.0F);
  const std::vector<float> bad{nan_value, inf_value, -inf_value, 0.0F, -1.0F};
  for (std::size_t i = 0; i < 300; ++i) {
    Image<float>& picture = i % 3 == 0 ? v : i % 3 == 1 ? reference : weights;
    picture.pixels()[7 * i] = bad[i % bad.size()];
  }
  reference.pixels()[2200] = 3e-20F;
  reference.pixels()[2300] = 3e20F;
  for_all_options([&](const AlignmentOptions& options) {
    DepthAligner aligner(options);
    aligner.add({&v, &reference, nullptr, &weights});
    const AlignmentSummary summary = aligner.finish();
    expect_finite(summary);
    EXPECT_EQ(summary.frames[0].candidates, v.size().pixels() - 302);
    EXPECT_NEAR(summary.frames[0].line.scale, truth.scale, 1e-5);
    const DepthMap depth = aligned_depth(v, summary.frames[0], options);
    for (const float z : depth.pixels()) EXPECT_TRUE(z == 0 || is_valid_depth(z));
  });
}

TEST(DepthAlignmentExtremes, the_longest_smoothing_fits_one_line_to_all_frames) {
  const DepthMap reference = ball_depth(1, {48, 32});
  constexpr int frames = 20;
  std::vector<Image<float>> relatives;
  Image<float> all_relative(48, 32 * frames);
  DepthMap all_reference(all_relative.size());
  for (int i = 0; i < frames; ++i) {
    relatives.push_back(relative_inverse(reference, {truth.scale * (i % 2 == 0 ? 0.9 : 1.1), 0.05}));
    std::copy_n(relatives.back().data(), 48 * 32, all_relative.row(32 * i));
    std::copy_n(reference.data(), 48 * 32, all_reference.row(32 * i));
  }
  AlignmentOptions options;
  options.share = 1;
  const AlignmentLine wanted = align_one(all_relative, all_reference, options).line;
  options.smoothing = AlignmentSmoothing::joint;
  options.smooth_frames = 1000;
  const AlignmentSummary summary = align(clip_of(relatives, std::vector<DepthMap>(frames, reference)), options);
  for (const FrameAlignment& frame : summary.frames) {
    EXPECT_NEAR(frame.line.scale, wanted.scale, 1e-4 * wanted.scale);
    EXPECT_NEAR(frame.line.shift, wanted.shift, 1e-4 * wanted.shift);
  }
}

TEST(DepthAlignmentExtremes, wild_values_never_give_nan) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> exponent(-37, 37);
  for_all_options([&](const AlignmentOptions& options) {
    for (int trial = 0; trial < 10; ++trial) {
      Image<float> v(9, 7), weights(9, 7);
      DepthMap reference(9, 7);
      for (std::size_t p = 0; p < v.pixels().size(); ++p) {
        v.pixels()[p] = static_cast<float>(std::pow(10.0, exponent(random)));
        weights.pixels()[p] = static_cast<float>(std::pow(10.0, exponent(random)));
        reference.pixels()[p] = static_cast<float>(std::pow(10.0, exponent(random) / 3));
      }
      for (const auto model : {AlignmentModel::inverse_affine, AlignmentModel::depth_scale}) {
        AlignmentOptions its = options;
        its.model = model;
        DepthAligner aligner(its);
        aligner.add({&v, &reference, nullptr, &weights});
        const AlignmentSummary summary = aligner.finish();
        expect_finite(summary);
        const DepthMap depth = aligned_depth(v, summary.frames[0], its);
        for (const float z : depth.pixels()) EXPECT_TRUE(z == 0 || is_valid_depth(z));
      }
    }
  });
}

}  // namespace
}  // namespace uwv::testing
