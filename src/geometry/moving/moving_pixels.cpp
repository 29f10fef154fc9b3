// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "geometry/deterministic_cv.h"
#include "geometry/moving/dense_flow.h"
#include "geometry/moving/linked_pieces.h"
#include "geometry/moving/motion_evidence.h"
#include "geometry/moving/regions.h"
#include "uwv/core/depth.h"
#include "uwv/geometry/moving_objects.h"

namespace uwv {
namespace {

using moving::FlowPair;
using moving::InverseRange;
using moving::StaticMotion;

/// Depths within this many pixels (of the shrunk picture) are all possible, since flow blurs over edges by that much.
constexpr int edge_reach = 2;
/// Mean evidence at which a region begins. Below 1, since it is a mean over several distances, of which the longest
/// often lose a fast object.
constexpr float seed_score = 0.75F;
/// Pairs between two reports to the monitor.
constexpr int pairs_at_once = 8;
/// Frames between two reports.
constexpr int frames_at_once = 8;

/// Work on one clip, at the size flow is computed at.
class Search {
 public:
  Search(std::span<const ImageRgb> frames, std::span<const Camera> cameras, std::span<const FrameGeometry> coarse,
         const MovingOptions& options, ThreadPool& pool, Monitor& monitor)
      : frames_(frames), coarse_(coarse), options_(options), pool_(pool), monitor_(monitor) {
    size_ = moving::shrunk_size(frames[0].size(), options.flow_height);
    for (Camera camera : cameras) {
      camera.intrinsics = camera.intrinsics.resized(frames[0].size(), size_);
      camera.size = size_;
      cameras_.push_back(camera);
    }
    const std::size_t n = frames.size();
    grey_.resize(n), texture_.resize(n), score_.resize(n), ranges_.resize(n);
    ahead_evidence_.resize(n, moving::Evidence({0, 0})), back_evidence_.resize(n, moving::Evidence({0, 0}));
  }

  void run();
  const cv::Mat& score(int frame) const { return score_[at(frame)]; }
  double judged_share() const { return judged_share_; }
  bool depth_bounded() const { return std::isfinite(nearest_); }
  Size size() const { return size_; }

 private:
  static std::size_t at(int i) { return static_cast<std::size_t>(i); }
  int frame_count() const { return static_cast<int>(frames_.size()); }
  void prepare();
  void flow_at(int distance);
  void bound_from_coarse();
  void bound_from_flow(int distance);
  void make_ranges(int frame);
  void judge(int distance);
  void steady_scores();
  cv::Mat carried(const cv::Mat& score, const FlowPair& pair) const;

  std::span<const ImageRgb> frames_;
  std::span<const FrameGeometry> coarse_;
  const MovingOptions& options_;
  ThreadPool& pool_;
  Monitor& monitor_;
  Size size_;
  std::vector<Camera> cameras_;
  std::vector<cv::Mat> grey_, texture_, score_;
  std::vector<moving::Evidence> ahead_evidence_, back_evidence_;
  std::vector<std::vector<InverseRange>> ranges_;
  std::vector<FlowPair> ahead_, back_;  ///< From frame i to i + distance, and from i + distance to i.
  float nearest_ = std::numeric_limits<float>::infinity();  ///< Largest inverse depth of anything static.
  double judged_share_ = 0;
};

void Search::prepare() {
  pool_.run(frame_count(), [&](int i) {
    grey_[at(i)] = moving::shrunk_grey(frames_[at(i)], size_);
    texture_[at(i)] = moving::texture_energy(grey_[at(i)]);
    ahead_evidence_[at(i)] = moving::Evidence(size_);
    back_evidence_[at(i)] = moving::Evidence(size_);
  });
}

void Search::flow_at(int distance) {
  const int pairs = frame_count() - distance;
  ahead_.assign(at(pairs), {});
  back_.assign(at(pairs), {});
  for (int first = 0; first < pairs; first += pairs_at_once) {
    monitor_.step("optical flow", first, pairs);
    pool_.run(std::min(pairs_at_once, pairs - first), [&](int part) {
      const int i = first + part;
      FlowPair &there = ahead_[at(i)], &back = back_[at(i)];
      there.flow = moving::dense_flow(grey_[at(i)], grey_[at(i + distance)]);
      back.flow = moving::dense_flow(grey_[at(i + distance)], grey_[at(i)]);
      there.round_trip = moving::round_trip_error(there.flow, back.flow);
      back.round_trip = moving::round_trip_error(back.flow, there.flow);
    });
  }
}

/// The value below which `share` of the numbers lie.
float quantile(std::vector<float>& values, double share) {
  const auto place = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), place, values.end());
  return *place;
}

