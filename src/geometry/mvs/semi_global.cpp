// SPDX-License-Identifier: Apache-2.0
#include "geometry/mvs/semi_global.h"

#include <algorithm>
#include <cmath>

#include "uwv/core/simd.h"

namespace uwv::mvs {
namespace {

constexpr int small_step = 6;   // P1: a slanted surface crosses planes.
constexpr int large_jump = 60;  // P2 on an even part of the picture.
constexpr int least_jump = 16;  // P2 on a strong edge; above P1.
constexpr float jump_edge = 8;  // Grey levels of edge that halve P2.
constexpr int paths = 8;
constexpr std::uint16_t infinite = 30000;  // Far above any path cost, and no overflow when a penalty is added.

std::uint16_t jump_penalty(float grey, float before) {
  const float edge = std::abs(grey - before);
  return static_cast<std::uint16_t>(
      std::max(static_cast<float>(least_jump), static_cast<float>(large_jump) * jump_edge / (jump_edge + edge)));
}

/// One step of a path: from the costs at the previous pixel to those here, added to the sums. Returns the least.
inline __attribute__((always_inline)) std::uint16_t path_step(const std::uint8_t* __restrict cost,
                                                              const std::uint16_t* __restrict before,
                                                              std::uint16_t least_before, std::uint16_t jump,
                                                              int planes, std::uint16_t* __restrict here,
                                                              std::uint16_t* __restrict sums) {
  const auto jumped = static_cast<std::uint16_t>(least_before + jump);
  std::uint16_t least = infinite;
  for (int d = 0; d < planes; ++d) {
    const auto up = static_cast<std::uint16_t>(before[d - 1] + small_step);
    const auto down = static_cast<std::uint16_t>(before[d + 1] + small_step);
    std::uint16_t best = before[d] < jumped ? before[d] : jumped;
    best = up < best ? up : best;
    best = down < best ? down : best;
    const auto value = static_cast<std::uint16_t>(cost[d] + best - least_before);
    here[d] = value;
    sums[d] = static_cast<std::uint16_t>(sums[d] + value);
    least = value < least ? value : least;
  }
  return least;
}

/// The paths' costs along a row of pixels, for one direction.
class PathRow {
 public:
  PathRow(int width, int planes)
      : stride_(static_cast<std::size_t>(planes) + 2),
        costs_(stride_ * static_cast<std::size_t>(width), infinite),
        least_(static_cast<std::size_t>(width)) {}
  std::uint16_t* at(int x) { return costs_.data() + static_cast<std::size_t>(x) * stride_ + 1; }
  std::uint16_t& least(int x) { return least_[static_cast<std::size_t>(x)]; }

