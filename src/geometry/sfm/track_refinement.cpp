// SPDX-License-Identifier: Apache-2.0
#include "geometry/sfm/track_refinement.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "geometry/sfm/grey_picture.h"

namespace uwv::sfm {
namespace {

constexpr int reach = 7;  // pixels to each side of the middle; as large as the window of tracking
constexpr int side = 2 * reach + 1;
constexpr int pixels = side * side;
constexpr int most_steps = 12;
constexpr double settled_px = 0.003;    // a step of less ends the search
constexpr double farthest_px = 1;       // from where tracking says; beyond, it is another place that looks alike
constexpr double least_likeness = 0.9;  // correlation; below, the patch is hidden, or shows an edge of depth
constexpr double smoothing_px = 0.7;    // bilinear interpolation is unbiased only where the picture is smooth
constexpr double least_contrast = 1.0;  // grey levels; a flat patch is not to be found again

using Values = Eigen::Matrix<float, pixels, 1>;
using Slopes = Eigen::Matrix<float, pixels, 6>;

/// A patch's place and shape in a picture: offset d from its middle is seen at middle + shape * d.
struct Placed {
  Eigen::Vector2d middle;  // pixels, centres at whole numbers
  Eigen::Matrix2d shape = Eigen::Matrix2d::Identity();
};

bool inside(const cv::Mat& grey, const Placed& placed, int margin) {
  const Eigen::Vector2d half = placed.shape.cwiseAbs() * Eigen::Vector2d::Constant(reach + margin);
  const Eigen::Vector2d low = placed.middle - half, high = placed.middle + half;
  return low.minCoeff() >= 0 && high.x() < grey.cols - 1 && high.y() < grey.rows - 1;
}

float bilinear(const cv::Mat& grey, float x, float y) {
  const int column = static_cast<int>(x), row = static_cast<int>(y);
  const float right = x - static_cast<float>(column), down = y - static_cast<float>(row);
  const std::uint8_t* above = grey.ptr(row) + column;
  const std::uint8_t* below = grey.ptr(row + 1) + column;
  const float upper = static_cast<float>(above[0]) + right * static_cast<float>(above[1] - above[0]);
  const float lower = static_cast<float>(below[0]) + right * static_cast<float>(below[1] - below[0]);
  return upper + down * (lower - upper);
}

Values sampled(const cv::Mat& grey, const Placed& placed) {
  const Eigen::Matrix2f shape = placed.shape.cast<float>();
  const Eigen::Vector2f middle = placed.middle.cast<float>();
  Values out;
  int i = 0;
  for (int dy = -reach; dy <= reach; ++dy) {
    const Eigen::Vector2f row = middle + shape.col(1) * static_cast<float>(dy);
    for (int dx = -reach; dx <= reach; ++dx, ++i)
      out[i] = bilinear(grey, row.x() + shape(0, 0) * static_cast<float>(dx),
                        row.y() + shape(1, 0) * static_cast<float>(dx));
  }
  return out;
}

/// The patch that a track's places are told by, and how it changes as it is moved (columns 0, 1) and bent (2 to 5).
class Patch {
 public:
  static std::optional<Patch> at(const cv::Mat& grey, const Eigen::Vector2d& middle) {
    if (!inside(grey, {middle}, 1)) return std::nullopt;
    Patch out;
    out.values_ = sampled(grey, {middle});
    const auto difference = [&](const Eigen::Vector2d& step) -> Values {
      return 0.5F * (sampled(grey, {middle + step}) - sampled(grey, {middle - step}));
    };
    const Values across = difference({1, 0}), down = difference({0, 1});
    int i = 0;
    for (int dy = -reach; dy <= reach; ++dy)
      for (int dx = -reach; dx <= reach; ++dx, ++i) {
        const float x = static_cast<float>(dx) / reach, y = static_cast<float>(dy) / reach;
        out.slopes_.row(i) << across[i], down[i], across[i] * x, across[i] * y, down[i] * x, down[i] * y;
      }
    out.values_.array() -= out.values_.mean();
    for (int c = 0; c < 6; ++c) out.slopes_.col(c).array() -= out.slopes_.col(c).mean();
    out.length_ = out.values_.norm();
    if (out.length_ < least_contrast * side) return std::nullopt;
    Eigen::Matrix<float, 6, 6> normal = out.slopes_.transpose() * out.slopes_;
    normal.diagonal().array() += 1e-3F * normal.trace() / 6;
    out.inverse_ = normal.inverse();
    return out;
  }