void Search::bound_from_coarse() {
  std::vector<float> found;
  for (const FrameGeometry& frame : coarse_)
    for (std::size_t i = 0; i < frame.depth.pixels().size(); i += 61)
      if (is_valid_depth(frame.depth.pixels()[i]) && frame.confidence.pixels()[i] >= 0.5F)
        found.push_back(1 / frame.depth.pixels()[i]);
  if (found.size() > 100) nearest_ = 2 * quantile(found, 0.99);
}

void Search::bound_from_flow(int distance) {
  std::vector<float> found;
  const int stride = std::max(1, static_cast<int>(ahead_.size()) / 8);
  for (int i = 0; i < static_cast<int>(ahead_.size()); i += stride)
    moving::collect_inverse_depths(StaticMotion(cameras_[at(i)], cameras_[at(i + distance)]), ahead_[at(i)],
                                   texture_[at(i)], found);
  if (found.size() > 100) nearest_ = 3 * quantile(found, 0.95);
}

void Search::make_ranges(int frame) {
  std::vector<InverseRange>& ranges = ranges_[at(frame)];
  ranges.assign(size_.pixels(), {0, nearest_});
  if (coarse_.empty()) return;
  const FrameGeometry& coarse = coarse_[at(frame)];
  const float unknown = std::numeric_limits<float>::max();
  cv::Mat low(size_.height, size_.width, CV_32F, cv::Scalar(unknown));
  cv::Mat high = cv::Mat::zeros(size_.height, size_.width, CV_32F);
  for (int y = 0; y < coarse.depth.height(); ++y)
    for (int x = 0; x < coarse.depth.width(); ++x) {
      if (!is_valid_depth(coarse.depth(x, y)) || !(coarse.confidence(x, y) >= 0.5F)) continue;
      const int u = x * size_.width / coarse.depth.width(), v = y * size_.height / coarse.depth.height();
      const float w = 1 / coarse.depth(x, y);
      low.at<float>(v, u) = std::min(low.at<float>(v, u), w);
      high.at<float>(v, u) = std::max(high.at<float>(v, u), w);
    }
  const cv::Mat known = high > 0;
  const cv::Mat window = cv::Mat::ones(2 * edge_reach + 1, 2 * edge_reach + 1, CV_8U);
  cv::erode(low, low, window);
  cv::dilate(high, high, window);
  const float tolerance = static_cast<float>(options_.depth_tolerance);
  for (int y = 0; y < size_.height; ++y)
    for (int x = 0; x < size_.width; ++x)
      if (known.at<std::uint8_t>(y, x) != 0)
        ranges[at(y) * at(size_.width) + at(x)] = {low.at<float>(y, x) * (1 - tolerance),
                                                   high.at<float>(y, x) * (1 + tolerance)};
}

void Search::judge(int distance) {
  pool_.run(frame_count(), [&](int i) {
    const auto add = [&](int other, const FlowPair& pair, moving::Evidence& evidence) {
      moving::add_evidence(StaticMotion(cameras_[at(i)], cameras_[at(other)]), pair,
                           {grey_[at(i)], texture_[at(i)], ranges_[at(i)]}, grey_[at(other)], options_, evidence);
    };
    if (i + distance < frame_count()) add(i + distance, ahead_[at(i)], ahead_evidence_[at(i)]);
    if (i - distance >= 0) add(i - distance, back_[at(i - distance)], back_evidence_[at(i)]);
  });
}

cv::Mat Search::carried(const cv::Mat& score, const FlowPair& pair) const {
  cv::Mat out(score.size(), CV_32F, cv::Scalar(-1));
  for (int y = 0; y < out.rows; ++y)
    for (int x = 0; x < out.cols; ++x) {
      if (pair.round_trip.at<float>(y, x) > 2) continue;
      const cv::Vec2f step = pair.flow.at<cv::Vec2f>(y, x);
      const int u = std::clamp(static_cast<int>(std::lround(static_cast<float>(x) + step[0])), 0, out.cols - 1);
      const int v = std::clamp(static_cast<int>(std::lround(static_cast<float>(y) + step[1])), 0, out.rows - 1);
      out.at<float>(y, x) = score.at<float>(v, u);
    }
  return out;
}

