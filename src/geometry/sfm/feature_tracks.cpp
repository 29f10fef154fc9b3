// SPDX-License-Identifier: Apache-2.0
#include "geometry/sfm/feature_tracks.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

namespace uwv::sfm {
namespace {

constexpr int pyramid_levels = 4, window = 21;
constexpr float max_return_px = 0.7F;    // farther from its start after there and back, and a point is lost
constexpr double min_corner_quality = 0.005;
constexpr double min_survivors = 0.25;   // of the points; fewer, and pictures that differ, make a cut
constexpr double max_cut_likeness = 0.75;  // correlation of histograms

/// A frame ready for tracking.
struct Grey {
  cv::Mat picture;
  std::vector<cv::Mat> pyramid;
  cv::Mat histogram;
};

Grey prepare(const ImageRgb& frame, cv::Size size) {
  const cv::Mat rgb(frame.height(), frame.width(), CV_8UC3, const_cast<Rgb8*>(frame.data()));
  Grey grey;
  cv::cvtColor(rgb, grey.picture, cv::COLOR_RGB2GRAY);
  if (grey.picture.size() != size) cv::resize(grey.picture, grey.picture, size, 0, 0, cv::INTER_AREA);
  cv::buildOpticalFlowPyramid(grey.picture, grey.pyramid, {window, window}, pyramid_levels);
  const int bins = 32, channel = 0;
  const float range[] = {0, 256};
  const float* ranges = range;
  cv::calcHist(&grey.picture, 1, &channel, {}, grey.histogram, 1, &bins, &ranges);
  return grey;
}

cv::Size tracking_size(Size size, int height) {
  const double scale = std::min(1.0, static_cast<double>(height) / size.height);
  return {std::max(1, static_cast<int>(std::lround(size.width * scale))),
          std::max(1, static_cast<int>(std::lround(size.height * scale)))};
}

/// The points under way.
class Follower {
 public:
  Follower(Size size, const SfmOptions& options)
      : full_(size), small_(tracking_size(size, options.tracking_height)), max_features_(options.max_features) {}

  void begin(const ImageRgb& frame, int index) {
    now_ = prepare(frame, small_);
    index_ = index;
    points_.clear();
    owners_.clear();
    replenish();
  }

  /// Follows everything into the next frame; false at a cut, where all tracks have ended.
  bool advance(const ImageRgb& frame, int index, double& shift) {
    Grey next = prepare(frame, small_);
    std::vector<cv::Point2f> moved, back;
    std::vector<unsigned char> found, returned;
    if (!points_.empty()) {
      const cv::Size square(window, window);
      cv::calcOpticalFlowPyrLK(now_.pyramid, next.pyramid, points_, moved, found, cv::noArray(), square, pyramid_levels);
      back = points_;
      cv::calcOpticalFlowPyrLK(next.pyramid, now_.pyramid, moved, back, returned, cv::noArray(), square, pyramid_levels,
                               {cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 30, 0.01},
                               cv::OPTFLOW_USE_INITIAL_FLOW);
    }
    std::vector<char> alive(points_.size());
    for (std::size_t i = 0; i < points_.size(); ++i)
      alive[i] = found[i] != 0 && returned[i] != 0 && inside(moved[i]) &&
                 cv::norm(back[i] - points_[i]) < max_return_px;
    const auto survivors = std::count(alive.begin(), alive.end(), 1);
    const double likeness = cv::compareHist(now_.histogram, next.histogram, cv::HISTCMP_CORREL);
    const bool few = static_cast<double>(survivors) < min_survivors * static_cast<double>(points_.size());
    now_ = std::move(next);
    index_ = index;
    if ((few || points_.size() < 8) && likeness < max_cut_likeness) {
      points_.clear();
      owners_.clear();
      replenish();
      return false;
    }
    keep(alive, moved, shift);
    replenish();
    return true;
  }

  std::vector<Track> take() { return std::move(tracks_); }

 private:
  bool inside(const cv::Point2f& p) const {
    return p.x >= 1 && p.y >= 1 && p.x < static_cast<float>(small_.width - 2) &&
           p.y < static_cast<float>(small_.height - 2);
  }
  Eigen::Vector2d full_pixel(const cv::Point2f& p) const {
    return {(p.x + 0.5) * full_.width / small_.width, (p.y + 0.5) * full_.height / small_.height};
  }

  void keep(const std::vector<char>& alive, const std::vector<cv::Point2f>& moved, double& shift) {
    std::vector<double> shifts;
    std::size_t kept = 0;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      if (alive[i] == 0) continue;
      shifts.push_back(cv::norm(moved[i] - points_[i]) * full_.width / small_.width);
      points_[kept] = moved[i];
      owners_[kept++] = owners_[i];
      tracks_[owners_[i]].pixels.push_back(full_pixel(moved[i]));
    }
    points_.resize(kept);
    owners_.resize(kept);
    shift = median(std::move(shifts));
  }

  /// New corners where none is followed, evenly over the picture.
  void replenish() {
    const int room = max_features_ - static_cast<int>(points_.size());
    if (room < max_features_ / 10 || small_.area() < 64) return;
    const double spacing = std::max(3.0, 0.6 * std::sqrt(static_cast<double>(small_.area()) / max_features_));
    cv::Mat free(small_, CV_8U, cv::Scalar(255));
    for (const cv::Point2f& p : points_) cv::circle(free, p, static_cast<int>(spacing), cv::Scalar(0), cv::FILLED);
    std::vector<cv::Point2f> corners;
    cv::goodFeaturesToTrack(now_.picture, corners, room, min_corner_quality, spacing, free, 5);
    for (const cv::Point2f& p : corners) {
      if (!inside(p)) continue;
      points_.push_back(p);
      owners_.push_back(tracks_.size());
      tracks_.push_back({index_, {full_pixel(p)}});
    }
  }

  Size full_;
  cv::Size small_;
  int max_features_, index_ = 0;
  Grey now_;
  std::vector<cv::Point2f> points_;
  std::vector<std::size_t> owners_;
  std::vector<Track> tracks_;
};

}  // namespace

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

Tracks follow_features(std::span<const ImageRgb> frames, const SfmOptions& options, ThreadPool& /*pool*/,
                       Monitor& monitor) {
  Tracks result;
  result.shift_px.assign(frames.size(), 0);
  Follower follower(frames.front().size(), options);
  follower.begin(frames.front(), 0);
  for (std::size_t i = 1; i < frames.size(); ++i) {
    monitor.step("tracking", static_cast<long>(i), static_cast<long>(frames.size()));
    if (!follower.advance(frames[i], static_cast<int>(i), result.shift_px[i])) result.cuts.push_back(static_cast<int>(i));
  }
  result.tracks = follower.take();
  std::erase_if(result.tracks, [](const Track& t) { return t.pixels.size() < 2; });
  return result;
}

std::vector<Pair> common_tracks(const std::vector<Track>& tracks, int frame_a, int frame_b) {
  std::vector<Pair> pairs;
  for (std::size_t i = 0; i < tracks.size(); ++i)
    if (tracks[i].covers(frame_a) && tracks[i].covers(frame_b))
      pairs.push_back({i, tracks[i].at(frame_a), tracks[i].at(frame_b)});
  return pairs;
}

}  // namespace uwv::sfm
