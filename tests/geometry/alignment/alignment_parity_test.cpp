// SPDX-License-Identifier: Apache-2.0
// Aligned depth against the official code's numbers. Both draw their samples at random, so the drawn masks are given.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "support/fixture_tensors.h"
#include "support/matchers.h"
#include "uwv/geometry/depth_alignment.h"
#include "uwv/geometry/depth_composite.h"

namespace uwv::testing {
namespace {

AlignmentOptions official() {
  AlignmentOptions options;
  options.share = 1;
  options.official_empty = true;
  options.refuse_negative = false;
  options.inverse_floor = 1e-3;
  return options;
}

SafeTensors fixture(const std::string& name) { return SafeTensors::open(fixture_folder("alignment") + "/" + name); }

AlignmentSummary aligned(const SafeTensors& pictures, const SafeTensors& masks, const AlignmentOptions& options) {
  const Golden v(pictures, "in.video_depth_inv"), depth(pictures, "in.prompt_depth"), mask(masks, "sparse_masks");
  DepthAligner aligner(options);
  for (std::size_t i = 0; i < v.shape().front(); ++i) {
    const auto relative = v.picture<Image<float>>(i);
    const auto reference = depth.picture<DepthMap>(i);
    const auto samples = mask.picture<ValidityMask>(i);
    aligner.add({&relative, &reference, &samples, nullptr});
  }
  return aligner.finish();
}

/// The official solver works in float32; its fixture's notes measure 9.6e-7 and 4.7e-6 against float64.
void expect_lines(const AlignmentSummary& ours, const SafeTensors& wanted) {
  const Golden scale(wanted, "scale_raw"), bias(wanted, "bias_raw");
  const Golden smooth_scale(wanted, "scale_smoothed"), smooth_bias(wanted, "bias_smoothed");
  ASSERT_EQ(ours.frames.size(), scale.shape().front());
  for (std::size_t i = 0; i < ours.frames.size(); ++i) {
    SCOPED_TRACE(fmt::format("frame {}", i));
    const FrameAlignment& frame = ours.frames[i];
    EXPECT_NEAR(frame.own.scale, static_cast<double>(scale.at(i)), 2e-6);
    EXPECT_NEAR(frame.own.shift, static_cast<double>(bias.at(i)), 1e-5);
    EXPECT_NEAR(frame.line.scale, static_cast<double>(smooth_scale.at(i)), 2e-6);
    EXPECT_NEAR(frame.line.shift, static_cast<double>(smooth_bias.at(i)), 1e-5);
  }
}

TEST(AlignmentParity, lines_and_depth_of_a_sequence) {
  const SafeTensors file = fixture("sequence.safetensors");
  const AlignmentOptions options = official();
  const AlignmentSummary ours = aligned(file, file, options);
  expect_lines(ours, file);
  EXPECT_EQ(ours.frames.at(6).status, AlignmentStatus::zero_empty);
  EXPECT_EQ(ours.frames.at(4).status, AlignmentStatus::negative_scale);
  const Golden v(file, "in.video_depth_inv"), depth(file, "aligned_depth");
  // What the lines may differ by, in inverse depth; near the far wall that is a thousandth of the depth itself.
  double worst = 0;
  for (std::size_t i = 0; i < ours.frames.size(); ++i) {
    const DepthMap mine = aligned_depth(v.picture<Image<float>>(i), ours.frames[i], options);
    const auto theirs = depth.picture<DepthMap>(i);
    for (std::size_t p = 0; p < mine.pixels().size(); ++p)
      worst = std::max(
          worst, std::fabs(1 / static_cast<double>(mine.pixels()[p]) - 1 / static_cast<double>(theirs.pixels()[p])));
  }
  EXPECT_LE(worst, 5e-6);
}

TEST(AlignmentParity, lines_after_an_empty_first_frame) {
  const SafeTensors file = fixture("sequence_first_empty.safetensors");
  const AlignmentSummary ours = aligned(fixture("sequence.safetensors"), file, official());
  EXPECT_EQ(ours.frames.at(0).status, AlignmentStatus::zero_empty);
  expect_lines(ours, file);
}

/// Our default keeps the line before, where the official code mixes a zero in: after the empty frame it stays where it
/// was, and the official one has lost one part in a hundred.
TEST(AlignmentParity, keeping_differs_from_the_official_code_only_after_the_empty_frame) {
  const SafeTensors file = fixture("sequence.safetensors");
  AlignmentOptions options = official();
  options.official_empty = false;
  const AlignmentSummary ours = aligned(file, file, options);
  const Golden smooth_scale(file, "scale_smoothed");
  EXPECT_NEAR(ours.frames[5].line.scale, static_cast<double>(smooth_scale.at(5)), 2e-6);
  EXPECT_EQ(ours.frames[6].line, ours.frames[5].line);
  EXPECT_NEAR(static_cast<double>(smooth_scale.at(6)), 0.99 * ours.frames[6].line.scale, 2e-6);
}

/// The drawn samples are a quarter of what our selection offers, all of them among it.
TEST(AlignmentParity, sample_selection) {
  const SafeTensors file = fixture("sequence.safetensors");
  const Golden v(file, "in.video_depth_inv"), mask(file, "in.align_mask"), sparse(file, "sparse_masks");
  ThreadPool pool(1);
  std::size_t offered = 0, drawn = 0, outside = 0;
  for (std::size_t i = 0; i < v.shape().front(); ++i) {
    const ValidityMask ours = alignment_samples(v.picture<Image<float>>(i), mask.picture<ForegroundMask>(i), {}, pool);
    const auto theirs = sparse.picture<ValidityMask>(i);
    offered += ours.count();
    drawn += theirs.count();
    for (std::size_t p = 0; p < ours.pixels().size(); ++p) outside += theirs.pixels()[p] != 0 && ours.pixels()[p] == 0;
    EXPECT_EQ(theirs.count(), ours.count() / 4) << "frame " << i;
  }
  EXPECT_EQ(outside, 0U);
  EXPECT_GT(drawn, 0U);
  EXPECT_GT(offered, drawn);
}

double quantile(std::vector<float> values, double share) {
  std::sort(values.begin(), values.end());
  const double at = share * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::size_t>(at);
  const double low = static_cast<double>(values[below]);
  const double high = static_cast<double>(values[std::min(below + 1, values.size() - 1)]);
  return low + (high - low) * (at - static_cast<double>(below));
}

/// The official outlier test: both inverse depths between their tenth and ninetieth percentile, those of the reference
/// taken inside the mask but applied everywhere.
ValidityMask between_quantiles(const Image<float>& v, const DepthMap& depth, const ValidityMask* mask) {
  std::vector<float> sources, targets;
  for (std::size_t p = 0; p < v.pixels().size(); ++p) {
    if (v.pixels()[p] > 0) sources.push_back(v.pixels()[p]);
    if (depth.pixels()[p] > 0 && (mask == nullptr || mask->pixels()[p] != 0))
      targets.push_back(1.0F / depth.pixels()[p]);
  }
  const double low_v = quantile(sources, 0.1), high_v = quantile(sources, 0.9);
  const double low_y = quantile(targets, 0.1), high_y = quantile(targets, 0.9);
  ValidityMask out(v.size());
  for (std::size_t p = 0; p < v.pixels().size(); ++p) {
    const double x = static_cast<double>(v.pixels()[p]), y = static_cast<double>(1.0F / depth.pixels()[p]);
    out.pixels()[p] = x > low_v && x < high_v && y > low_y && y < high_y;
  }
  return out;
}

TEST(AlignmentParity, the_function_alone) {
  const SafeTensors pictures = fixture("sequence.safetensors"), file = fixture("function.safetensors");
  const Golden v(pictures, "in.video_depth_inv"), depth(pictures, "in.prompt_depth"), mask(pictures, "in.align_mask");
  int cases = 0;
  for (const std::string& name : file.names()) {
    if (!name.ends_with(".scale")) continue;
    SCOPED_TRACE(name);
    const std::string stem = name.substr(0, name.size() - 6);
    const std::size_t frame = static_cast<std::size_t>(std::stoi(stem.substr(5)));
    const auto relative = v.picture<Image<float>>(frame);
    const auto reference = depth.picture<DepthMap>(frame);
    const auto given = mask.picture<ValidityMask>(frame);
    ValidityMask samples = given;
    if (stem.ends_with("q1")) samples = between_quantiles(relative, reference, frame == 7 ? nullptr : &given);
    DepthAligner aligner(official());
    aligner.add({&relative, &reference, &samples, nullptr});
    const FrameAlignment ours = aligner.finish().frames.front();
    EXPECT_NEAR(ours.line.scale, static_cast<double>(Golden(file, name).at(0)), 2e-6);
    EXPECT_NEAR(ours.line.shift, static_cast<double>(Golden(file, stem + ".bias").at(0)), 1e-5);
    ++cases;
  }
  EXPECT_EQ(cases, 5);
}

}  // namespace
}  // namespace uwv::testing
