// SPDX-License-Identifier: Apache-2.0
#include "model/video_windows.h"

#include <gtest/gtest.h>

#include <cmath>

namespace uwv::model {
namespace {

WindowRule official() { return {32, 10, 8, {0, 12, 24, 25, 26, 27, 28, 29, 30, 31}}; }

float truth(int frame, std::size_t pixel) {
  return static_cast<float>(2 + std::sin(0.3 * frame) + 0.5 * std::cos(0.7 * static_cast<double>(pixel)));
}

/// What a network sees of these frames, with a scale and shift of its own for the window.
std::vector<KnownMap> window_of(const std::vector<int>& frames, double scale, double shift) {
  std::vector<KnownMap> maps;
  for (const int frame : frames) {
    KnownMap map{FloatMap(Size{9, 7}), FloatMap(Size{9, 7}, 0.5F)};
    for (std::size_t p = 0; p < 63; ++p) map.value.data()[p] = static_cast<float>(scale * truth(frame, p) + shift);
    maps.push_back(std::move(map));
  }
  return maps;
}

TEST(VideoWindows, begin_with_the_key_frames_of_the_one_before) {
  const auto windows = plan_windows(official(), 60);
  ASSERT_EQ(windows.size(), 3U);
  EXPECT_EQ(std::vector<int>(windows[1].begin(), windows[1].begin() + 12),
            (std::vector<int>{0, 12, 24, 25, 26, 27, 28, 29, 30, 31, 32, 33}));
  // The first frame stays the first reference; the second is the middle of the window before.
  EXPECT_EQ(windows[2][0], 0);
  EXPECT_EQ(windows[2][1], 34);
  EXPECT_EQ(windows[2][2], 46);
  EXPECT_EQ(windows[2][10], 54);
  EXPECT_EQ(windows[2][31], 59) << "past the end, the last frame";
}

TEST(VideoWindows, are_as_many_as_are_needed) {
  for (const auto& [frames, count] : {std::pair{1, 1}, {32, 1}, {33, 2}, {54, 2}, {55, 3}})
    EXPECT_EQ(plan_windows(official(), frames).size(), static_cast<std::size_t>(count)) << frames;
  EXPECT_THROW(plan_windows(official(), 0), std::invalid_argument);
}

TEST(VideoWindows, joined_undo_each_windows_scale_and_shift) {
  for (const WindowRule& rule : {official(), WindowRule{8, 3, 3, {5, 6, 7}}, WindowRule{4, 1, 1, {3}}}) {
    for (const int frames : {1, 31, 33, 100}) {
      WindowJoiner joiner(rule, true);
      int number = 0;
      for (const auto& window : plan_windows(rule, frames)) {
        joiner.add(window_of(window, number == 0 ? 1 : 0.25 + 0.9 * number, number * 3.0));
        ++number;
      }
      const auto joined = joiner.take(frames);
      ASSERT_EQ(joined.size(), static_cast<std::size_t>(frames));
      for (int f = 0; f < frames; ++f)
        for (std::size_t p = 0; p < 63; ++p)
          ASSERT_NEAR(joined[static_cast<std::size_t>(f)].value.data()[p], truth(f, p), 2e-5) << "frame " << f;
    }
  }
}

TEST(VideoWindows, blend_linearly_over_the_last_frames) {
  const WindowRule rule = official();
  WindowJoiner joiner(rule, false);
  const auto windows = plan_windows(rule, 54);
  joiner.add(window_of(windows[0], 0, 1));
  joiner.add(window_of(windows[1], 0, 2));
  const auto joined = joiner.take(54);
  EXPECT_EQ(joined[23].value(0, 0), 1);
  for (int i = 0; i < 8; ++i)
    EXPECT_NEAR(joined[static_cast<std::size_t>(24 + i)].value(0, 0), 1 + i / 7.0, 1e-6) << "frame " << 24 + i;
  EXPECT_EQ(joined[32].value(0, 0), 2);
}

TEST(VideoWindows, leave_unknown_pixels_out) {
  const WindowRule rule = official();
  WindowJoiner joiner(rule, true);
  const auto windows = plan_windows(rule, 54);
  auto first = window_of(windows[0], 1, 0), second = window_of(windows[1], 2, 1);
  for (auto* window : {&first, &second}) {
    for (KnownMap& map : *window) {
      map.value(3, 3) = 1e20F;
      map.confidence(3, 3) = 0;
    }
  }
  second[4].confidence(0, 0) = 0;  // known in the first window only
  joiner.add(std::move(first));
  joiner.add(std::move(second));
  const auto joined = joiner.take(54);
  EXPECT_NEAR(joined[50].value(5, 5), truth(50, 5 * 9 + 5), 2e-5);
  EXPECT_EQ(joined[50].confidence(3, 3), 0);
  EXPECT_NEAR(joined[26].value(0, 0), truth(26, 0), 2e-5);
}

TEST(ScaleShiftFit, survives_pictures_without_variation_and_large_offsets) {
  const KnownMap flat{FloatMap(Size{5, 5}, 3.0F), FloatMap(Size{5, 5}, 1.0F)};
  const KnownMap other{FloatMap(Size{5, 5}, 7.0F), FloatMap(Size{5, 5}, 1.0F)};
  const ScaleShift fit = fit_scale_shift({&flat}, {&other});
  EXPECT_EQ(fit.scale, 1);
  EXPECT_EQ(fit.shift, 4);
  const KnownMap unknown{FloatMap(Size{5, 5}, 3.0F), FloatMap(Size{5, 5})};
  EXPECT_EQ(fit_scale_shift({&unknown}, {&other}).shift, 0);

  KnownMap far = flat, near = flat;
  for (std::size_t p = 0; p < 25; ++p) {
    far.value.data()[p] = 1e6F + static_cast<float>(p);
    near.value.data()[p] = 2 * static_cast<float>(p);
  }
  EXPECT_NEAR(fit_scale_shift({&far}, {&near}).scale, 2, 1e-12);
}

}  // namespace
}  // namespace uwv::model
