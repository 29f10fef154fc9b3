// SPDX-License-Identifier: Apache-2.0
// What stands on the ground of the planar prior.
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <opencv2/imgproc.hpp>

#include "geometry/layers/cv_bridge.h"
#include "geometry/layers/prior_parts.h"

namespace uwv::layers {
namespace {

constexpr float foreground_confidence = 0.25F;
constexpr double clear_of_wall = 0.97;  // of the depth behind it: a subject is not inside what it stands before

cv::Mat view_labels(Image<std::int32_t>& labels) { return {labels.height(), labels.width(), CV_32SC1, labels.data()}; }

/// Small pieces take the label of the nearest pixel of a large one.
void adopt_small(const std::vector<std::int32_t>& new_label, Image<std::int32_t>& labels) {
  cv::Mat large(labels.height(), labels.width(), CV_8U, cv::Scalar(1));
  for (int y = 0; y < labels.height(); ++y)
    for (int x = 0; x < labels.width(); ++x)
      if (new_label[static_cast<std::size_t>(labels(x, y))] > 0) large.at<std::uint8_t>(y, x) = 0;
  cv::Mat distance, nearest;
  cv::distanceTransform(large, distance, nearest, cv::DIST_L2, cv::DIST_MASK_5, cv::DIST_LABEL_PIXEL);
  std::vector<std::int32_t> label_of_zero(labels.size().pixels() + 2, 0);
  for (int y = 0; y < labels.height(); ++y)
    for (int x = 0; x < labels.width(); ++x)
      if (large.at<std::uint8_t>(y, x) == 0)
        label_of_zero[static_cast<std::size_t>(nearest.at<int>(y, x))] =
            new_label[static_cast<std::size_t>(labels(x, y))];
  for (int y = 0; y < labels.height(); ++y)
    for (int x = 0; x < labels.width(); ++x)
      if (labels(x, y) != 0) labels(x, y) = label_of_zero[static_cast<std::size_t>(nearest.at<int>(y, x))];
}

/// For each piece of `now`, the index of the piece of `before` that it overlaps most, or -1.
std::vector<int> overlap(const Pieces& before, const Pieces& now) {
  std::map<std::pair<std::int32_t, std::int32_t>, std::size_t> shared;
  for (std::size_t i = 0; i < now.labels.pixels().size(); ++i) {
    const std::int32_t a = before.labels.data()[i], b = now.labels.data()[i];
    if (a > 0 && b > 0) ++shared[{b, a}];
  }
  std::vector<int> best(now.pieces.size(), -1);
  std::vector<std::size_t> most(now.pieces.size(), 0);
  for (const auto& [labels, count] : shared) {
    const auto piece = static_cast<std::size_t>(labels.first - 1);
    if (count <= most[piece]) continue;
    most[piece] = count;
    best[piece] = labels.second - 1;
  }
  return best;
}

/// Median over the window (a foot lifted in one frame does not move the body), then the mean of the medians.
std::vector<double> steady(const std::vector<double>& values, int window) {
  if (window == 0) return values;
  const int count = static_cast<int>(values.size());
  const auto around = [&](const std::vector<double>& from, int i) {
    // Symmetric at the ends too: a lopsided window would bend a straight motion.
    const int reach = std::min({window, i, count - 1 - i});
    return std::vector<double>(from.begin() + (i - reach), from.begin() + (i + reach + 1));
  };
  std::vector<double> medians(values.size()), out(values.size());
  for (int i = 0; i < count; ++i) {
    std::vector<double> near = around(values, i);
    const auto middle = near.begin() + static_cast<std::ptrdiff_t>(near.size() / 2);
    std::nth_element(near.begin(), middle, near.end());
    medians[static_cast<std::size_t>(i)] = *middle;
  }
  for (int i = 0; i < count; ++i) {
    const std::vector<double> near = around(medians, i);
    out[static_cast<std::size_t>(i)] =
        std::accumulate(near.begin(), near.end(), 0.0) / static_cast<double>(near.size());
  }
  return out;
}

}  // namespace

Pieces find_pieces(const ForegroundMask& mask, std::size_t min_pixels) {
  Pieces out;
  out.labels = Image<std::int32_t>(mask.size());
  cv::Mat labels = view_labels(out.labels);
  cv::Mat stats, centroids;
  const int count = cv::connectedComponentsWithStats(view(mask), labels, stats, centroids, 8);
  if (count <= 1) return out;
  int largest = 1;
  for (int i = 1; i < count; ++i)
    if (stats.at<int>(i, cv::CC_STAT_AREA) > stats.at<int>(largest, cv::CC_STAT_AREA)) largest = i;
  std::vector<std::int32_t> new_label(static_cast<std::size_t>(count), 0);
  for (int i = 1; i < count; ++i) {
    const auto area = static_cast<std::size_t>(stats.at<int>(i, cv::CC_STAT_AREA));
    if (area < min_pixels && i != largest) continue;
    const int top = stats.at<int>(i, cv::CC_STAT_TOP);
    out.pieces.push_back({top, top + stats.at<int>(i, cv::CC_STAT_HEIGHT) - 1, area});
    new_label[static_cast<std::size_t>(i)] = static_cast<std::int32_t>(out.pieces.size());
  }
  adopt_small(new_label, out.labels);
  return out;
}

void track_contacts(std::vector<Pieces>& frames, int window) {
  int tracks = 0;
  for (std::size_t f = 0; f < frames.size(); ++f) {
    const std::vector<int> parent =
        f > 0 ? overlap(frames[f - 1], frames[f]) : std::vector<int>(frames[f].pieces.size(), -1);
    std::vector<int> taken;
    for (std::size_t p = 0; p < parent.size(); ++p) {
      const int track = parent[p] < 0 ? -1 : frames[f - 1].pieces[static_cast<std::size_t>(parent[p])].track;
      const bool free = track >= 0 && std::find(taken.begin(), taken.end(), track) == taken.end();
      frames[f].pieces[p].track = free ? track : tracks++;
      taken.push_back(frames[f].pieces[p].track);
    }
  }
  std::vector<std::vector<Piece*>> of_track(static_cast<std::size_t>(tracks));
  for (Pieces& frame : frames)
    for (Piece& piece : frame.pieces) of_track[static_cast<std::size_t>(piece.track)].push_back(&piece);
  for (const std::vector<Piece*>& track : of_track) {
    std::vector<double> rows;
    for (const Piece* piece : track) rows.push_back(piece->last_row + 1.0);
    const std::vector<double> steadied = steady(rows, window);
    for (std::size_t i = 0; i < track.size(); ++i) track[i]->contact = steadied[i];
  }
}

void place_pieces(const Pieces& pieces, const Layout& layout, const PlanarPriorOptions& options, FrameGeometry& frame) {
  if (pieces.pieces.empty()) return;
  const Size size = pieces.labels.size();
  cv::Mat inside(size.height, size.width, CV_8U);
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) inside.at<std::uint8_t>(y, x) = pieces.labels(x, y) != 0;
  cv::Mat to_edge;
  cv::distanceTransform(inside, to_edge, cv::DIST_L2, cv::DIST_MASK_5);
  // A mask that covers the picture has no edge to be distant from.
  const float widest = 0.25F * static_cast<float>(std::min(size.width, size.height));
  to_edge = cv::min(to_edge, std::max(widest, 1.0F));

