// SPDX-License-Identifier: Apache-2.0
// Where the ground ends, column by column: a one-layer "stixel" world (Badino, Franke and Pfeiffer 2009) whose only
// measurement is colour. Ground is what has the colours of the lower edge, learned anew from each division.
#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "geometry/layers/cv_bridge.h"
#include "geometry/layers/prior_parts.h"

namespace uwv::layers {
namespace {

constexpr int most_columns = 208;     // the contour is as coarse as the assumption it serves
constexpr int rounds = 3;             // of learning colours and dividing; little changes after the third
constexpr double most_certain = 2.5;  // log likelihood ratio of one pixel: colours are never proof
constexpr double step_cost = 1.0;     // of a row's difference between neighbouring columns, in log likelihood
constexpr int longest_step = 14;      // rows from which a difference costs no more: things have sides
constexpr double habit = 0.5;         // log likelihood a row away from the first guess: decides where colours hardly do
/// Mean log likelihood ratio of a pixel, of either side, for its own side: streets and paths have 1.4 and more, a
/// flower, stairs and a bedroom 1.1 and less.
constexpr double least_evidence = 1.3;
constexpr double narrow = 0.2;     // of the width: what stands before the wall rather than being the wall
constexpr double rounding = 0.08;  // of the width, over which the wall is smoothed: a bend looks better than a tear

constexpr int light_bins = 16, hue_bins = 32;
constexpr std::size_t bins = static_cast<std::size_t>(light_bins) * hue_bins * hue_bins;
using Histogram = std::vector<float>;

enum class Part : std::uint8_t { unknown, ground, upright };

struct Small {
  Size size;
  std::vector<std::uint16_t> bin;  ///< Colour of every pixel; `bins` where foreground covers it.
  std::vector<std::uint8_t> sky;
  std::size_t at(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(size.width) + static_cast<std::size_t>(x);
  }
};

Small shrink(const ImageRgb& picture, const ForegroundMask& foreground, const Image<std::uint8_t>& sky) {
  Small out;
  const double scale = std::min(1.0, static_cast<double>(most_columns) / picture.width());
  out.size = {std::max(1, cvRound(scale * picture.width())), std::max(1, cvRound(scale * picture.height()))};
  const cv::Size size(out.size.width, out.size.height);
  cv::Mat colour, lab, covered = cv::Mat::zeros(size, CV_8U), above;
  cv::resize(view(picture), colour, size, 0, 0, cv::INTER_AREA);
  cv::cvtColor(colour, lab, cv::COLOR_RGB2Lab);
  if (!foreground.empty()) cv::resize(view(foreground), covered, size, 0, 0, cv::INTER_NEAREST);
  cv::resize(view(sky), above, size, 0, 0, cv::INTER_NEAREST);
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) {
      const auto c = lab.at<cv::Vec3b>(y, x);
      const int bin = (c[0] / 16 * hue_bins + c[1] / 8) * hue_bins + c[2] / 8;
      out.bin.push_back(static_cast<std::uint16_t>(covered.at<std::uint8_t>(y, x) != 0 ? static_cast<int>(bins) : bin));
      out.sky.push_back(above.at<std::uint8_t>(y, x));
    }
  return out;
}

/// [1 2 1] along one axis of the histogram: neighbouring colours are the same thing in other light.
void blur_axis(Histogram& h, std::size_t stride, std::size_t length) {
  Histogram line(length);
  for (std::size_t i = 0; i < h.size(); ++i) {
    if (i / stride % length != 0) continue;
    for (std::size_t k = 0; k < length; ++k) line[k] = h[i + k * stride];
    for (std::size_t k = 0; k < length; ++k)
      h[i + k * stride] = 0.25F * (line[k == 0 ? 0 : k - 1] + 2 * line[k] + line[std::min(k + 1, length - 1)]);
  }
}

Histogram learn(const Small& small, const std::vector<Part>& parts, Part wanted) {
  Histogram h(bins, 0);
  double count = 0;
  for (std::size_t i = 0; i < parts.size(); ++i)
    if (parts[i] == wanted && small.bin[i] < bins) {
      h[small.bin[i]] += 1;
      count += 1;
    }
  if (count == 0) return {};
  blur_axis(h, 1, hue_bins);
  blur_axis(h, hue_bins, hue_bins);
  blur_axis(h, static_cast<std::size_t>(hue_bins) * hue_bins, light_bins);
  for (float& v : h) v = static_cast<float>(v / count);
  return h;
}

/// For each pixel, how much likelier its colour is on the ground than on what stands; 0 = cannot be told.
std::vector<float> compare(const Small& small, const Histogram& ground, const Histogram& upright) {
  // What stands has many colours, the ground few: one that neither is known for is a thing's.
  constexpr double rare = 1e-4, rare_upright = 4e-4;
  std::vector<float> out(small.bin.size(), 0);
  for (std::size_t i = 0; i < out.size(); ++i) {
    if (small.bin[i] == bins) continue;
    const double ratio = std::log((ground[small.bin[i]] + rare) / (upright[small.bin[i]] + rare_upright));
    out[i] = static_cast<float>(small.sky[i] != 0 ? -most_certain : std::clamp(ratio, -most_certain, most_certain));
  }
  return out;
}

/// Row at which each column's ground ends: least cost over all columns, in [highest, height].
std::vector<int> divide(const Small& small, const std::vector<float>& score, int start, int highest) {
  const int width = small.size.width, count = small.size.height - highest + 1;
  const auto n = static_cast<std::size_t>(count);
  std::vector<double> before(n, 0), now(n);
  std::vector<std::vector<std::int16_t>> from(static_cast<std::size_t>(width), std::vector<std::int16_t>(n));
  for (int x = 0; x < width; ++x) {
    const auto best = static_cast<int>(std::min_element(before.begin(), before.end()) - before.begin());
    double below = 0;
    for (int k = count - 1; k >= 0; --k) {
      if (k < count - 1) below += static_cast<double>(score[small.at(x, highest + k)]);
      int parent = best;
      double least = before[static_cast<std::size_t>(best)] + step_cost * longest_step;
      for (int j = std::max(0, k - longest_step); j <= std::min(count - 1, k + longest_step); ++j) {
        const double cost = before[static_cast<std::size_t>(j)] + step_cost * std::abs(j - k);
        if (cost < least || (cost == least && std::abs(j - k) < std::abs(parent - k))) {
          least = cost;
          parent = j;
        }
      }
      now[static_cast<std::size_t>(k)] = least - below + habit * std::abs(highest + k - start);
      from[static_cast<std::size_t>(x)][static_cast<std::size_t>(k)] = static_cast<std::int16_t>(parent);
    }
    std::swap(before, now);
  }
  std::vector<int> rows(static_cast<std::size_t>(width));
  auto k = static_cast<int>(std::min_element(before.begin(), before.end()) - before.begin());
  for (int x = width - 1; x >= 0; --x) {
    rows[static_cast<std::size_t>(x)] = highest + k;
    k = from[static_cast<std::size_t>(x)][static_cast<std::size_t>(k)];
  }
  return rows;
}

std::vector<Part> parts_of(const Small& small, const std::vector<int>& rows) {
  std::vector<Part> parts(small.bin.size());
  for (int y = 0; y < small.size.height; ++y)
    for (int x = 0; x < small.size.width; ++x)
      parts[small.at(x, y)] = small.sky[small.at(x, y)] != 0           ? Part::unknown
                              : y >= rows[static_cast<std::size_t>(x)] ? Part::ground
                                                                       : Part::upright;
  return parts;
}

/// The lower edge is ground, what is at or above the horizon is not, and what lies between is to be found out.
std::vector<Part> first_parts(const Small& small, double horizon) {
  std::vector<Part> parts(small.bin.size(), Part::unknown);
  const double height = small.size.height;
  for (int y = 0; y < small.size.height; ++y)
    for (int x = 0; x < small.size.width; ++x) {
      if (small.sky[small.at(x, y)] != 0) continue;
      if (y >= 0.88 * height) parts[small.at(x, y)] = Part::ground;
      if (y < horizon) parts[small.at(x, y)] = Part::upright;
    }
  return parts;
}

/// Mean log likelihood ratio for the side a pixel is on, the worse of both sides.
double evidence(const std::vector<Part>& parts, const std::vector<float>& score) {
  std::array<double, 2> sum{}, count{};
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (parts[i] == Part::unknown) continue;
    const std::size_t side = parts[i] == Part::ground ? 0 : 1;
    sum[side] += side == 0 ? static_cast<double>(score[i]) : -static_cast<double>(score[i]);
    count[side] += 1;
  }
  return count[0] > 0 && count[1] > 0 ? std::min(sum[0] / count[0], sum[1] / count[1]) : 0;
}

