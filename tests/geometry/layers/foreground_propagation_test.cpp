// SPDX-License-Identifier: Apache-2.0
#include "uwv/geometry/foreground_propagation.h"

#include <gtest/gtest.h>

#include <cmath>

#include "geometry/layers/layer_clips.h"
#include "uwv/eval/stock_scenes.h"

namespace uwv {
namespace {

using layer_clips::Clip;
using layer_clips::overlap;

PropagationResult follow(const Clip& clip, const PropagationOptions& options = {}, int threads = 2,
                         ForegroundFinder* finder = nullptr) {
  ThreadPool pool(threads);
  Monitor monitor;
  return propagate_foreground(clip.frames, clip.masks.front(), finder, options, pool, monitor);
}

/// The stock scene's ball while it rolls, by the renderer's own object numbers.
Clip rolling_ball(int frames) {
  const StockScene stock = moving_ball({.size = {320, 184}});
  ThreadPool pool(2);
  int ball = 0;
  while (!stock.scene.objects[static_cast<std::size_t>(ball)].motion) ++ball;
  Clip clip;
  for (int i = 0; i < frames; ++i) {
    const SyntheticFrame frame = render(stock.scene, stock.source, stock.duration * i / 40.0, pool);
    clip.frames.push_back(frame.colour);
    ForegroundMask mask(frame.colour.size());
    for (std::size_t p = 0; p < mask.pixels().size(); ++p) mask.data()[p] = frame.object.data()[p] == ball;
    clip.masks.push_back(mask);
  }
  return clip;
}

TEST(Propagation, FollowsRollingBall) {
  const Clip clip = rolling_ball(19);
  const PropagationResult result = follow(clip);
  ASSERT_EQ(result.masks.size(), clip.masks.size());
  EXPECT_EQ(result.masks.front(), clip.masks.front());
  for (std::size_t i = 0; i < clip.masks.size(); i += 6)
    EXPECT_GT(overlap(result.masks[i], clip.masks[i]), 0.9) << "frame " << i;
}

TEST(Propagation, FollowsTexturedSpriteThatGrows) {
  const Clip clip = layer_clips::sprite({320, 200}, 30, {.speed = 4, .growth = 1.01});
  const PropagationResult result = follow(clip);
  EXPECT_GT(overlap(result.masks.back(), clip.masks.back()), 0.9);
  EXPECT_LT(result.masks.back().count(), 1.2 * static_cast<double>(clip.masks.back().count()));
}

TEST(Propagation, FollowsThroughMovingCamera) {
  const Clip clip = layer_clips::sprite({320, 200}, 20, {.speed = 3, .pan = -2});
  EXPECT_GT(overlap(follow(clip).masks.back(), clip.masks.back()), 0.9);
}

TEST(Propagation, DoesNotDependOnThreads) {
  const Clip clip = layer_clips::sprite({160, 120}, 12, {});
  EXPECT_EQ(follow(clip, {}, 1).masks, follow(clip, {}, 3).masks);
}

class Oracle : public ForegroundFinder {
 public:
  explicit Oracle(const Clip& clip) : clip_(clip) {}
  Image<float> find(const ImageRgb& picture) override {
    Image<float> out(picture.size());
    for (std::size_t i = 0; i < clip_.frames.size(); ++i)
      if (clip_.frames[i] == picture)
        std::copy(clip_.masks[i].pixels().begin(), clip_.masks[i].pixels().end(), out.pixels().begin());
    return out;
  }
  std::string name() const override { return "oracle"; }

 private:
  const Clip& clip_;
};

TEST(Propagation, ReanchoringMendsABadStart) {
  Clip clip = layer_clips::sprite({160, 120}, 11, {});
  const ForegroundMask truth = clip.masks.front();
  Oracle oracle(clip);
  Clip bad = clip;
  bad.masks.front() = close_gaps(truth, 6, 0);
  PropagationOptions options;
  options.colour_weight = 0;
  const double before = overlap(follow(bad, options).masks.back(), clip.masks.back());
  options.reanchor_every = 5;
  const PropagationResult mended = follow(bad, options, 2, &oracle);
  EXPECT_LT(before, 0.85);
  EXPECT_GT(overlap(mended.masks.back(), clip.masks.back()), 0.9);
  EXPECT_EQ(mended.notes.size(), 2U);
  EXPECT_THROW(follow(bad, options), std::invalid_argument);
}

TEST(Propagation, TakesExtremes) {
  for (const Size size : {Size{1, 1}, Size{3, 200}, Size{64, 48}})
    for (const std::uint8_t value : {std::uint8_t{0}, std::uint8_t{1}}) {
      Clip clip;
      clip.frames.assign(3, ImageRgb(size, Rgb8{9, 9, 9}));
      clip.masks.assign(3, ForegroundMask(size, value));
      const PropagationResult result = follow(clip);
      EXPECT_EQ(result.masks.back(), clip.masks.back()) << size.width << "x" << size.height;
    }
}

}  // namespace
}  // namespace uwv