 private:
  std::size_t stride_;
  std::vector<std::uint16_t> costs_;
  std::vector<std::uint16_t> least_;
};

struct RowTask {
  int width = 0;
  int planes = 0;
  const std::uint8_t* costs = nullptr;  ///< Of the row.
  std::uint16_t* sums = nullptr;        ///< Of the row.
  const float* grey = nullptr;          ///< The row.
  const float* grey_before = nullptr;   ///< The row the path comes from; the same for paths along the row.
};

/// A path that starts here.
void start_path(const RowTask& task, int x, PathRow& here) {
  const auto offset = static_cast<std::size_t>(x) * static_cast<std::size_t>(task.planes);
  std::uint16_t* to = here.at(x);
  std::uint16_t least = infinite;
  for (int d = 0; d < task.planes; ++d) {
    to[d] = task.costs[offset + static_cast<std::size_t>(d)];
    task.sums[offset + static_cast<std::size_t>(d)] =
        static_cast<std::uint16_t>(task.sums[offset + static_cast<std::size_t>(d)] + to[d]);
    least = std::min(least, to[d]);
  }
  here.least(x) = least;
}

/// Advances all pixels of a row for the direction that comes from (x - step_x) of `before`, in the order given by
/// `forward`. For paths along the row, `before` is `here`.
UWV_SIMD_CLONES void advance_row(const RowTask& task, int step_x, bool forward, PathRow& before, PathRow& here) {
  for (int i = 0; i < task.width; ++i) {
    const int x = forward ? i : task.width - 1 - i;
    const int from = x - step_x;
    if (from < 0 || from >= task.width || task.grey_before == nullptr) {
      start_path(task, x, here);
      continue;
    }
    const auto offset = static_cast<std::size_t>(x) * static_cast<std::size_t>(task.planes);
    here.least(x) =
        path_step(task.costs + offset, before.at(from), before.least(from),
                  jump_penalty(task.grey[x], task.grey_before[from]), task.planes, here.at(x), task.sums + offset);
  }
}

/// The four paths that arrive from above (downwards) or from below.
void sweep_rows(const CostVolume& volume, const Image<float>& grey, bool downwards, std::vector<std::uint16_t>& sums) {
  const int width = volume.size.width;
  const int height = volume.size.height;
  PathRow along(width, volume.padded);
  std::vector<PathRow> before(3, PathRow(width, volume.padded));
  std::vector<PathRow> here(3, PathRow(width, volume.padded));
  for (int i = 0; i < height; ++i) {
    const int y = downwards ? i : height - 1 - i;
    RowTask task{width,
                 volume.padded,
                 volume.at(0, y),
                 sums.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(width) *
                                   static_cast<std::size_t>(volume.padded),
                 grey.row(y),
                 grey.row(y)};
    advance_row(task, downwards ? 1 : -1, downwards, along, along);
    task.grey_before = i == 0 ? nullptr : grey.row(downwards ? y - 1 : y + 1);
    for (int k = 0; k < 3; ++k)
      advance_row(task, k - 1, true, before[static_cast<std::size_t>(k)], here[static_cast<std::size_t>(k)]);
    std::swap(before, here);
  }
}

UWV_SIMD_CLONES std::uint16_t least_of(const std::uint16_t* sums, int count) {
  std::uint16_t least = 65535;
  for (int d = 0; d < count; ++d) least = sums[d] < least ? sums[d] : least;
  return least;
}

/// Offset of the parabola through three values whose middle one is the least, in [-0.5, 0.5].
float parabola_offset(int left, int middle, int right) {
  const int curvature = left - 2 * middle + right;
  if (curvature <= 0) return 0;
  return std::clamp(0.5F * static_cast<float>(left - right) / static_cast<float>(curvature), -0.5F, 0.5F);
}

void choose_planes(const CostVolume& volume, const std::vector<std::uint16_t>& sums, MatchedDepth& out) {
  const int planes = volume.planes;
  const int beside = std::max(1, planes / 24);  // Planes this close to the best are the same answer.
  const auto padded = static_cast<std::size_t>(volume.padded);
  out.inverse_depth = InverseDepthMap(volume.size);
  out.distinctness = Image<float>(volume.size);
  out.cost = Image<float>(volume.size);
  for (std::size_t i = 0; i < volume.size.pixels(); ++i) {
    const std::uint16_t* s = sums.data() + i * padded;
    const std::uint16_t least = least_of(s, planes);
    const int best = static_cast<int>(std::find(s, s + planes, least) - s);
    const std::uint16_t below = best > beside ? least_of(s, best - beside) : infinite;
    const int next = best + beside + 1;
    const std::uint16_t above = next < planes ? least_of(s + next, planes - next) : infinite;
    const int margin = std::min(below, above) - least;
    out.distinctness.data()[i] = std::clamp(static_cast<float>(margin) / (paths * large_jump), 0.0F, 1.0F);
    out.cost.data()[i] = static_cast<float>(volume.costs[i * padded + static_cast<std::size_t>(best)]) / worst_cost;
    if (margin == 0) continue;
    float plane = static_cast<float>(best);
    if (best > 0 && best + 1 < planes) plane += parabola_offset(s[best - 1], s[best], s[best + 1]);
    out.inverse_depth.data()[i] = volume.inverse_depth(plane);
  }
}

}  // namespace

void aggregate(const CostVolume& volume, const Image<float>& grey, std::vector<std::uint16_t>& sums,
               MatchedDepth& out) {
  sums.assign(volume.costs.size(), 0);
  sweep_rows(volume, grey, true, sums);
  sweep_rows(volume, grey, false, sums);
  choose_planes(volume, sums, out);
}

}  // namespace uwv::mvs
