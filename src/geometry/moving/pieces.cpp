// SPDX-License-Identifier: Apache-2.0
#include "geometry/moving/pieces.h"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <tuple>

#include "uwv/core/depth.h"

namespace uwv::moving {
namespace {

/// Parts smaller than this share of an object's largest do not say where it stands, or that it is cut.
constexpr double splinter = 0.1;

/// A static pixel beside a piece: its place relative to the foot, and its inverse depth.
struct GroundSample {
  double dx, dy, inverse_depth;
};

std::vector<GroundSample> ground_samples(const Piece& piece, const cv::Mat& labels, const DepthMap& depth, int strip) {
  const int foot_x = static_cast<int>(piece.foot.x()), foot_y = static_cast<int>(piece.foot.y());
  const int reach = std::max(strip, piece.box.width / 4);
  std::vector<GroundSample> samples;
  for (int y = foot_y + 1; y <= std::min(foot_y + strip, depth.height() - 1); ++y)
    for (int x = std::max(0, foot_x - reach); x <= std::min(foot_x + reach, depth.width() - 1); ++x)
      if (labels.at<int>(y, x) == 0 && is_valid_depth(depth(x, y)))
        samples.push_back({x + 0.5 - piece.foot.x(), y + 0.5 - piece.foot.y(), 1.0 / depth(x, y)});
  return samples;
}

/// Inverse depth as an affine function of the pixel, which is what a plane is; outliers are weighted down. The first
/// coefficient is the value at the foot. False when the samples do not look like one plane.
bool fit_plane(const std::vector<GroundSample>& samples, Eigen::Vector3d& coefficients) {
  if (samples.size() < 8) return false;
  // Everything is relative to a typical value, so that the unit of depth plays no part.
  std::vector<double> values;
  for (const GroundSample& s : samples) values.push_back(s.inverse_depth);
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
  const double typical = values[values.size() / 2];
  constexpr double tolerance = 0.02;
  Eigen::Vector3d fit(1, 0, 0);
  double spread = 0;
  for (int round = 0; round < 6; ++round) {
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    double weights = 0;
    spread = 0;
    for (const GroundSample& s : samples) {
      const Eigen::Vector3d row(1, s.dx, s.dy);
      const double value = s.inverse_depth / typical, off = value - row.dot(fit);
      const double weight = 1 / (1 + (off / tolerance) * (off / tolerance));
      normal += weight * row * row.transpose();
      right += weight * value * row;
      weights += weight;
      spread += std::min(std::abs(off), 1.0);
    }
    // A whiff of flatness decides what the samples leave open (a single row, say).
    normal(1, 1) += 1e-6 * weights;
    normal(2, 2) += 1e-6 * weights;
    fit = normal.ldlt().solve(right);
    if (!fit.allFinite()) return false;
  }
  if (!(fit[0] > 0) || spread / static_cast<double>(samples.size()) > 0.1) return false;
  coefficients = fit * typical;
  return true;
}

Eigen::Vector3d normal_towards_camera(const Eigen::Vector3d& plane, const Eigen::Vector2d& pixel, const Intrinsics& k) {
  const double sx = plane[1] / plane[0], sy = plane[2] / plane[0];
  return Eigen::Vector3d(-sx * k.fx, -sy * k.fy, sx * (pixel.x() - k.cx) + sy * (pixel.y() - k.cy) - 1).normalized();
}

/// The lowest place of a piece: the middle of what reaches down to within a tenth of its height.
Eigen::Vector2d foot_of(const Piece& piece, const cv::Mat& labels) {
  const int bottom = piece.box.y + piece.box.height - 1;
  const int slack = std::max(0, piece.box.height / 10);
  double sum = 0, count = 0;
  for (int x = piece.box.x; x < piece.box.x + piece.box.width; ++x)
    for (int y = bottom; y >= bottom - slack; --y)
      if (labels.at<int>(y, x) == piece.label) {
        sum += x + 0.5;
        count += 1;
        break;
      }
  return {count > 0 ? sum / count : piece.box.x + 0.5, bottom + 1.0};
}

/// The first static depth on a row from x on in direction `step`, a little away from the piece, where it may be
/// smeared.
float beside(const cv::Mat& labels, const DepthMap& depth, int x, int y, int step) {
  constexpr int gap = 2;
  for (x += gap * step; x >= 0 && x < depth.width(); x += step)
    if (labels.at<int>(y, x) == 0 && is_valid_depth(depth(x, y))) return 1 / depth(x, y);
  return 0;
}

/// Each known value becomes the median of the known ones around it, lest one bad row cut into the object.
void steady_rows(std::vector<float>& rows) {
  const std::vector<float> before = rows;
  const int reach = std::max(2, static_cast<int>(rows.size()) / 10), count = static_cast<int>(rows.size());
  std::vector<float> near;
  for (int y = 0; y < count; ++y) {
    near.clear();
    for (int v = std::max(0, y - reach); v <= std::min(count - 1, y + reach); ++v)
      if (before[static_cast<std::size_t>(v)] > 0) near.push_back(before[static_cast<std::size_t>(v)]);
    if (near.empty() || !(before[static_cast<std::size_t>(y)] > 0)) continue;
    std::nth_element(near.begin(), near.begin() + static_cast<std::ptrdiff_t>(near.size() / 2), near.end());
    rows[static_cast<std::size_t>(y)] = near[near.size() / 2];
  }
}

void measure_behind(Piece& piece, const cv::Mat& labels, const DepthMap& depth) {
  piece.behind.assign(static_cast<std::size_t>(piece.box.height), 0.0F);
  std::vector<float> known;
  for (int row = 0; row < piece.box.height; ++row) {
    const int y = piece.box.y + row;
    const float left = beside(labels, depth, piece.box.x, y, -1);
    const float right = beside(labels, depth, piece.box.x + piece.box.width - 1, y, 1);
    // The farther of the two: the nearer may be something the piece is behind of.
    float& behind = piece.behind[static_cast<std::size_t>(row)];
    behind = left > 0 && right > 0 ? std::min(left, right) : std::max(left, right);
    if (behind > 0) known.push_back(behind);
  }
  steady_rows(piece.behind);
  if (known.empty()) return;
  std::nth_element(known.begin(), known.begin() + static_cast<std::ptrdiff_t>(known.size() / 2), known.end());
  piece.behind_median = known[known.size() / 2];
}

}  // namespace

std::vector<Piece> find_pieces(const ValidityMask& static_pixels, cv::Mat& labels) {
  const cv::Mat moves = cv::Mat(static_pixels.height(), static_pixels.width(), CV_8U,
                                const_cast<std::uint8_t*>(static_pixels.data())) == 0;
  cv::Mat stats, centres;
  const int count = cv::connectedComponentsWithStats(moves, labels, stats, centres, 8, CV_32S);
  std::vector<Piece> pieces;
  for (int i = 1; i < count; ++i) {
    Piece piece;
    piece.label = i;
    piece.box = {stats.at<int>(i, cv::CC_STAT_LEFT), stats.at<int>(i, cv::CC_STAT_TOP),
                 stats.at<int>(i, cv::CC_STAT_WIDTH), stats.at<int>(i, cv::CC_STAT_HEIGHT)};
    piece.area = stats.at<int>(i, cv::CC_STAT_AREA);
    piece.cut_sideways = piece.box.x == 0 || piece.box.x + piece.box.width == labels.cols;
    piece.cut_upright = piece.box.y == 0 || piece.box.y + piece.box.height == labels.rows;
    piece.foot = foot_of(piece, labels);
    pieces.push_back(std::move(piece));
  }
  return pieces;
}

std::vector<Piece> join_pieces(const std::vector<Piece>& pieces, const std::vector<int>& objects, cv::Mat& labels,
                               std::vector<int>& numbers) {
  numbers = objects;
  std::sort(numbers.begin(), numbers.end());
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
  std::vector<int> new_label(pieces.size() + 1, 0);
  const auto place_of = [&](std::size_t i) {
    return static_cast<std::size_t>(std::lower_bound(numbers.begin(), numbers.end(), objects[i]) - numbers.begin());
  };
  std::vector<int> largest(numbers.size(), 0);
  for (std::size_t i = 0; i < pieces.size(); ++i) largest[place_of(i)] = std::max(largest[place_of(i)], pieces[i].area);
  std::vector<Piece> joined(numbers.size());
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    Piece& whole = joined[place_of(i)];
    whole.label = new_label[static_cast<std::size_t>(pieces[i].label)] = static_cast<int>(place_of(i)) + 1;
    whole.box = whole.area > 0 ? whole.box | pieces[i].box : pieces[i].box;
    whole.area += pieces[i].area;
    if (pieces[i].area < splinter * largest[place_of(i)]) continue;
    whole.cut_sideways = whole.cut_sideways || pieces[i].cut_sideways;
    whole.cut_upright = whole.cut_upright || pieces[i].cut_upright;
    if (pieces[i].foot.y() > whole.foot.y()) whole.foot = pieces[i].foot;
  }
  for (int y = 0; y < labels.rows; ++y)
    for (int x = 0; x < labels.cols; ++x) {
      int& label = labels.at<int>(y, x);
      label = new_label[static_cast<std::size_t>(label)];
    }
  return joined;
}