/// Median of each pixel's evidence in three frames, followed by flow; where only two know, their mean. The first and
/// the last frame, judged in one direction only, take what their neighbour knows in addition.
void Search::steady_scores() {
  std::vector<cv::Mat> steady(score_.size());
  pool_.run(frame_count(), [&](int i) {
    cv::Mat before(score_[at(i)].size(), CV_32F, cv::Scalar(-1)), after = before.clone();
    if (i > 0) before = carried(score_[at(i - 1)], back_[at(i - 1)]);
    if (i + 1 < frame_count()) after = carried(score_[at(i + 1)], ahead_[at(i)]);
    const bool at_end = i == 0 || i + 1 == frame_count();
    steady[at(i)] = score_[at(i)].clone();
    for (int y = 0; y < before.rows; ++y)
      for (int x = 0; x < before.cols; ++x) {
        const float a = before.at<float>(y, x), b = after.at<float>(y, x);
        float& own = steady[at(i)].at<float>(y, x);
        if (a >= 0 && b >= 0)
          own = std::max(std::min(a, b), std::min(std::max(a, b), own));
        else if (at_end)
          own = std::max({own, a, b});
        else if (a >= 0 || b >= 0)
          own = 0.5F * (own + std::max(a, b));
      }
  });
  score_ = std::move(steady);
}

void Search::run() {
  const DeterministicCv deterministic;
  prepare();
  if (!coarse_.empty()) bound_from_coarse();
  bool ranged = false;
  // The longest distance first: it shows most parallax, which bounds how near static things are. Distance 1 last: its
  // flow then carries the evidence from frame to frame.
  for (int step = options_.distances - 1; step >= 0; --step) {
    const int distance = 1 << step;
    if (distance >= frame_count()) continue;
    flow_at(distance);
    if (!ranged) {
      if (!depth_bounded()) bound_from_flow(distance);
      pool_.run(frame_count(), [&](int i) { make_ranges(i); });
      ranged = true;
    }
    judge(distance);
  }
  pool_.run(frame_count(),
            [&](int i) { score_[at(i)] = moving::combine_evidence(ahead_evidence_[at(i)], back_evidence_[at(i)]); });
  steady_scores();
  double judged = 0;
  for (std::size_t i = 0; i < frames_.size(); ++i)
    judged += cv::countNonZero(ahead_evidence_[i].certain_count + back_evidence_[i].certain_count);
  judged_share_ = judged / static_cast<double>(size_.pixels() * frames_.size());
}

/// Each frame's regions, from its scores and its picture.
void outline(std::span<const ImageRgb> frames, const Search& search, const MovingOptions& options, ThreadPool& pool,
             Monitor& monitor, std::vector<ValidityMask>& static_pixels) {
  const DeterministicCv deterministic;
  const double smallest = options.smallest * static_cast<double>(search.size().pixels());
  const int count = static_cast<int>(frames.size());
  for (int first = 0; first < count; first += frames_at_once) {
    monitor.step("moving objects", first, count);
    pool.run(std::min(frames_at_once, count - first), [&](int part) {
      const int i = first + part;
      const ImageRgb& frame = frames[static_cast<std::size_t>(i)];
      cv::Mat regions = moving::hysteresis(search.score(i), seed_score, options.grow);
      moving::tidy_regions(regions, smallest, 4 * smallest);
      moving::grow_to_outlines(regions, moving::shrunk_colour(frame, search.size()));
      static_pixels[static_cast<std::size_t>(i)] = moving::static_from_regions(regions, frame.size());
    });
  }
}

/// Drops what does not last, closes holes, and counts.
void tidy_over_time(const MovingOptions& options, ThreadPool& pool, MovingPixels& found) {
  const auto pixels = static_cast<double>(found.static_pixels.front().size().pixels());
  found.regions = moving::drop_fleeting(options.least_frames, options.smallest * pixels, pool, found.static_pixels);
  moving::close_holes(options.hole, pool, found.static_pixels);
  found.moving_share = 0;
  for (std::size_t i = 0; i < found.static_pixels.size(); ++i) {
    found.moving_shares[i] = 1.0 - static_cast<double>(found.static_pixels[i].count()) / pixels;
    found.moving_share += found.moving_shares[i] / static_cast<double>(found.static_pixels.size());
  }
}

void check_inputs(std::span<const ImageRgb> frames, std::span<const Camera> cameras,
                  std::span<const FrameGeometry> coarse, std::span<const ForegroundMask> foreground) {
  require(!frames.empty(), "find_moving_pixels: there are no frames");
  require(cameras.size() == frames.size(), "find_moving_pixels: {} cameras for {} frames", cameras.size(),
          frames.size());
  require(coarse.empty() || coarse.size() == frames.size(), "find_moving_pixels: {} depth maps for {} frames",
          coarse.size(), frames.size());
  require(foreground.empty() || foreground.size() == frames.size(),
          "find_moving_pixels: {} foreground masks for {} frames", foreground.size(), frames.size());
  const Size size = frames[0].size();
  require(size.width > 0 && size.height > 0, "find_moving_pixels: frames are empty");
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const bool fits = frames[i].size() == size && cameras[i].size == size &&
                      (coarse.empty() || (coarse[i].depth.size() == size && coarse[i].confidence.size() == size)) &&
                      (foreground.empty() || foreground[i].size() == size);
    require(fits, "find_moving_pixels: what belongs to frame {} is not all {}x{}", i, size.width, size.height);
  }
}

}  // namespace

