// SPDX-License-Identifier: Apache-2.0
#include "geometry/mvs/plane_sweep.h"

#include <algorithm>
#include <limits>

namespace uwv::mvs {
namespace {

constexpr int band_rows = 16;  // Rows in work at once; their planes stay in the second-level cache.

/// The picture with its last row and column repeated once.
Image<float> pad_once(const Image<float>& from) {
  Image<float> out(from.width() + 1, from.height() + 1);
  for (int y = 0; y < out.height(); ++y) {
    const float* row = from.row(std::min(y, from.height() - 1));
    std::copy(row, row + from.width(), out.row(y));
    out(from.width(), y) = row[from.width() - 1];
  }
  return out;
}

struct Other {
  PlaneWarp warp;
  Size size;
  Image<float> grey;    ///< Padded once.
  Image<float> usable;  ///< Padded once; empty = all.
};

Other make_other(const View& reference, const View& view) {
  Other other{make_warp(reference.camera, view.camera), view.grey.size(), pad_once(view.grey), {}};
  if (view.usable.empty()) return other;
  Image<float> usable(view.usable.size());
  std::copy(view.usable.pixels().begin(), view.usable.pixels().end(), usable.pixels().begin());
  other.usable = pad_once(usable);
  return other;
}

/// A row with copies of its ends at both sides, for windows.
class PaddedRow {
 public:
  explicit PaddedRow(int count) : values_(static_cast<std::size_t>(count + 2 * window_radius)), count_(count) {}
  float* first() { return values_.data() + window_radius; }
  void repeat_ends() {
    for (int k = 1; k <= window_radius; ++k) {
      first()[-k] = first()[0];
      first()[count_ - 1 + k] = first()[count_ - 1];
    }
  }

 private:
  std::vector<float> values_;
  int count_;
};

struct ColumnSums {
  PaddedRow value, square, product;
  explicit ColumnSums(int count) : value(count), square(count), product(count) {}
  /// Of the window around row y; `row_of` gives a row by its number inside the picture.
  template <class RowOf>
  void take(const RowOf& row_of, const Image<float>& reference, int y) {
    const float* values[window];
    const float* references[window];
    for (int k = 0; k < window; ++k) {
      const int row = std::clamp(y + k - window_radius, 0, reference.height() - 1);
      values[k] = row_of(row);
      references[k] = reference.row(row);
    }
    sum_columns(values, references, reference.width(), value.first(), square.first(), product.first());
    value.repeat_ends();
    square.repeat_ends();
    product.repeat_ends();
  }
};

class Sweep {
 public:
  Sweep(const View& reference, const std::vector<const View*>& others, CostVolume& volume)
      : reference_(reference),
        volume_(volume),
        width_(reference.grey.width()),
        height_(reference.grey.height()),
        kept_(static_cast<int>(others.size() + 1) / 2),
        mean_(reference.grey.size()),
        variance_(reference.grey.size()),
        sums_(width_),
        index_(static_cast<std::size_t>(width_)),
        fx_(index_.size()),
        fy_(index_.size()),
        usable_(index_.size()),
        cost_(index_.size()),
        warped_(width_, band_rows + 2 * window_radius),
        inside_(width_, band_rows + 2 * window_radius),
        best_(width_, band_rows * kept_),
        band_(static_cast<std::size_t>(volume.planes) * band_rows * index_.size()) {
    for (const View* view : others) others_.push_back(make_other(reference, *view));
    for (int y = 0; y < height_; ++y) {
      sums_.take([&](int row) { return reference_.grey.row(row); }, reference_.grey, y);
      window_statistics(sums_.value.first(), sums_.square.first(), width_, mean_.row(y), variance_.row(y));
    }
  }

  void run() {
    for (int top = 0; top < height_; top += band_rows) {
      const int bottom = std::min(top + band_rows, height_);
      for (int plane = 0; plane < volume_.planes; ++plane) sweep_band(top, bottom, plane);
      store_band(top, bottom);
    }
  }

 private:
  void sweep_band(int top, int bottom, int plane) {
    const auto width = static_cast<std::size_t>(width_);
    best_.fill(1.0F);
    for (const Other& other : others_) {
      const int first = std::max(top - window_radius, 0);
      warp_rows(other, volume_.inverse_depth(static_cast<float>(plane)), first,
                std::min(bottom + window_radius, height_));
      for (int y = top; y < bottom; ++y) {
        sums_.take([&](int row) { return warped_.row(row - first); }, reference_.grey, y);
        correlate(sums_.value.first(), sums_.square.first(), sums_.product.first(), mean_.row(y), variance_.row(y),
                  inside_.row(y - first), width_, cost_.data());
        insert_sorted(cost_.data(), width_, kept_, width, best_.row((y - top) * kept_));
      }
    }
    for (int y = top; y < bottom; ++y)
      mean_to_bytes(best_.row((y - top) * kept_), width_, kept_, width, band_at(plane, y - top));
  }

  void warp_rows(const Other& other, float w, int first, int last) {
    const int stride = other.grey.width();
    for (int y = first; y < last; ++y) {
      float* inside = inside_.row(y - first);
      find_places(other.warp, w, static_cast<float>(y), width_, other.size, stride, index_.data(), fx_.data(),
                  fy_.data(), inside);
      sample_row(other.grey.data(), stride, index_.data(), fx_.data(), fy_.data(), width_, warped_.row(y - first));
      if (other.usable.empty()) continue;
      sample_row(other.usable.data(), stride, index_.data(), fx_.data(), fy_.data(), width_, usable_.data());
      for (int x = 0; x < width_; ++x)
        if (usable_[static_cast<std::size_t>(x)] < 0.999F) inside[x] = 0;
    }
  }

  std::uint8_t* band_at(int plane, int row) {
    return band_.data() + (static_cast<std::size_t>(plane) * band_rows + static_cast<std::size_t>(row)) *
                              static_cast<std::size_t>(width_);
  }

  /// Turns the band's planes of pixels into pixels of planes.
  void store_band(int top, int bottom) {
    for (int y = top; y < bottom; ++y) {
      std::uint8_t* to = volume_.at(0, y);
      for (int x = 0; x < width_; ++x, to += volume_.padded) {
        const bool usable = reference_.usable.empty() || reference_.usable(x, y) != 0;
        for (int plane = 0; plane < volume_.planes; ++plane)
          to[plane] = usable ? band_at(plane, y - top)[x] : static_cast<std::uint8_t>(worst_cost);
        std::fill(to + volume_.planes, to + volume_.padded, std::uint8_t{255});
      }
    }
  }

  const View& reference_;
  CostVolume& volume_;
  int width_, height_, kept_;
  std::vector<Other> others_;
  Image<float> mean_, variance_;  ///< Of the reference's windows.
  ColumnSums sums_;
  std::vector<std::int32_t> index_;
  std::vector<float> fx_, fy_, usable_, cost_;
  Image<float> warped_, inside_;  ///< The band and the windows' reach around it.
  Image<float> best_;             ///< [row][kept], ascending.
  std::vector<std::uint8_t> band_;
};

}  // namespace

void sweep_planes(const View& reference, const std::vector<const View*>& others, DepthRange range, int planes,
                  CostVolume& volume) {
  volume.size = reference.grey.size();
  volume.planes = planes;
  volume.padded = (planes + 15) / 16 * 16;
  volume.range = range;
  volume.costs.resize(volume.size.pixels() * static_cast<std::size_t>(volume.padded));
  Sweep(reference, others, volume).run();
}

}  // namespace uwv::mvs
