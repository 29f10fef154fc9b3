// SPDX-License-Identifier: Apache-2.0
#include "uwv/geometry/reliability.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <vector>

#include "uwv/core/simd.h"

namespace uwv {
namespace {

constexpr float highest = std::numeric_limits<float>::max();

/// Largest, smallest and total depth, one of each a pixel.
struct Extremes {
  std::vector<float> largest, smallest, total;
  explicit Extremes(std::size_t width) : largest(width), smallest(width), total(width) {}
  void clear() {
    std::fill(largest.begin(), largest.end(), -highest);
    std::fill(smallest.begin(), smallest.end(), highest);
    std::fill(total.begin(), total.end(), 0.0F);
  }
};

/// Takes in Count more values for each pixel: those `step` apart in each of the three inputs. A count known to the
/// compiler keeps the sums in registers.
template <int Count>
inline __attribute__((always_inline)) void take_in(const float* largest, const float* smallest, const float* total,
                                                   std::ptrdiff_t step, int width, float* out_largest,
                                                   float* out_smallest, float* out_total) {
#pragma GCC ivdep  // inputs and outputs never overlap
  for (int x = 0; x < width; ++x) {
    float high = out_largest[x], low = out_smallest[x], sum = out_total[x];
    for (int i = 0; i < Count; ++i) {
      const float top = largest[x + i * step], bottom = smallest[x + i * step];
      high = high > top ? high : top;
      low = low < bottom ? low : bottom;
      sum += total[x + i * step];
    }
    out_largest[x] = high;
    out_smallest[x] = low;
    out_total[x] = sum;
  }
}

/// Takes in `count` more values for each pixel, as above.
UWV_SIMD_CLONES void take_in_all(const float* largest, const float* smallest, const float* total, std::ptrdiff_t step,
                                 int count, int width, float* out_largest, float* out_smallest, float* out_total) {
  for (; count >= 5; count -= 5, largest += 5 * step, smallest += 5 * step, total += 5 * step)
    take_in<5>(largest, smallest, total, step, width, out_largest, out_smallest, out_total);
  for (; count > 0; --count, largest += step, smallest += step, total += step)
    take_in<1>(largest, smallest, total, step, width, out_largest, out_smallest, out_total);
}

/// Windows of row y: first down the columns, with `radius` empty ones on both sides, then along the row.
void find_windows(const DepthMap& depth, int y, int radius, Extremes& columns, Extremes& out) {
  columns.clear();
  out.clear();
  const int width = depth.width();
  const int first = std::max(0, y - radius), last = std::min(depth.height() - 1, y + radius);
  const float* z = depth.row(first);
  take_in_all(z, z, z, width, last - first + 1, width, columns.largest.data() + radius,
              columns.smallest.data() + radius, columns.total.data() + radius);
  take_in_all(columns.largest.data(), columns.smallest.data(), columns.total.data(), 1, 2 * radius + 1, width,
              out.largest.data(), out.smallest.data(), out.total.data());
}

/// Number of pixels the mean is taken over, for every pixel of a row whose windows hold `rows` rows.
void count_pixels(int width, int rows, const ReliabilityOptions& options, std::vector<float>& out) {
  const int radius = options.window / 2;
  for (int x = 0; x < width; ++x) {
    const int columns = std::min(width - 1, x + radius) - std::max(0, x - radius) + 1;
    out[static_cast<std::size_t>(x)] =
        static_cast<float>(options.count_padding ? options.window * options.window : rows * columns);
  }
}

UWV_SIMD_CLONES void judge_row(const float* depth, const float* largest, const float* smallest, const float* total,
                               const float* pixels, float ratio, int width, std::uint8_t* out) {
  for (int x = 0; x < width; ++x) {
    const float spread = (largest[x] - smallest[x]) / (total[x] / pixels[x] + 1e-6F);
    out[x] = static_cast<std::uint8_t>((spread < ratio) & (depth[x] > 0));
  }
}

constexpr int edge_reach = 3;  // pixels to each side

/// Counts the edge around *centre, if there is one whose middle lies between it and the next value.
void judge_edge(const float* centre, std::ptrdiff_t step, EdgeSharpness& sum) {
  std::array<float, 2 * edge_reach + 1> w;
  for (std::size_t i = 0; i < w.size(); ++i) {
    const float z = centre[(static_cast<std::ptrdiff_t>(i) - edge_reach) * step];
    if (!(z > 0)) return;
    w[i] = 1.0F / z;
  }
  const float whole = w.back() - w.front();
  const float flat = 0.15F * std::fabs(whole);
  if (!(std::fabs(whole) > 0.1F * std::max(w.front(), w.back()))) return;
  if (std::fabs(w[1] - w[0]) > flat || std::fabs(w[6] - w[5]) > flat) return;
  const float middle = 0.5F * (w.front() + w.back());
  if ((w[edge_reach] > middle) == (w[edge_reach + 1] > middle)) return;
  ++sum.edges;
  const auto between = [&](float v) { return std::fabs(v - w.front()) > flat && std::fabs(v - w.back()) > flat; };
  sum.smeared += std::count_if(w.begin() + 1, w.end() - 1, between) >= 2;
}

void judge_rows(const DepthMap& depth, int from, int to, const ReliabilityOptions& options, ValidityMask& out) {
  const int radius = options.window / 2;
  const auto width = static_cast<std::size_t>(depth.width());
  Extremes columns(width + 2 * static_cast<std::size_t>(radius)), windows(width);
  std::vector<float> pixels(width);
  int counted_rows = 0;
  for (int y = from; y < to; ++y) {
    const int rows = std::min(depth.height() - 1, y + radius) - std::max(0, y - radius) + 1;
    if (rows != counted_rows) count_pixels(depth.width(), rows, options, pixels);
    counted_rows = rows;
    find_windows(depth, y, radius, columns, windows);
    judge_row(depth.row(y), windows.largest.data(), windows.smallest.data(), windows.total.data(), pixels.data(),
              options.ratio, depth.width(), out.row(y));
  }
}

}  // namespace

void ReliabilityOptions::check() const {
  require(window >= 1 && window <= 255 && window % 2 == 1, "reliability window {} is not an odd number in 1..255",
          window);
  require(ratio > 0, "reliability ratio {} is not positive", ratio);
}

EdgeSharpness edge_sharpness(const DepthMap& depth, ThreadPool& pool) {
  std::atomic<std::size_t> edges{0}, smeared{0};
  pool.for_ranges(0, depth.height(), 32, [&](int from, int to) {
    EdgeSharpness here;
    for (int y = from; y < to; ++y)
      for (int x = 0; x < depth.width(); ++x) {
        const bool fits_row = x >= edge_reach && x + edge_reach < depth.width();
        const bool fits_column = y >= edge_reach && y + edge_reach < depth.height();
        if (fits_row) judge_edge(depth.row(y) + x, 1, here);
        if (fits_column) judge_edge(depth.row(y) + x, depth.width(), here);
      }
    edges += here.edges;
    smeared += here.smeared;
  });
  return {edges, smeared};
}

ValidityMask reliable_depth(const DepthMap& depth, const ReliabilityOptions& options, ThreadPool& pool) {
  ValidityMask reliable;
  reliable_depth(depth, options, pool, reliable);
  return reliable;
}

void reliable_depth(const DepthMap& depth, const ReliabilityOptions& options, ThreadPool& pool, ValidityMask& out) {
  options.check();
  out.resize(depth.size());
  pool.for_ranges(0, depth.height(), 32, [&](int from, int to) {
    if (options.enabled) {
      judge_rows(depth, from, to, options, out);
      return;
    }
    for (int y = from; y < to; ++y)
      std::transform(depth.row(y), depth.row(y) + depth.width(), out.row(y),
                     [](float z) { return static_cast<std::uint8_t>(z > 0); });
  });
}

}  // namespace uwv
