// SPDX-License-Identifier: Apache-2.0
#include "model/video_windows.h"

#include <algorithm>
#include <cmath>

#include "uwv/core/error.h"

namespace uwv::model {

std::vector<std::vector<int>> plan_windows(const WindowRule& rule, int frames) {
  require(frames > 0, "a clip of {} frames has no windows", frames);
  std::vector<std::vector<int>> windows;
  for (int first = 0; first == 0 || first + rule.overlap < frames; first += rule.step()) {
    std::vector<int> window(static_cast<std::size_t>(rule.frames));
    for (int i = 0; i < rule.frames; ++i) {
      const bool seen_before = first > 0 && i < rule.overlap;
      window[static_cast<std::size_t>(i)] =
          seen_before ? windows.back()[static_cast<std::size_t>(rule.keyframes[static_cast<std::size_t>(i)])]
                      : std::min(first + i, frames - 1);
    }
    windows.push_back(std::move(window));
  }
  return windows;
}

ScaleShift fit_scale_shift(const std::vector<const KnownMap*>& x, const std::vector<const KnownMap*>& y) {
  const auto for_known = [&](const auto& body) {
    for (std::size_t m = 0; m < x.size(); ++m) {
      const auto xs = x[m]->value.pixels(), ys = y[m]->value.pixels();
      const auto x_known = x[m]->confidence.pixels(), y_known = y[m]->confidence.pixels();
      for (std::size_t i = 0; i < xs.size(); ++i)
        if (x_known[i] > 0 && y_known[i] > 0) body(static_cast<double>(xs[i]), static_cast<double>(ys[i]));
    }
  };
  // Around the means, so that a large common offset costs no digits.
  double count = 0, x_mean = 0, y_mean = 0, xx = 0, xy = 0;
  for_known([&](double a, double b) {
    ++count;
    x_mean += a;
    y_mean += b;
  });
  if (count == 0) return {};
  x_mean /= count;
  y_mean /= count;
  for_known([&](double a, double b) {
    xx += (a - x_mean) * (a - x_mean);
    xy += (a - x_mean) * (b - y_mean);
  });
  // Float values that differ by rounding only say nothing of the scale.
  const bool varies = xx > count * std::pow(1e-6 * x_mean, 2) && xy > 0;
  const double scale = varies ? xy / xx : 1;
  return {scale, y_mean - scale * x_mean};
}

ScaleShift WindowJoiner::fitted(const std::vector<KnownMap>& window) const {
  if (!align_) return {};
  std::vector<const KnownMap*> ours, theirs;
  if (references_.empty()) {
    for (int i = 0; i < rule_.overlap; ++i) {
      ours.push_back(&window[static_cast<std::size_t>(i)]);
      theirs.push_back(&joined_[joined_.size() - static_cast<std::size_t>(rule_.overlap - i)]);
    }
  }
  for (std::size_t i = 0; i < references_.size(); ++i) {
    ours.push_back(&window[i]);
    theirs.push_back(&references_[i]);
  }
  return fit_scale_shift(ours, theirs);
}

void WindowJoiner::blend_end(const std::vector<KnownMap>& window) {
  for (int i = 0; i < rule_.blend; ++i) {
    const float weight = rule_.blend > 1 ? static_cast<float>(i) / static_cast<float>(rule_.blend - 1) : 0.5F;
    const KnownMap& after = window[static_cast<std::size_t>(rule_.tied() + i)];
    KnownMap& before = joined_[joined_.size() - static_cast<std::size_t>(rule_.blend - i)];
    for (std::size_t p = 0; p < before.value.pixels().size(); ++p) {
      float &value = before.value.data()[p], &confidence = before.confidence.data()[p];
      if (!(after.confidence.data()[p] > 0)) continue;
      const float share = confidence > 0 ? weight : 1;
      value = (1 - share) * value + share * after.value.data()[p];
      confidence = (1 - share) * confidence + share * after.confidence.data()[p];
    }
  }
}

ScaleShift WindowJoiner::add(std::vector<KnownMap> window) {
  require(window.size() == static_cast<std::size_t>(rule_.frames), "a window of {} frames came, {} are wanted",
          window.size(), rule_.frames);
  ScaleShift fit;
  const bool first = joined_.empty();
  if (first) {
    joined_ = window;
  } else {
    fit = fitted(window);
    for (KnownMap& map : window)
      for (std::size_t p = 0; p < map.value.pixels().size(); ++p)
        if (map.confidence.data()[p] > 0)
          map.value.data()[p] = static_cast<float>(fit.scale * map.value.data()[p] + fit.shift);
    blend_end(window);
    for (std::size_t i = static_cast<std::size_t>(rule_.overlap); i < window.size(); ++i) joined_.push_back(window[i]);
  }
  // The first reference remains the clip's first frame, so that errors do not add up from window to window.
  for (int i = 0; i < rule_.tied(); ++i) {
    const KnownMap& map = window[static_cast<std::size_t>(rule_.keyframes[static_cast<std::size_t>(i)])];
    if (first)
      references_.push_back(map);
    else if (i > 0)
      references_[static_cast<std::size_t>(i)] = map;
  }
  return fit;
}

std::vector<KnownMap> WindowJoiner::take(int frames) {
  require(frames >= 0 && static_cast<std::size_t>(frames) <= joined_.size(), "{} frames were joined, not {}",
          joined_.size(), frames);
  joined_.resize(static_cast<std::size_t>(frames));
  return std::move(joined_);
}

}  // namespace uwv::model
