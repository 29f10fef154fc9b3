// SPDX-License-Identifier: Apache-2.0
// Depth from synthetic clips against the truth, and what confidence is worth.
#include "uwv/geometry/multi_view_stereo.h"

#include <gtest/gtest.h>

#include "geometry/mvs/clip.h"
#include "uwv/eval/depth_metrics.h"

namespace uwv {
namespace {

using test::Clip;
using test::DepthError;

struct Outcome {
  std::vector<FrameGeometry> frames;
  MvsSummary summary;
};

Outcome run(const Clip& clip, const MvsOptions& options = {}, int threads = 2,
            const std::vector<ValidityMask>& masks = {}) {
  ThreadPool pool(threads);
  Monitor monitor;
  Outcome out;
  out.summary = multi_view_stereo(clip.frames, clip.cameras, clip.points, masks, options, pool, monitor, out.frames);
  return out;
}

Clip room_clip(int count = 9, double degrees = 12, Size size = {240, 144}) {
  ThreadPool pool(2);
  return test::orbit_clip(boxes_room(test::small_scene(size)), count, degrees, pool);
}

Clip ball_clip(int count = 9, double degrees = 12) {
  ThreadPool pool(2);
  return test::orbit_clip(sphere_floor_wall(test::small_scene()), count, degrees, pool);
}

std::string describe(const DepthError& e) {
  return fmt::format("known {:.3f} measured {:.3f} rel all {:.4f} measured {:.4f} filled {:.4f} far off {:.4f}",
                     e.known, e.measured, e.rel_all, e.rel_measured, e.rel_filled, e.far_off);
}

TEST(MultiViewStereo, MeasuresARoomOfBoxes) {
  const Clip clip = room_clip();
  const Outcome result = run(clip);
  const DepthError e = test::mean_error(result.frames, clip.truth);
  EXPECT_GT(e.measured, 0.7) << describe(e);
  EXPECT_NEAR(e.known, 1.0, 1e-9) << describe(e);
  EXPECT_LT(e.rel_measured, 0.015) << describe(e);
  EXPECT_LT(e.rel_all, 0.03) << describe(e);
}

TEST(MultiViewStereo, MeasuresABallBeforeAWall) {
  const Clip clip = ball_clip();
  const Outcome result = run(clip);
  const DepthError e = test::mean_error(result.frames, clip.truth);
  EXPECT_GT(e.measured, 0.7) << describe(e);
  EXPECT_LT(e.rel_measured, 0.015) << describe(e);
  EXPECT_LT(e.rel_all, 0.03) << describe(e);
}

TEST(MultiViewStereo, WhatIsConfidentIsMoreAccurate) {
  const Clip clip = room_clip();
  const DepthError e = test::mean_error(run(clip).frames, clip.truth);
  EXPECT_LT(2 * e.rel_measured, e.rel_filled) << describe(e);
}

TEST(MultiViewStereo, WithoutCompletionOnlyMeasurementsRemain) {
  const Clip clip = room_clip(5, 8);
  MvsOptions options;
  options.complete = false;
  for (const FrameGeometry& frame : run(clip, options).frames)
    for (const float c : frame.confidence.pixels()) ASSERT_TRUE(c == 0 || c >= 0.5F) << c;
}

TEST(MultiViewStereo, DoesNotSmearDepthAcrossTheBallsOutline) {
  // Depth of a pixel beside the outline belongs to one of the two surfaces, hardly ever to the gap between them.
  const Clip clip = ball_clip();
  const Outcome result = run(clip);
  const std::size_t middle = clip.frames.size() / 2;
  const DepthMap& truth = clip.truth[middle];
  int beside = 0;
  int between = 0;
  for (int y = 2; y + 2 < truth.height(); ++y) {
    for (int x = 2; x + 2 < truth.width(); ++x) {
      float nearest = truth(x, y);
      float farthest = truth(x, y);
      for (int dx = -2; dx <= 2; ++dx) {
        nearest = std::min(nearest, truth(x + dx, y));
        farthest = std::max(farthest, truth(x + dx, y));
      }
      if (farthest < 1.3F * nearest) continue;
      ++beside;
      const float z = result.frames[middle].depth(x, y);
      if (z > 1.12F * nearest && z < farthest / 1.12F) ++between;
    }
  }
  ASSERT_GT(beside, 100);
  EXPECT_LT(between, 0.2 * beside) << between << " of " << beside;
}

/// Windows of matching widen what is near by two to four pixels; an edge counts as found within one.
DepthEdgeScore edges_of(const Outcome& result, const Clip& clip) {
  std::vector<DepthEdgeScore> scores;
  for (std::size_t i = 0; i < clip.truth.size(); ++i)
    scores.push_back(compare_depth_edges(result.frames[i].depth, clip.truth[i]));
  return pooled(scores);
}

TEST(MultiViewStereo, PutsTheBallsOutlineWhereItIs) {
  const Clip clip = ball_clip();
  const Outcome result = run(clip);
  const DepthError e = test::mean_error(result.frames, clip.truth);
  EXPECT_GT(edges_of(result, clip).f, 0.66);
  EXPECT_LT(e.rel_all, 0.0095) << describe(e);
}

TEST(MultiViewStereo, PutsTheBoxesOutlinesWhereTheyAre) {
  const Clip clip = room_clip();
  const Outcome result = run(clip);
  const DepthError e = test::mean_error(result.frames, clip.truth);
  EXPECT_GT(edges_of(result, clip).f, 0.58);
  EXPECT_LT(e.rel_all, 0.0212) << describe(e);
}

TEST(MultiViewStereo, ToleratesAFrameOfAnotherExposure) {
  Clip clip = room_clip();
  const double before = test::mean_error(run(clip).frames, clip.truth).rel_all;
  for (Rgb8& p : clip.frames[4].pixels())
    p = {static_cast<std::uint8_t>(p.r * 3 / 4), static_cast<std::uint8_t>(p.g * 3 / 4),
         static_cast<std::uint8_t>(p.b * 3 / 4)};
  const DepthError e = test::mean_error(run(clip).frames, clip.truth);
  EXPECT_LT(e.rel_all, 1.3 * before + 0.002) << describe(e);
  EXPECT_GT(e.measured, 0.65) << describe(e);
}

TEST(MultiViewStereo, CarriesDepthToFramesBetweenKeys) {
  const Clip clip = room_clip(13, 12);
  MvsOptions options;
  options.key_stride = 4;
  const Outcome result = run(clip, options);
  EXPECT_EQ(result.summary.matched_frames, 4);
  const DepthError e = test::error_of(result.frames[6], clip.truth[6]);
  const DepthError at_key = test::error_of(result.frames[8], clip.truth[8]);
  EXPECT_LT(e.rel_measured, 1.3 * at_key.rel_measured + 0.002) << describe(e) << "; key: " << describe(at_key);
  EXPECT_GT(e.measured, 0.9 * at_key.measured) << describe(e) << "; key: " << describe(at_key);
  EXPECT_LT(e.rel_all, 1.3 * at_key.rel_all + 0.004) << describe(e) << "; key: " << describe(at_key);
}

TEST(MultiViewStereo, TheLastFrameIsAKeyWhateverTheStride) {
  const Clip clip = room_clip(6, 8);
  MvsOptions options;
  options.key_stride = 100;
  const Outcome result = run(clip, options);
  EXPECT_EQ(result.summary.matched_frames, 2);
  EXPECT_EQ(result.frames.size(), 6U);
}

TEST(MultiViewStereo, ResultDoesNotDependOnThreads) {
  const Clip clip = room_clip(5, 8);
  const Outcome one = run(clip, {}, 1);
  const Outcome three = run(clip, {}, 3);
  for (std::size_t i = 0; i < one.frames.size(); ++i) {
    EXPECT_TRUE(one.frames[i].depth == three.frames[i].depth) << "frame " << i;
    EXPECT_TRUE(one.frames[i].confidence == three.frames[i].confidence) << "frame " << i;
  }
}

TEST(MultiViewStereo, MoreViewsMeasureMore) {
  const Clip clip = room_clip();
  MvsOptions two;
  two.neighbours = 1;
  MvsOptions six;
  six.neighbours = 6;
  EXPECT_GT(run(clip, six).summary.measured_share, run(clip, two).summary.measured_share);
}

}  // namespace
}  // namespace uwv
