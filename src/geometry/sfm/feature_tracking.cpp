// SPDX-License-Identifier: Apache-2.0
#include "geometry/sfm/feature_tracking.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

#include "geometry/sfm/grey_picture.h"

namespace uwv::sfm {
namespace {

constexpr int window = 15;       // pixels; a compromise of precision (larger) and depth edges (smaller)
constexpr int levels = 4;        // 16x coarser at the top: steps up to about a tenth of the picture are followed
constexpr int back_levels = 2;   // the way back begins where it should end
constexpr double back_px = 0.5;  // tracked back, a good point returns within this

struct Picture {
  cv::Mat grey;
  std::vector<cv::Mat> pyramid;
  std::vector<float> histogram;  // 32 bins, sums to 1
};

Picture picture_of(const ImageRgb& frame, Size size) {
  Picture out;
  out.grey = grey_of(frame, size);
  cv::buildOpticalFlowPyramid(out.grey, out.pyramid, {window, window}, levels);
  out.histogram.assign(32, 0.0F);
  const float one = 1.0F / static_cast<float>(out.grey.total());
  for (int y = 0; y < out.grey.rows; ++y)
    for (int x = 0; x < out.grey.cols; ++x) out.histogram[out.grey.at<std::uint8_t>(y, x) / 8U] += one;
  return out;
}

double histogram_distance(const Picture& a, const Picture& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.histogram.size(); ++i)
    sum += std::abs(static_cast<double>(a.histogram[i]) - static_cast<double>(b.histogram[i]));
  return sum / 2;
}

/// Where the points of `from` are in `to`; NaN where the way back ends elsewhere or the point leaves the picture.
std::vector<cv::Point2f> follow(const Picture& from, const Picture& to, const std::vector<cv::Point2f>& points,
                                ThreadPool& pool) {
  std::vector<cv::Point2f> out(points.size());
  const cv::TermCriteria stop(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 30, 0.01);
  const float nan = std::nanf("");
  pool.for_ranges(0, static_cast<int>(points.size()), 128, [&](int begin, int end) {
    const std::vector<cv::Point2f> there(points.begin() + begin, points.begin() + end);
    std::vector<cv::Point2f> here, back;
    std::vector<std::uint8_t> ok, ok_back;
    std::vector<float> error;
    cv::calcOpticalFlowPyrLK(from.pyramid, to.pyramid, there, here, ok, error, {window, window}, levels, stop, 0, 1e-4);
    back = there;
    cv::calcOpticalFlowPyrLK(to.pyramid, from.pyramid, here, back, ok_back, error, {window, window}, back_levels, stop,
                             cv::OPTFLOW_USE_INITIAL_FLOW, 1e-4);
    for (std::size_t i = 0; i < there.size(); ++i) {
      const cv::Point2f gap = back[i] - there[i];
      const bool inside = here[i].x >= 1 && here[i].y >= 1 && here[i].x < static_cast<float>(to.grey.cols - 2) &&
                          here[i].y < static_cast<float>(to.grey.rows - 2);
      const bool good = ok[i] && ok_back[i] && inside && std::hypot(gap.x, gap.y) < static_cast<float>(back_px);
      out[static_cast<std::size_t>(begin) + i] = good ? here[i] : cv::Point2f(nan, nan);
    }
  });
  return out;
}

/// New corners where few points are: cells of a grid are filled up to an equal share each, so that a rich corner of the
/// picture does not take all features.
void replenish(const cv::Mat& grey, int wanted, std::vector<cv::Point2f>& points) {
  const int missing = wanted - static_cast<int>(points.size());
  if (missing < wanted / 10) return;
  const double spacing = std::max(4.0, 0.6 * std::sqrt(static_cast<double>(grey.total()) / wanted));
  cv::Mat open(grey.size(), CV_8U, cv::Scalar(255));
  for (const cv::Point2f& p : points) cv::circle(open, cv::Point(p), static_cast<int>(std::lround(spacing)), {0}, -1);
  constexpr int cells = 8;
  const int share = std::max(1, wanted / (cells * cells));
  std::vector<int> held(cells * cells, 0);
  const auto cell_of = [&](const cv::Point2f& p) {
    const int cx = std::clamp(static_cast<int>(p.x) * cells / grey.cols, 0, cells - 1);
    const int cy = std::clamp(static_cast<int>(p.y) * cells / grey.rows, 0, cells - 1);
    return static_cast<std::size_t>(cy * cells + cx);
  };
  for (const cv::Point2f& p : points) ++held[cell_of(p)];
  std::vector<cv::Point2f> found;
  cv::goodFeaturesToTrack(grey, found, 3 * wanted, 0.002, spacing, open, 5);
  std::vector<cv::Point2f> spare;
  const auto border = static_cast<float>(window / 2);
  for (const cv::Point2f& p : found) {
    if (p.x < border || p.y < border || p.x > static_cast<float>(grey.cols - 1) - border ||
        p.y > static_cast<float>(grey.rows - 1) - border)
      continue;
    (held[cell_of(p)]++ < share ? points : spare).push_back(p);
  }
  const auto room = static_cast<std::size_t>(std::max(0, wanted - static_cast<int>(points.size())));
  points.insert(points.end(), spare.begin(), spare.begin() + static_cast<std::ptrdiff_t>(std::min(room, spare.size())));
}

Eigen::Vector2d centre_rule(const cv::Point2f& p) {
  return {static_cast<double>(p.x) + 0.5, static_cast<double>(p.y) + 0.5};
}

}  // namespace

