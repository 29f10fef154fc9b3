// SPDX-License-Identifier: Apache-2.0
#include "geometry/moving/motion_evidence.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

namespace uwv::moving {
namespace {

/// Evidence of one pair counts at most this many times the significance, so that no single pair outvotes the others.
constexpr double evidence_cap = 2;
/// What a pixel counts for that looks static nowhere, but was not followed either: it lets regions grow, yet not begin.
constexpr double perhaps_evidence = 0.9;
/// Below this mean squared gradient (grey levels) nothing holds flow in place.
constexpr float least_texture = 4;
/// What the same surface differs by in grey levels between two frames of an ordinary, compressed clip.
constexpr double grey_noise = 2;

bool textured(const cv::Mat& texture, int x, int y) { return texture.at<float>(y, x) >= least_texture; }

/// Whether flow comes back to where it started.
bool consistent(const FlowPair& pair, int x, int y) {
  const cv::Vec2f step = pair.flow.at<cv::Vec2f>(y, x);
  return pair.round_trip.at<float>(y, x) < 1.0F + 0.05F * std::hypot(step[0], step[1]);
}

InverseRange range_at(const JudgedFrame& frame, int x, int y) {
  return frame
      .ranges[static_cast<std::size_t>(y) * static_cast<std::size_t>(frame.grey.cols) + static_cast<std::size_t>(x)];
}

Eigen::Vector2d pixel_centre(int x, int y) { return {x + 0.5, y + 0.5}; }

/// Compares the surroundings of a pixel in one picture with those of a place in another.
class Looks {
 public:
  Looks(const cv::Mat& from, const cv::Mat& to) {
    cv::copyMakeBorder(from, from_, reach, reach, reach, reach, cv::BORDER_REPLICATE);
    cv::copyMakeBorder(to, to_, reach, reach + 1, reach, reach + 1, cv::BORDER_REPLICATE);
    size_ = {to.cols, to.rows};
  }
  /// Mean absolute difference in grey levels over a patch; infinite when its centre leaves the picture. Some value
  /// above `limit` when that is known early.
  double difference(int x, int y, double u, double v, double limit = 256) const {
    if (!(u >= 0 && v >= 0 && u <= size_.width - 1 && v <= size_.height - 1))
      return std::numeric_limits<double>::infinity();
    const int x0 = static_cast<int>(u), y0 = static_cast<int>(v);
    const float a = static_cast<float>(u - x0), b = static_cast<float>(v - y0);
    const float most = static_cast<float>(limit) * (side * side) + 1;
    float total = 0;
    for (int dy = 0; dy < side && total <= most; ++dy) {
      const std::uint8_t* here = from_.ptr<std::uint8_t>(y + dy) + x;
      const std::uint8_t* upper = to_.ptr<std::uint8_t>(y0 + dy) + x0;
      const std::uint8_t* lower = to_.ptr<std::uint8_t>(y0 + dy + 1) + x0;
      for (int dx = 0; dx < side; ++dx) {
        const float over = static_cast<float>(upper[dx]) * (1 - a) + static_cast<float>(upper[dx + 1]) * a;
        const float under = static_cast<float>(lower[dx]) * (1 - a) + static_cast<float>(lower[dx + 1]) * a;
        total += std::fabs(over * (1 - b) + under * b - static_cast<float>(here[dx]));
      }
    }
    return total / static_cast<float>(side * side);
  }
  /// Mean absolute deviation of the patch itself: what a wrong place typically differs by.
  double contrast(int x, int y) const {
    const cv::Mat patch = from_(cv::Rect(x, y, side, side));
    return cv::mean(cv::abs(cv::Mat_<float>(patch) - cv::mean(patch)[0]))[0];
  }

