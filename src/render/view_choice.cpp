// SPDX-License-Identifier: Apache-2.0
#include "render/view_choice.h"

#include <algorithm>
#include <cmath>

namespace uwv::detail {
namespace {

constexpr int sample_step = 4;  // half a cell: a surface that is not magnified twofold reaches every cell it covers

/// Sums of colours that both show.
struct Exposure {
  std::array<double, 3> own{}, other{};
  std::size_t count = 0;

  void add(const Rgb8& mine, const Rgb8& theirs) {
    own[0] += mine.r, own[1] += mine.g, own[2] += mine.b;
    other[0] += theirs.r, other[1] += theirs.g, other[2] += theirs.b;
    ++count;
  }

  std::array<float, 3> gain(float most) const {
    constexpr std::size_t enough = 64;
    constexpr double dark = 4;  // below this a mean level is mostly rounding
    std::array<float, 3> gains{1, 1, 1};
    for (std::size_t c = 0; c < 3 && count >= enough; ++c)
      if (other[c] > dark * static_cast<double>(count))
        gains[c] = std::clamp(static_cast<float>(own[c] / other[c]), 1 / most, most);
    return gains;
  }
};

}  // namespace

OpenCells::OpenCells(const ValidityMask& valid)
    : columns(static_cast<std::size_t>((valid.width() + side - 1) / side)),
      open(columns * static_cast<std::size_t>((valid.height() + side - 1) / side)) {
  for (int y = 0; y < valid.height(); ++y)
    for (int x = 0; x < valid.width(); ++x) open[cell_of(x, y)] += valid(x, y) == 0;
  for (const std::uint32_t count : open) total += count;
}

ViewSurvey survey_view(const OtherView& view, const Camera& target, const RenderedFrame& frame, const OpenCells& cells,
                       const OtherViewsOptions& options) {
  ViewSurvey survey;
  survey.reaches.assign(cells.open.size(), 0);
  const WarpMap map = WarpMap::between(view.camera, target);
  Exposure exposure;
  for (int y = sample_step / 2; y < view.depth.height(); y += sample_step)
    for (int x = sample_step / 2; x < view.depth.width(); x += sample_step) {
      if (view.usable(x, y) == 0 || !(view.depth(x, y) > 0)) continue;
      const WarpMap::Landing landing = map.apply(x, y, view.depth(x, y));
      if (!landing.inside(target.size)) continue;
      const int u = static_cast<int>(landing.u), v = static_cast<int>(landing.v);
      if (frame.valid(u, v) == 0) {
        survey.reaches[cells.cell_of(u, v)] = 1;
        continue;
      }
      const float ratio = landing.depth / frame.depth(u, v);
      if (ratio < 1 - options.tolerance)
        ++survey.before;
      else if (ratio < 1 + options.tolerance) {
        ++survey.agreeing;
        exposure.add(frame.colour(u, v), view.colour(x, y));
      }
    }
  survey.gain = exposure.gain(options.max_gain);
  return survey;
}

std::vector<std::size_t> choose_views(const std::vector<ViewSurvey>& surveys, const OpenCells& cells,
                                      std::size_t min_pixels, const OtherViewsOptions& options) {
  std::vector<std::uint32_t> left = cells.open;
  std::vector<std::size_t> chosen;
  while (chosen.size() < static_cast<std::size_t>(options.max_views)) {
    std::size_t best = 0, most = 0;
    for (std::size_t i = 0; i < surveys.size(); ++i) {
      if (surveys[i].reaches.empty()) continue;
      std::size_t opens = 0;
      for (std::size_t c = 0; c < left.size(); ++c) opens += surveys[i].reaches[c] != 0 ? left[c] : 0;
      if (opens > most) most = opens, best = i;
    }
    if (most == 0 || most < min_pixels) break;
    chosen.push_back(best);
    for (std::size_t c = 0; c < left.size(); ++c)
      if (surveys[best].reaches[c] != 0) left[c] = 0;
  }
  return chosen;
}

}  // namespace uwv::detail