void MovingOptions::check() const {
  require(flow_height >= 32 && flow_height <= 4320, "flow_height {} is outside 32..4320", flow_height);
  require(distances >= 1 && distances <= 6, "distances {} is outside 1..6", distances);
  require(noise_px > 0 && noise_px < 100, "noise_px {} is outside (0, 100)", noise_px);
  require(significance > 0 && significance < 100, "significance {} is outside (0, 100)", significance);
  require(grow > 0 && grow <= 1, "grow {} is outside (0, 1]", grow);
  require(depth_tolerance >= 0 && depth_tolerance < 1, "depth_tolerance {} is outside [0, 1)", depth_tolerance);
  require(smallest >= 0 && smallest < 1, "smallest {} is outside [0, 1)", smallest);
  require(agreement > 0 && agreement <= 1, "agreement {} is outside (0, 1]", agreement);
  require(agreement_frames >= 0, "agreement_frames {} is negative", agreement_frames);
  require(least_frames >= 1, "least_frames {} is not positive", least_frames);
  require(hole >= 0 && hole < 1, "hole {} is outside [0, 1)", hole);
}

std::string MovingPixels::brief() const {
  return fmt::format("{:.2f} % of the pixels move ({} regions in {} frames), {:.0f} % could be judged, {:.1f} s",
                     100 * moving_share, regions, static_pixels.size(), 100 * judged_share, seconds);
}

MovingPixels find_moving_pixels(std::span<const ImageRgb> frames, std::span<const Camera> cameras,
                                std::span<const FrameGeometry> coarse, const MovingOptions& options, ThreadPool& pool,
                                Monitor& monitor, std::span<const ForegroundMask> foreground) {
  options.check();
  check_inputs(frames, cameras, coarse, foreground);
  const auto begin = std::chrono::steady_clock::now();
  const Size size = frames[0].size();
  MovingPixels result;
  result.static_pixels.assign(frames.size(), ValidityMask(size, std::uint8_t{1}));
  result.moving_shares.assign(frames.size(), 0.0);
  if (frames.size() == 1) result.notes.emplace_back("one frame shows no motion: everything is taken for static");
  if (frames.size() > 1) {
    Search search(frames, cameras, coarse, options, pool, monitor);
    search.run();
    result.judged_share = search.judged_share();
    outline(frames, search, options, pool, monitor, result.static_pixels);
    tidy_over_time(options, pool, result);
    if (!foreground.empty()) take_foreground_whole(frames, foreground, options, pool, result);
    if (coarse.empty())
      result.notes.emplace_back("no depth was given: things moving along their epipolar line may pass as static");
    if (result.judged_share < 0.5)
      result.notes.push_back(
          fmt::format("flow could be judged at only {:.0f} % of the pixels (blank or blurred "
                      "pictures): motion elsewhere is not seen",
                      100 * result.judged_share));
    if (result.moving_share > 0.5)
      result.notes.push_back(fmt::format("{:.0f} % of the pixels contradict the cameras: the cameras may be wrong",
                                         100 * result.moving_share));
  }
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return result;
}

void take_foreground_whole(std::span<const ImageRgb> frames, std::span<const ForegroundMask> foreground,
                           const MovingOptions& options, ThreadPool& pool, MovingPixels& found) {
  options.check();
  require(!frames.empty() && frames.size() == foreground.size() && frames.size() == found.static_pixels.size() &&
              frames.size() == found.moving_shares.size(),
          "take_foreground_whole: {} frames, {} foreground masks and {} masks of what is static", frames.size(),
          foreground.size(), found.static_pixels.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const Size size = frames[0].size();
    require(size.pixels() > 0 && frames[i].size() == size && foreground[i].size() == size &&
                found.static_pixels[i].size() == size,
            "take_foreground_whole: what belongs to frame {} is not all {}x{}", i, size.width, size.height);
  }
  const DeterministicCv deterministic;
  moving::adopt_foreground(frames, foreground, options.agreement, options.agreement_frames, pool, found.static_pixels);
  tidy_over_time(options, pool, found);
}

}  // namespace uwv