/// Grey opening along the columns: feet that reach lower than both neighbours' for less than `width` are raised.
std::vector<int> without_narrow(const std::vector<int>& rows, int width) {
  const int count = static_cast<int>(rows.size()), reach = width / 2;
  const auto extreme = [&](const std::vector<int>& in, bool least) {
    std::vector<int> out(in.size());
    for (int x = 0; x < count; ++x) {
      const auto first = in.begin() + std::max(0, x - reach), last = in.begin() + std::min(count, x + reach + 1);
      out[static_cast<std::size_t>(x)] = least ? *std::min_element(first, last) : *std::max_element(first, last);
    }
    return out;
  };
  return extreme(extreme(rows, true), false);
}

/// Mean over `width` columns; the outermost count on beyond the picture.
std::vector<double> rounded(const std::vector<int>& rows, int width) {
  const int count = static_cast<int>(rows.size()), reach = width / 2;
  std::vector<double> out;
  for (int x = 0; x < count; ++x) {
    double sum = 0;
    for (int k = -reach; k <= reach; ++k) sum += rows[static_cast<std::size_t>(std::clamp(x + k, 0, count - 1))];
    out.push_back(sum / (2 * reach + 1));
  }
  return out;
}

/// The line of the walls: smooth, and without what is narrow, as every step in it would tear the picture.
std::vector<double> settle(const std::vector<int>& rows) {
  const int count = static_cast<int>(rows.size());
  std::vector<int> wall = without_narrow(rows, cvRound(narrow * count));
  // What the picture's edges cut may be wide.
  for (int x = 0; x < count && rows[static_cast<std::size_t>(x)] > wall[static_cast<std::size_t>(x)]; ++x)
    wall[static_cast<std::size_t>(x)] = rows[static_cast<std::size_t>(x)];
  for (int x = count - 1; x >= 0 && rows[static_cast<std::size_t>(x)] > wall[static_cast<std::size_t>(x)]; --x)
    wall[static_cast<std::size_t>(x)] = rows[static_cast<std::size_t>(x)];
  return rounded(wall, cvRound(rounding * count));
}

