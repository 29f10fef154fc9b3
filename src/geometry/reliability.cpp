// SPDX-License-Identifier: Apache-2.0
#include "uwv/geometry/reliability.h"

#include <algorithm>
#include <limits>
#include <vector>

#include "uwv/core/simd.h"

namespace uwv {
namespace {

constexpr float highest = std::numeric_limits<float>::max();

/// Largest, smallest and total depth of a window, for every pixel of a row.
struct WindowRows {
  std::vector<float> largest, smallest, total;
  explicit WindowRows(std::size_t width) : largest(width), smallest(width), total(width) {}
};

/// Takes `width` more values into the windows.
UWV_SIMD_CLONES void add_to_windows(const float* largest, const float* smallest, const float* total, int width,
                                    float* out_largest, float* out_smallest, float* out_total) {
#pragma GCC ivdep  // inputs and outputs never overlap
  for (int x = 0; x < width; ++x) {
    out_largest[x] = out_largest[x] > largest[x] ? out_largest[x] : largest[x];
    out_smallest[x] = out_smallest[x] < smallest[x] ? out_smallest[x] : smallest[x];
    out_total[x] += total[x];
  }
}

void clear(WindowRows& rows) {
  std::fill(rows.largest.begin(), rows.largest.end(), -highest);
  std::fill(rows.smallest.begin(), rows.smallest.end(), highest);
  std::fill(rows.total.begin(), rows.total.end(), 0.0F);
}

/// Windows of row y: first down the columns, with `radius` empty ones on both sides, then along the row.
void find_windows(const DepthMap& depth, int y, int radius, WindowRows& columns, WindowRows& out) {
  clear(columns);
  clear(out);
  const int width = depth.width();
  const int first = std::max(0, y - radius), last = std::min(depth.height() - 1, y + radius);
  for (int row = first; row <= last; ++row) {
    const float* z = depth.row(row);
    add_to_windows(z, z, z, width, columns.largest.data() + radius, columns.smallest.data() + radius,
                   columns.total.data() + radius);
  }
  for (int shift = 0; shift <= 2 * radius; ++shift)
    add_to_windows(columns.largest.data() + shift, columns.smallest.data() + shift, columns.total.data() + shift, width,
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

void judge_rows(const DepthMap& depth, int from, int to, const ReliabilityOptions& options, ValidityMask& out) {
  const int radius = options.window / 2;
  const auto width = static_cast<std::size_t>(depth.width());
  WindowRows columns(width + 2 * static_cast<std::size_t>(radius)), windows(width);
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
