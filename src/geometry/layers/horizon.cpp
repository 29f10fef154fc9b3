// SPDX-License-Identifier: Apache-2.0
// The horizon from lines that are parallel in the scene: they meet in the picture at a point on it, if they are level.
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "geometry/layers/cv_bridge.h"
#include "geometry/layers/prior_parts.h"

namespace uwv::layers {
namespace {

constexpr double degree = 3.14159265358979323846 / 180;
constexpr std::size_t most_segments = 150;  // pairs grow with the square
constexpr double agreement = 1 * degree;    // of a segment with the direction to the vanishing point, and
constexpr double end_error = 0.5;           // pixels by which the segment's ends may be off
constexpr std::size_t fewest_votes = 8;
constexpr double least_share = 0.35;  // of the weight of all oblique segments

struct Segment {
  cv::Point2d middle, direction;
  double length = 0;
};

/// Segments that level lines running away from the camera could make: neither upright nor along the rows. The longest.
std::vector<Segment> oblique_segments(const ImageRgb& picture) {
  cv::Mat grey;
  cv::cvtColor(view(picture), grey, cv::COLOR_RGB2GRAY);
  std::vector<cv::Vec4f> lines;
  cv::createLineSegmentDetector()->detect(grey, lines);
  const double least = 0.02 * std::hypot(grey.cols, grey.rows);
  std::vector<Segment> out;
  for (const cv::Vec4f& l : lines) {
    const cv::Point2d a(l[0], l[1]), b(l[2], l[3]), d = b - a;
    const double length = std::hypot(d.x, d.y);
    const double slope = std::atan2(std::fabs(d.y), std::fabs(d.x));
    if (length >= least && slope > 6 * degree && slope < 70 * degree) out.push_back({(a + b) / 2, d / length, length});
  }
  std::stable_sort(out.begin(), out.end(), [](const Segment& a, const Segment& b) { return a.length > b.length; });
  if (out.size() > most_segments) out.resize(most_segments);
  return out;
}

bool meet(const Segment& a, const Segment& b, cv::Point2d& point) {
  const double cross = a.direction.cross(b.direction);
  if (std::fabs(cross) < std::sin(4 * degree)) return false;
  point = a.middle + a.direction * ((b.middle - a.middle).cross(b.direction) / cross);
  return true;
}

/// What a segment's vote weighs: its direction is as certain as it is long, and texture makes short ones.
double weight(const Segment& s) { return s.length * s.length; }

/// Weight of the segments that point at `point`, the more the better they do, and how many of them lean left and right:
/// lines of one leaning alone meet anywhere.
double support(const std::vector<Segment>& segments, const cv::Point2d& point, std::size_t& votes) {
  double sum = 0;
  std::size_t left = 0, right = 0;
  for (const Segment& s : segments) {
    const cv::Point2d to = point - s.middle;
    const double distance = std::hypot(to.x, to.y);
    // A point on the segment itself is no end of it.
    const double error = std::fabs(to.cross(s.direction)) /
                         ((std::sin(agreement) + 2 * end_error / s.length) * std::max(distance, 1e-9));
    if (distance < 0.55 * s.length || error > 1) continue;
    sum += weight(s) * (1 - error * error);
    (s.direction.x * s.direction.y > 0 ? left : right) += 1;
  }
  votes = left > 0 && right > 0 ? left + right : 0;
  return sum;
}

}  // namespace

std::optional<double> horizon_from_lines(const ImageRgb& picture) {
  if (picture.width() < 32 || picture.height() < 32) return std::nullopt;
  const std::vector<Segment> segments = oblique_segments(picture);
  double total = 0;
  for (const Segment& s : segments) total += weight(s);
  double best = 0;
  std::optional<double> row;
  for (std::size_t i = 0; i < segments.size(); ++i)
    for (std::size_t j = i + 1; j < segments.size(); ++j) {
      cv::Point2d point;
      if (!meet(segments[i], segments[j], point)) continue;
      // A camera held by people rarely has its horizon near the edges: what meets there is chance or a roof.
      if (point.y < 0.1 * picture.height() || point.y > 0.8 * picture.height()) continue;
      if (point.x < -picture.width() || point.x > 2 * picture.width()) continue;
      std::size_t votes = 0;
      const double sum = support(segments, point, votes);
      if (votes < fewest_votes || sum < least_share * total || sum <= best) continue;
      best = sum;
      row = point.y + 0.5;  // the detector counts from the first pixel's centre
    }
  return row;
}

}  // namespace uwv::layers