/// Full-size columns.
std::vector<double> enlarge(const std::vector<double>& rows, int width, double scale) {
  std::vector<double> out;
  const int last = static_cast<int>(rows.size()) - 1;
  for (int x = 0; x < width; ++x) {
    const double at = std::clamp((x + 0.5) * (last + 1) / width - 0.5, 0.0, static_cast<double>(last));
    const int left = static_cast<int>(at), right = std::min(left + 1, last);
    const double a = rows[static_cast<std::size_t>(left)], b = rows[static_cast<std::size_t>(right)];
    out.push_back(scale * (a + (at - left) * (b - a)));
  }
  return out;
}

}  // namespace

std::vector<double> find_contour(const ImageRgb& picture, const ForegroundMask& foreground,
                                 const Image<std::uint8_t>& sky, double horizon_row, double start, double highest) {
  const int height = picture.height();
  if (picture.width() < 32 || height < 32 || horizon_row < 0.05 * height || highest > 0.9 * height) return {};
  const Small small = shrink(picture, foreground, sky);
  const double scale = static_cast<double>(height) / small.size.height;
  const int top = std::clamp(static_cast<int>(std::ceil(highest / scale)), 0, small.size.height - 1);
  const int guess = std::clamp(cvRound(start / scale), top, small.size.height);
  std::vector<Part> parts = first_parts(small, horizon_row / scale);
  std::vector<int> rows;
  double told = 0;
  for (int i = 0; i < rounds; ++i) {
    const Histogram ground = learn(small, parts, Part::ground), upright = learn(small, parts, Part::upright);
    if (ground.empty() || upright.empty()) return {};
    const std::vector<float> score = compare(small, ground, upright);
    rows = divide(small, score, guess, top);
    parts = parts_of(small, rows);
    told = evidence(parts, score);
  }
  if (told < least_evidence) return {};
  return enlarge(settle(rows), picture.width(), scale);
}

}  // namespace uwv::layers