  /// The patch in `grey`, searched from `start`.
  std::optional<Placed> found(const cv::Mat& grey, const Placed& start) const {
    Placed now = start;
    for (int step = 0; step < most_steps; ++step) {
      if (!inside(grey, now, 0)) return std::nullopt;
      Values seen = sampled(grey, now);
      seen.array() -= seen.mean();
      const float length = seen.norm();
      if (length < least_contrast * side) return std::nullopt;
      seen *= length_ / length;
      const Eigen::Matrix<double, 6, 1> change = (inverse_ * (slopes_.transpose() * (seen - values_))).cast<double>();
      Eigen::Matrix2d bend;
      bend << change[2], change[3], change[4], change[5];
      now.shape = now.shape * (Eigen::Matrix2d::Identity() + bend / reach).inverse();
      now.middle -= now.shape * change.head<2>();
      if (!now.middle.allFinite() || (now.middle - start.middle).norm() > farthest_px) return std::nullopt;
      if (now.shape.determinant() < 0.1 || now.shape.norm() > 6) return std::nullopt;
      if (change.head<2>().norm() > settled_px) continue;
      const double likeness =
          static_cast<double>(seen.dot(values_)) / (static_cast<double>(length_) * static_cast<double>(length_));
      return likeness < least_likeness ? std::nullopt : std::optional<Placed>(now);
    }
    return std::nullopt;
  }

 private:
  Values values_;
  Slopes slopes_;
  Eigen::Matrix<float, 6, 6> inverse_;
  float length_ = 0;
};

const Eigen::Vector2d to_centre(0.5, 0.5);

Track refined(const std::vector<cv::Mat>& greys, const Track& track) {
  const int middle = track.first + static_cast<int>(track.pixels.size()) / 2;
  Track out{middle, {track.at(middle)}};
  const std::optional<Patch> patch = Patch::at(greys[static_cast<std::size_t>(middle)], track.at(middle) - to_centre);
  if (!patch) return out;
  // The way from one frame to the next is tracking's; only what adds up is not.
  const auto walk = [&](int step) {
    std::vector<Eigen::Vector2d> places;
    Placed placed{track.at(middle) - to_centre};
    for (int f = middle + step; track.in(f); f += step) {
      placed.middle += track.at(f) - track.at(f - step);
      const std::optional<Placed> next = patch->found(greys[static_cast<std::size_t>(f)], placed);
      if (!next) break;
      placed = *next;
      places.push_back(placed.middle + to_centre);
    }
    return places;
  };
  const std::vector<Eigen::Vector2d> before = walk(-1), after = walk(1);
  out.first = middle - static_cast<int>(before.size());
  out.pixels.assign(before.rbegin(), before.rend());
  out.pixels.push_back(track.at(middle));
  out.pixels.insert(out.pixels.end(), after.begin(), after.end());
  return out;
}

}  // namespace

std::vector<Track> refined_tracks(std::span<const ImageRgb> frames, Size size, const std::vector<Track>& tracks,
                                  ThreadPool& pool) {
  std::vector<cv::Mat> greys(frames.size());
  pool.for_ranges(0, static_cast<int>(frames.size()), 1, [&](int from, int to) {
    for (int f = from; f < to; ++f) {
      const cv::Mat grey = grey_of(frames[static_cast<std::size_t>(f)], size);
      cv::GaussianBlur(grey, greys[static_cast<std::size_t>(f)], {5, 5}, smoothing_px);
    }
  });
  std::vector<Track> out(tracks.size());
  pool.for_ranges(0, static_cast<int>(tracks.size()), 32, [&](int from, int to) {
    for (int t = from; t < to; ++t)
      out[static_cast<std::size_t>(t)] = refined(greys, tracks[static_cast<std::size_t>(t)]);
  });
  return out;
}

}  // namespace uwv::sfm