void measure_piece(Piece& piece, const cv::Mat& labels, const DepthMap& depth, const Intrinsics& k,
                   const MovingDepthOptions& options) {
  measure_behind(piece, labels, depth);
  const int strip = std::max(6, static_cast<int>(std::lround(options.contact_strip * piece.box.height)));
  Eigen::Vector3d plane;
  if (!fit_plane(ground_samples(piece, labels, depth, strip), plane)) return;
  const Eigen::Vector3d normal = normal_towards_camera(plane, piece.foot, k);
  if (!normal.allFinite()) return;
  piece.contact = plane[0];
  piece.normal_in_cam = normal;
}

std::vector<int> follow_pieces(const std::vector<Piece>& from, const cv::Mat& from_labels, const cv::Mat& flow,
                               const std::vector<Piece>& to, const cv::Mat& to_labels) {
  std::vector<std::tuple<int, int, int>> candidates;  // -count, from, to: sorting puts the largest overlap first
  const double scale_x = static_cast<double>(flow.cols) / from_labels.cols;
  const double scale_y = static_cast<double>(flow.rows) / from_labels.rows;
  for (std::size_t i = 0; i < from.size(); ++i) {
    const cv::Rect& box = from[i].box;
    const int stride = std::max(1, static_cast<int>(std::sqrt(from[i].area / 1000.0)));
    std::vector<int> hits(to.size() + 1, 0);
    int samples = 0;
    for (int y = box.y; y < box.y + box.height; y += stride)
      for (int x = box.x; x < box.x + box.width; x += stride) {
        if (from_labels.at<int>(y, x) != from[i].label) continue;
        ++samples;
        const cv::Vec2f step = flow.at<cv::Vec2f>(std::min(static_cast<int>(y * scale_y), flow.rows - 1),
                                                  std::min(static_cast<int>(x * scale_x), flow.cols - 1));
        const int u = static_cast<int>(std::floor(x + 0.5 + static_cast<double>(step[0]) / scale_x));
        const int v = static_cast<int>(std::floor(y + 0.5 + static_cast<double>(step[1]) / scale_y));
        if (u >= 0 && v >= 0 && u < to_labels.cols && v < to_labels.rows)
          ++hits[static_cast<std::size_t>(to_labels.at<int>(v, u))];
      }
    for (std::size_t j = 0; j < to.size(); ++j)
      if (hits[static_cast<std::size_t>(to[j].label)] > 0.3 * samples)
        candidates.emplace_back(-hits[static_cast<std::size_t>(to[j].label)] * stride * stride, static_cast<int>(i),
                                static_cast<int>(j));
  }
  std::sort(candidates.begin(), candidates.end());
  std::vector<int> becomes(from.size(), -1);
  std::vector<char> taken(to.size(), 0);
  for (const auto& [count, i, j] : candidates) {
    if (becomes[static_cast<std::size_t>(i)] >= 0 || taken[static_cast<std::size_t>(j)] != 0) continue;
    becomes[static_cast<std::size_t>(i)] = j;
    taken[static_cast<std::size_t>(j)] = 1;
  }
  return becomes;
}