 private:
  static constexpr int reach = 2, side = 2 * reach + 1;
  cv::Mat from_, to_;
  Size size_;
};

enum class Verdict { moving, perhaps, is_static, unknown };

/// Whether a place where a static point could be looks no worse than the place that flow points to. When flow points to
/// something that looks different (or is not trusted), static places are judged by themselves: `perhaps` when none
/// looks right. Unknown when all static places are out of view.
Verdict look_again(const Looks& looks, const StaticMotion& motion, int x, int y, const cv::Vec2f& step, bool trusted,
                   const InverseRange& range) {
  Eigen::Vector2d start, end;
  if (!motion.ends(pixel_centre(x, y), range, start, end)) return Verdict::unknown;
  const double contrast = looks.contrast(x, y);
  const double similar = grey_noise + 0.4 * contrast;
  const double by_flow = looks.difference(x, y, x + static_cast<double>(step[0]), y + static_cast<double>(step[1]));
  trusted = trusted && by_flow <= similar;
  const double enough = trusted ? 1.2 * by_flow + 0.5 * grey_noise + 0.15 * contrast : similar;
  // Half a pixel apart, on long ways one.
  const double length = (end - start).norm();
  const int steps = 1 + static_cast<int>(std::min(2 * length, std::max(length, 100.0)));
  bool seen = false;
  for (int i = 0; i <= steps; ++i) {
    const Eigen::Vector2d place = start + (end - start) * (static_cast<double>(i) / steps);
    const double difference = looks.difference(x, y, place.x() - 0.5, place.y() - 0.5, enough);
    if (difference <= enough) return Verdict::is_static;
    seen = seen || std::isfinite(difference);
  }
  if (!seen) return Verdict::unknown;
  return trusted ? Verdict::moving : Verdict::perhaps;
}

void add(cv::Mat& sum, cv::Mat& count, int x, int y, double evidence) {
  sum.at<float>(y, x) += static_cast<float>(evidence);
  count.at<float>(y, x) += 1;
}

/// Half the pixels, when flow agrees with the cameras everywhere, are off by less than this: what cameras and flow are
/// off by together in this pair. Bounded, since a picture full of motion must not excuse itself.
double common_error(std::vector<float>& distances) {
  if (distances.empty()) return 0;
  const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
  std::nth_element(distances.begin(), middle, distances.end());
  return std::min(1.0, 1.5 * static_cast<double>(*middle));
}

}  // namespace

StaticMotion::StaticMotion(const Camera& from, const Camera& to) {
  const Rigid3 to_from_from = target_from_source(to, from);
  infinite_ = to.intrinsics.matrix() * to_from_from.rotation * from.intrinsics.inverse_matrix();
  epipole_ = to.intrinsics.matrix() * to_from_from.translation;
  const double middle_x = to.size.width / 2.0, middle_y = to.size.height / 2.0;
  per_inverse_depth_ = std::hypot(epipole_.x() - middle_x * epipole_.z(), epipole_.y() - middle_y * epipole_.z()) +
                       0.25 * std::abs(epipole_.z()) * std::hypot(middle_x, middle_y);
  longest_px_ = 0.5 * to.size.width;
}

bool StaticMotion::segment(const Eigen::Vector2d& pixel, const InverseRange& range, Segment& out) const {
  const Eigen::Vector3d far = infinite_ * pixel.homogeneous();
  if (!(far.z() > 0)) return false;
  out.high = range.high;
  if (per_inverse_depth_ > 0) out.high = std::min(out.high, longest_px_ * far.z() / per_inverse_depth_);
  if (epipole_.z() < 0) out.high = std::min(out.high, 0.9 * far.z() / -epipole_.z());
  if (!std::isfinite(out.high)) out.high = 0;
  out.low = std::min<double>(range.low, out.high);
  out.start = far + out.low * epipole_;
  out.end = far + out.high * epipole_;
  return true;
}

bool StaticMotion::ends(const Eigen::Vector2d& pixel, const InverseRange& range, Eigen::Vector2d& start,
                        Eigen::Vector2d& end) const {
  Segment possible;
  if (!segment(pixel, range, possible)) return false;
  start = possible.start.hnormalized();
  end = possible.end.hnormalized();
  return true;
}

double StaticMotion::distance(const Eigen::Vector2d& pixel, const Eigen::Vector2d& landed, const InverseRange& range,
                              double& inverse_depth) const {
  inverse_depth = range.low;
  Segment possible;
  if (!segment(pixel, range, possible)) return -1;
  const Eigen::Vector2d start = possible.start.hnormalized(), way = possible.end.hnormalized() - start;
  const double length2 = way.squaredNorm();
  const double s = length2 > 0 ? std::clamp((landed - start).dot(way) / length2, 0.0, 1.0) : 0.0;
  // A share s of the way in the picture is this share of the inverse depth, by perspective.
  const double z0 = possible.start.z(), z1 = possible.end.z();
  inverse_depth = possible.low + s * z0 / (z1 + s * (z0 - z1)) * (possible.high - possible.low);
  return (landed - start - s * way).norm();
}

cv::Mat texture_energy(const cv::Mat& grey) {
  cv::Mat dx, dy, energy;
  cv::Sobel(grey, dx, CV_32F, 1, 0, 3, 0.125);
  cv::Sobel(grey, dy, CV_32F, 0, 1, 3, 0.125);
  energy = dx.mul(dx) + dy.mul(dy);
  cv::blur(energy, energy, cv::Size(7, 7));
  return energy;
}

Evidence::Evidence(Size size) {
  for (cv::Mat* map : {&sum, &count, &certain_sum, &certain_count})
    *map = cv::Mat::zeros(size.height, size.width, CV_32F);
}

void add_evidence(const StaticMotion& motion, const FlowPair& pair, const JudgedFrame& from, const cv::Mat& to_grey,
                  const MovingOptions& options, Evidence& out) {
  cv::Mat off(pair.flow.size(), CV_32F, cv::Scalar(-1));
  std::vector<float> distances;
  distances.reserve(pair.flow.total());
  for (int y = 0; y < pair.flow.rows; ++y)
    for (int x = 0; x < pair.flow.cols; ++x) {
      const cv::Vec2f step = pair.flow.at<cv::Vec2f>(y, x);
      if (!textured(from.texture, x, y) || !consistent(pair, x, y)) continue;
      const Eigen::Vector2d pixel = pixel_centre(x, y);
      double inverse_depth = 0;
      const double distance =
          motion.distance(pixel, pixel + Eigen::Vector2d(step[0], step[1]), range_at(from, x, y), inverse_depth);
      if (!(distance >= 0)) continue;
      off.at<float>(y, x) = static_cast<float>(distance);
      distances.push_back(static_cast<float>(distance));
    }
  const double common = common_error(distances);
  const Looks looks(from.grey, to_grey);
  for (int y = 0; y < off.rows; ++y)
    for (int x = 0; x < off.cols; ++x) {
      if (!textured(from.texture, x, y)) continue;
      const double distance = off.at<float>(y, x);
      const bool followed = distance >= 0;
      const cv::Vec2f step = pair.flow.at<cv::Vec2f>(y, x);
      const double loop = 0.5 * pair.round_trip.at<float>(y, x);
      const double drift = 0.01 * std::hypot(step[0], step[1]);
      const double uncertainty =
          std::sqrt(options.noise_px * options.noise_px + common * common + loop * loop + drift * drift);
      double evidence = followed ? std::min(evidence_cap, distance / (uncertainty * options.significance)) : 0.0;
      if (!followed || evidence >= options.grow) {
        const Verdict verdict = look_again(looks, motion, x, y, step, followed, range_at(from, x, y));
        if (verdict == Verdict::unknown) continue;
        if (verdict == Verdict::perhaps) {
          add(out.sum, out.count, x, y, perhaps_evidence);
          continue;
        }
        if (verdict == Verdict::is_static) evidence = 0;
      }
      add(out.sum, out.count, x, y, evidence);
      add(out.certain_sum, out.certain_count, x, y, evidence);
    }
}

cv::Mat combine_evidence(const Evidence& ahead, const Evidence& back) {
  cv::Mat score = cv::Mat::zeros(ahead.sum.size(), CV_32F), known = score.clone();
  for (int y = 0; y < score.rows; ++y)
    for (int x = 0; x < score.cols; ++x) {
      const float a = ahead.count.at<float>(y, x), b = back.count.at<float>(y, x);
      const float certain = ahead.certain_count.at<float>(y, x) + back.certain_count.at<float>(y, x);
      if (a > 0 && b > 0)
        score.at<float>(y, x) = std::min(ahead.sum.at<float>(y, x) / a, back.sum.at<float>(y, x) / b);
      else if (certain > 0)
        score.at<float>(y, x) = (ahead.certain_sum.at<float>(y, x) + back.certain_sum.at<float>(y, x)) / certain;
      else
        continue;
      known.at<float>(y, x) = 1;
    }
  cv::Mat near_sum, near_count;
  cv::boxFilter(score, near_sum, CV_32F, cv::Size(9, 9));
  cv::boxFilter(known, near_count, CV_32F, cv::Size(9, 9));
  for (int y = 0; y < score.rows; ++y)
    for (int x = 0; x < score.cols; ++x)
      if (known.at<float>(y, x) == 0 && near_count.at<float>(y, x) > 0.1F)
        score.at<float>(y, x) = near_sum.at<float>(y, x) / near_count.at<float>(y, x);
  cv::medianBlur(score, score, 5);
  return score;
}

void collect_inverse_depths(const StaticMotion& motion, const FlowPair& pair, const cv::Mat& texture,
                            std::vector<float>& found) {
  constexpr int stride = 4;
  const InverseRange anything{0, std::numeric_limits<float>::infinity()};
  for (int y = 0; y < pair.flow.rows; y += stride)
    for (int x = 0; x < pair.flow.cols; x += stride) {
      const cv::Vec2f step = pair.flow.at<cv::Vec2f>(y, x);
      if (!textured(texture, x, y) || !consistent(pair, x, y)) continue;
      double w = 0;
      const Eigen::Vector2d pixel = pixel_centre(x, y);
      const double distance = motion.distance(pixel, pixel + Eigen::Vector2d(step[0], step[1]), anything, w);
      if (distance >= 0 && distance < 1 && motion.parallax(w) > 1) found.push_back(static_cast<float>(w));
    }
}

}  // namespace uwv::moving