  std::vector<double> distance, radius(pieces.pieces.size(), 0);
  for (const Piece& piece : pieces.pieces)
    distance.push_back(std::clamp(layout.ground_distance(piece.contact), options.nearest * layout.backdrop_distance,
                                  options.farthest * layout.backdrop_distance));
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x)
      if (pieces.labels(x, y) > 0) {
        double& r = radius[static_cast<std::size_t>(pieces.labels(x, y) - 1)];
        r = std::max(r, static_cast<double>(to_edge.at<float>(y, x)));
      }
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) {
      if (pieces.labels(x, y) <= 0) continue;
      const auto piece = static_cast<std::size_t>(pieces.labels(x, y) - 1);
      // Below its contact the ground is in front of it and rightly so; a wall is not.
      const double wall = frame.confidence(x, y) < ground_confidence
                              ? clear_of_wall * static_cast<double>(frame.depth(x, y))
                              : std::numeric_limits<double>::infinity();
      const double upright = std::min(wall, layout.wall_depth(y + 0.5, distance[piece]));
      const double d = to_edge.at<float>(y, x);
      const double bulge = options.relief * std::sqrt(d * (2 * radius[piece] - d)) * upright / layout.intrinsics.fx;
      // A wide lens makes a subject wider than it is far: the bulge must not reach the camera.
      frame.depth(x, y) = static_cast<float>(upright - std::min(bulge, 0.3 * upright));
      frame.confidence(x, y) = foreground_confidence;
    }
}

}  // namespace uwv::layers