double size_ratio(const Piece& piece, const Piece& reference) {
  const auto whole = [](const Piece& p) { return !p.cut_sideways && !p.cut_upright; };
  if (whole(piece) && whole(reference)) return std::sqrt(static_cast<double>(piece.area) / reference.area);
  if (!piece.cut_sideways && !reference.cut_sideways) return static_cast<double>(piece.box.width) / reference.box.width;
  if (!piece.cut_upright && !reference.cut_upright) return static_cast<double>(piece.box.height) / reference.box.height;
  return 1;
}

namespace {

/// The upright plane through a piece's foot that faces the camera as far as an upright plane can, leaning no more than
/// is asked for. Answers with depth relative to the foot's.
class UprightPlane {
 public:
  UprightPlane(const Piece& piece, const Stand& stand, const Intrinsics& k, double lean) : k_(k) {
    const Eigen::Vector3d foot_ray = unproject(k, piece.foot, 1.0);
    const Eigen::Vector3d level = foot_ray - stand.up_in_cam * stand.up_in_cam.dot(foot_ray);
    const bool upright = level.norm() > 0.1 * foot_ray.norm();
    facing_ = upright ? level.normalized() : foot_ray.normalized();
    offset_ = facing_.dot(foot_ray);
    double steepest = 0;
    for (const double x : {piece.box.x, piece.box.x + piece.box.width})
      for (const double y : {piece.box.y, piece.box.y + piece.box.height})
        steepest = std::max(steepest, std::abs(std::log(plain(x, y))));
    const double most = std::log1p(lean);
    gentle_ = steepest > most ? most / steepest : 1;
  }
  double at(double x, double y) const { return std::pow(plain(x, y), gentle_); }

