// SPDX-License-Identifier: Apache-2.0
#include "uwv/geometry/background_completion.h"

#include <gtest/gtest.h>

#include <cmath>

#include "geometry/layers/layer_clips.h"

namespace uwv {
namespace {

using layer_clips::Clip;

BackgroundClip complete(const Clip& clip, const CompletionOptions& options = {}, int threads = 2) {
  ThreadPool pool(threads);
  Monitor monitor;
  return complete_background(clip.frames, clip.masks, options, pool, monitor);
}

/// Mean absolute difference of the pixels of one origin, in grey levels.
double error(const Clip& clip, const BackgroundClip& result, BackgroundOrigin origin) {
  double sum = 0, count = 0;
  for (std::size_t f = 0; f < clip.frames.size(); ++f)
    for (std::size_t p = 0; p < clip.frames[f].pixels().size(); ++p) {
      if (result.origin[f].data()[p] != static_cast<std::uint8_t>(origin)) continue;
      const Rgb8 a = result.frames[f].data()[p], b = clip.walls[f].data()[p];
      sum += std::abs(a.r - b.r) + std::abs(a.g - b.g) + std::abs(a.b - b.b);
      count += 3;
    }
  return count > 0 ? sum / count : 0;
}

TEST(Background, StillCameraShowsWhatOthersSaw) {
  const Clip clip = layer_clips::sprite({160, 120}, 24, {.speed = 3});
  const BackgroundClip result = complete(clip);
  EXPECT_EQ(result.share_invented, 0) << result.brief();
  EXPECT_GT(result.share_seen, 0.05);
  EXPECT_EQ(error(clip, result, BackgroundOrigin::own), 0);
  EXPECT_LT(error(clip, result, BackgroundOrigin::seen), 0.5);
}

TEST(Background, MatchesExposure) {
  const Clip clip = layer_clips::sprite({160, 120}, 24, {.speed = 3, .exposure = 1.015});
  CompletionOptions options;
  const double matched = error(clip, complete(clip, options), BackgroundOrigin::seen);
  options.match_exposure = false;
  const double unmatched = error(clip, complete(clip, options), BackgroundOrigin::seen);
  EXPECT_LT(matched, 2.0);
  EXPECT_GT(unmatched, 2 * matched);
}

TEST(Background, InventsOnceForStillCamera) {
  const Clip clip = layer_clips::sprite({160, 120}, 5, {.speed = 1});
  const BackgroundClip result = complete(clip);
  EXPECT_GT(result.share_invented, 0.02);
  std::size_t compared = 0;
  for (std::size_t p = 0; p < clip.frames[0].pixels().size(); ++p) {
    if (result.origin[0].data()[p] != 2 || result.origin[4].data()[p] != 2) continue;
    const Rgb8 a = result.frames[0].data()[p], b = result.frames[4].data()[p];
    ASSERT_LE(std::abs(a.r - b.r) + std::abs(a.g - b.g) + std::abs(a.b - b.b), 6) << "flickers at " << p;
    ++compared;
  }
  EXPECT_GT(compared, 100U);
  // The disc is 80 levels brighter than the wall: nothing of it may be left.
  EXPECT_LT(error(clip, result, BackgroundOrigin::invented), 25);
}

TEST(Background, MovingCameraFindsItThroughHomographies) {
  const Clip clip = layer_clips::sprite({240, 160}, 20, {.speed = 5, .pan = -1.5});
  CompletionOptions options;
  options.camera_moves = true;
  const BackgroundClip result = complete(clip, options);
  EXPECT_TRUE(result.notes.empty()) << result.notes.front();
  EXPECT_GT(result.share_seen, 5 * result.share_invented) << result.brief();
  EXPECT_LT(error(clip, result, BackgroundOrigin::seen), 3.0);
  options.camera_moves = false;
  EXPECT_GT(error(clip, complete(clip, options), BackgroundOrigin::seen), 6.0) << "the pan must matter";
}

TEST(Background, DoesNotDependOnThreads) {
  const Clip clip = layer_clips::sprite({160, 120}, 8, {.speed = 4, .pan = -1});
  for (const bool moves : {false, true}) {
    CompletionOptions options;
    options.camera_moves = moves;
    EXPECT_EQ(complete(clip, options, 1).frames, complete(clip, options, 3).frames);
  }
}

TEST(Background, TakesExtremes) {
  for (const bool moves : {false, true})
    for (const Size size : {Size{1, 1}, Size{2, 90}, Size{64, 48}})
      for (const int frames : {1, 3})
        for (const std::uint8_t value : {std::uint8_t{0}, std::uint8_t{1}}) {
          Clip clip;
          clip.frames.assign(static_cast<std::size_t>(frames), ImageRgb(size, Rgb8{10, 20, 30}));
          clip.masks.assign(static_cast<std::size_t>(frames), ForegroundMask(size, value));
          CompletionOptions options;
          options.camera_moves = moves;
          const BackgroundClip result = complete(clip, options);
          EXPECT_EQ(result.share_invented, value);
          if (value == 0) {
            EXPECT_EQ(result.frames, clip.frames);
          }
        }
}

TEST(Background, RefusesWhatDoesNotFit) {
  Clip clip = layer_clips::sprite({20, 20}, 2, {});
  clip.masks.pop_back();
  EXPECT_THROW(complete(clip), std::invalid_argument);
  clip.masks.emplace_back(20, 21);
  EXPECT_THROW(complete(clip), std::invalid_argument);
}

}  // namespace
}  // namespace uwv