cv::Mat grey_of(const ImageRgb& frame, Size size) {
  const cv::Mat rgb(frame.height(), frame.width(), CV_8UC3, const_cast<Rgb8*>(frame.data()));
  cv::Mat out;
  cv::cvtColor(rgb, out, cv::COLOR_RGB2GRAY);
  if (frame.size() != size) cv::resize(out, out, {size.width, size.height}, 0, 0, cv::INTER_AREA);
  return out;
}

TrackedClip track_features(std::span<const ImageRgb> frames, const SfmOptions& options, ThreadPool& pool,
                           Monitor& monitor) {
  TrackedClip clip;
  clip.frames = static_cast<int>(frames.size());
  clip.size = frames.front().size();
  if (clip.size.height > options.tracking_height) {
    const double scale = static_cast<double>(options.tracking_height) / clip.size.height;
    clip.size = {std::max(1, static_cast<int>(std::lround(clip.size.width * scale))), options.tracking_height};
  }
  if (std::min(clip.size.width, clip.size.height) < 2 * window) return clip;  // no room for a window and its gradient

  Picture before = picture_of(frames.front(), clip.size);
  std::vector<cv::Point2f> points;
  std::vector<std::size_t> track_of;
  const auto begin_tracks = [&](int frame) {
    replenish(before.grey, options.max_features, points);
    for (std::size_t i = track_of.size(); i < points.size(); ++i) {
      track_of.push_back(clip.tracks.size());
      clip.tracks.push_back({frame, {centre_rule(points[i])}});
    }
  };
  begin_tracks(0);
  for (int frame = 1; frame < clip.frames; ++frame) {
    monitor.step("tracking", frame - 1, clip.frames - 1);
    Picture now = picture_of(frames[static_cast<std::size_t>(frame)], clip.size);
    std::vector<cv::Point2f> moved;
    if (!points.empty()) moved = follow(before, now, points, pool);
    const auto alive = static_cast<double>(
        std::count_if(moved.begin(), moved.end(), [](const cv::Point2f& p) { return !std::isnan(p.x); }));
    const double survival = moved.empty() ? 1 : alive / static_cast<double>(moved.size());
    const double change = histogram_distance(before, now);
    // A cut loses the tracks; fast motion loses many too, but keeps the distribution of brightness.
    const bool cut = survival < 0.08 || (survival < 0.35 && change > 0.3) || change > 0.8;
    if (cut) clip.cuts.push_back(frame);
    std::vector<cv::Point2f> kept;
    std::vector<std::size_t> kept_tracks;
    for (std::size_t i = 0; i < moved.size() && !cut; ++i) {
      if (std::isnan(moved[i].x)) continue;
      kept.push_back(moved[i]);
      kept_tracks.push_back(track_of[i]);
      clip.tracks[track_of[i]].pixels.push_back(centre_rule(moved[i]));
    }
    points = std::move(kept);
    track_of = std::move(kept_tracks);
    before = std::move(now);
    begin_tracks(frame);
  }
  return clip;
}

}  // namespace uwv::sfm