 private:
  double plain(double x, double y) const {
    const double along = facing_.dot(unproject(k_, {x, y}, 1.0));
    return along > 0 ? std::clamp(offset_ / along, 0.5, 2.0) : 2.0;
  }

  const Intrinsics& k_;
  Eigen::Vector3d facing_;
  double offset_ = 1, gentle_ = 1;
};

/// Distance of each pixel of a piece from its outline (CV_32F, the piece's box), 0 outside; `half_width` is the
/// largest.
cv::Mat distance_from_outline(const Piece& piece, const cv::Mat& labels, double& half_width) {
  cv::Mat inside = cv::Mat::zeros(piece.box.height + 2, piece.box.width + 2, CV_8U), distance;
  for (int y = 0; y < piece.box.height; ++y)
    for (int x = 0; x < piece.box.width; ++x)
      if (labels.at<int>(piece.box.y + y, piece.box.x + x) == piece.label) inside.at<std::uint8_t>(y + 1, x + 1) = 255;
  cv::distanceTransform(inside, distance, cv::DIST_L2, 5);
  cv::minMaxLoc(distance, nullptr, &half_width);
  return distance(cv::Rect(1, 1, piece.box.width, piece.box.height));
}

}  // namespace

void paint_piece(const Piece& piece, const cv::Mat& labels, const Stand& stand, const Intrinsics& k,
                 const MovingDepthOptions& options, FrameGeometry& geometry) {
  const double z_foot = 1 / stand.at_foot;
  const UprightPlane plane(piece, stand, k, options.lean);
  double half_width = 0;
  const cv::Mat from_outline = distance_from_outline(piece, labels, half_width);
  // Relative to the foot's depth; an object is never taken to reach more than a third of the way to the camera.
  const double bulge = std::min(0.33, options.relief * half_width / std::abs(k.fx));
  for (int y = 0; y < piece.box.height; ++y)
    for (int x = 0; x < piece.box.width; ++x) {
      const double inside = from_outline.at<float>(y, x);
      if (!(inside > 0)) continue;
      const int u = piece.box.x + x, v = piece.box.y + y;
      const double rim = 1 - std::min(1.0, inside / half_width);
      double w = 1 / (z_foot * (plane.at(u + 0.5, v + 0.5) - bulge * std::sqrt(std::max(0.0, 1 - rim * rim))));
      const double behind = piece.behind[static_cast<std::size_t>(y)];
      if (behind > 0) w = std::max(w, 1.01 * behind);
      const float z = static_cast<float>(1 / w);
      const bool valid = is_valid_depth(z);
      geometry.depth(u, v) = valid ? z : 0.0F;
      geometry.confidence(u, v) = valid ? stand.confidence : 0.0F;
    }
}

}  // namespace uwv::moving
