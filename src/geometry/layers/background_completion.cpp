// SPDX-License-Identifier: Apache-2.0
#include "uwv/geometry/background_completion.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "geometry/deterministic_cv.h"
#include "geometry/layers/completion_parts.h"
#include "geometry/layers/cv_bridge.h"

namespace uwv {
namespace {

using layers::SeenFrame;

constexpr auto own = static_cast<std::uint8_t>(BackgroundOrigin::own);
constexpr auto seen = static_cast<std::uint8_t>(BackgroundOrigin::seen);
constexpr auto invented = static_cast<std::uint8_t>(BackgroundOrigin::invented);

std::uint8_t to_byte(float value) { return static_cast<std::uint8_t>(std::clamp(value + 0.5F, 0.0F, 255.0F)); }

cv::Vec3b scaled(const cv::Vec3b& colour, const std::array<float, 3>& gain) {
  return {to_byte(gain[0] * static_cast<float>(colour[0])), to_byte(gain[1] * static_cast<float>(colour[1])),
          to_byte(gain[2] * static_cast<float>(colour[2]))};
}

/// Median by channel; `values` is reordered and not empty.
cv::Vec3b median(std::vector<cv::Vec3b>& values) {
  cv::Vec3b out;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  for (int c = 0; c < 3; ++c) {
    std::nth_element(values.begin(), middle, values.end(),
                     [c](const cv::Vec3b& a, const cv::Vec3b& b) { return a[c] < b[c]; });
    out[c] = (*middle)[c];
  }
  return out;
}

class Completion {
 public:
  Completion(std::span<const ImageRgb> frames, std::span<const ForegroundMask> foreground,
             const CompletionOptions& options, ThreadPool& pool, Monitor& monitor)
      : options_(options), pool_(pool), monitor_(monitor), count_(static_cast<int>(frames.size())) {
    const int side = 2 * options.margin_px + 1;
    const cv::Mat square = cv::getStructuringElement(cv::MORPH_RECT, {side, side});
    for (std::size_t i = 0; i < frames.size(); ++i) {
      cv::Mat grown;
      cv::dilate(layers::view(foreground[i]), grown, square);
      source_.push_back({layers::view(frames[i]), grown == 0});
      result_.frames.push_back(frames[i]);
      result_.origin.emplace_back(frames[i].size(), own);
    }
  }

  BackgroundClip run() {
    options_.camera_moves ? run_moving() : run_still();
    count_origins();
    return std::move(result_);
  }

 private:
  const SeenFrame& source(int i) const { return source_[static_cast<std::size_t>(i)]; }
  cv::Mat picture(int i) { return layers::view(result_.frames[static_cast<std::size_t>(i)]); }
  cv::Mat origin(int i) { return layers::view(result_.origin[static_cast<std::size_t>(i)]); }

  // ---- camera at rest: one picture of what is behind serves all frames ----

  /// The median of up to max_samples sightings of every pixel, as bright as the middle frame. Sightings are spread over
  /// those frames that saw it, so that a place seen in a few frames only is not missed.
  void build_reference() {
    const SeenFrame& middle = source(count_ / 2);
    std::vector<std::array<float, 3>> gain(source_.size(), {1, 1, 1});
    if (options_.match_exposure)
      pool_.run(count_, [&](int i) {
        gain[static_cast<std::size_t>(i)] = layers::exposure_gain(middle, source(i).picture, source(i).background);
      });
    reference_ = cv::Mat(middle.picture.size(), CV_8UC3, cv::Scalar::all(0));
    unseen_ = cv::Mat::zeros(middle.picture.size(), CV_8U);
    pool_.for_ranges(0, reference_.rows, 8, [&](int from, int to) {
      std::vector<int> witnesses;
      std::vector<cv::Vec3b> colours;
      for (int y = from; y < to; ++y)
        for (int x = 0; x < reference_.cols; ++x) {
          witnesses.clear();
          for (int i = 0; i < count_; ++i)
            if (source(i).background.at<std::uint8_t>(y, x) != 0) witnesses.push_back(i);
          if (witnesses.empty()) unseen_.at<std::uint8_t>(y, x) = 255;
          // A pixel that is background in all frames is needed as surroundings of an invented one only.
          const int all = static_cast<int>(witnesses.size()), taken = std::min(all, options_.max_samples);
          colours.clear();
          for (int k = 0; k < taken; ++k) {
            const int i = witnesses[static_cast<std::size_t>((2 * k + 1) * all / (2 * taken))];
            colours.push_back(scaled(source(i).picture.at<cv::Vec3b>(y, x), gain[static_cast<std::size_t>(i)]));
          }
          if (!colours.empty()) reference_.at<cv::Vec3b>(y, x) = median(colours);
        }
    });
  }

  void run_still() {
    build_reference();
    monitor_.step("background: sightings", 1, 2);
    layers::invent(reference_, unseen_, options_);
    monitor_.step("background: inventing", 2, 2);
    pool_.run(count_, [&](int i) {
      const SeenFrame& frame = source(i);
      const cv::Mat everywhere(frame.picture.size(), CV_8U, cv::Scalar(255));
      const auto gain = options_.match_exposure ? layers::exposure_gain(frame, reference_, everywhere)
                                                : std::array<float, 3>{1, 1, 1};
      cv::Mat out = picture(i), from = origin(i);
      for (int y = 0; y < out.rows; ++y)
        for (int x = 0; x < out.cols; ++x) {
          if (frame.background.at<std::uint8_t>(y, x) != 0) continue;
          out.at<cv::Vec3b>(y, x) = scaled(reference_.at<cv::Vec3b>(y, x), gain);
          from.at<std::uint8_t>(y, x) = unseen_.at<std::uint8_t>(y, x) != 0 ? invented : seen;
        }
    });
  }

  // ---- camera in motion: homographies from frame to frame ----

  /// next_from_[i] maps frame i to i + 1; a frame that could not be tied to its neighbour ends the chain there.
  void chain_frames() {
    next_from_.assign(source_.size(), cv::Mat());
    tied_.assign(source_.size(), 0);
    pool_.run(count_ - 1, [&](int i) {
      const auto at = static_cast<std::size_t>(i);
      tied_[at] = layers::background_homography(source(i), source(i + 1), next_from_[at]);
    });
    const auto broken = std::count(tied_.begin(), tied_.begin() + (count_ - 1), 0);
    if (broken > 0)
      result_.notes.push_back(
          fmt::format("{} of {} pairs of frames could not be tied by their background", broken, count_ - 1));
  }

  /// Sightings of frame i's missing pixels, nearest frames first, until all have enough of them.
  void gather(int i, std::vector<std::vector<cv::Vec3b>>& sightings, const std::vector<cv::Point>& missing) const {
    cv::Mat before = cv::Mat::eye(3, 3, CV_64F), after = before.clone();
    bool reaches_before = true, reaches_after = true;
    // Neighbours a frame apart show nearly the same: with max_samples frames the reach is covered evenly.
    const int stride = std::max(1, options_.reach_frames / (2 * options_.max_samples));
    for (int step = 1; step <= options_.reach_frames && (reaches_before || reaches_after); ++step) {
      const int a = i - step, b = i + step - 1;
      reaches_before = reaches_before && a >= 0 && tied_[static_cast<std::size_t>(a)] != 0;
      reaches_after = reaches_after && b + 1 < count_ && tied_[static_cast<std::size_t>(b)] != 0;
      if (reaches_before) before = next_from_[static_cast<std::size_t>(a)].inv() * before;
      if (reaches_after) after = next_from_[static_cast<std::size_t>(b)] * after;
      if (step % stride != 0) continue;
      if (reaches_before) look(i, a, before, missing, sightings);
      if (reaches_after) look(i, b + 1, after, missing, sightings);
    }
  }

  /// Adds what frame `other` saw at the missing pixels of frame i.
  void look(int i, int other, const cv::Mat& other_from_own, const std::vector<cv::Point>& missing,
            std::vector<std::vector<cv::Vec3b>>& sightings) const {
    const SeenFrame& frame = source(other);
    cv::Mat warped, visible;
    const cv::Size size = frame.picture.size();
    cv::warpPerspective(frame.picture, warped, other_from_own, size, cv::INTER_LINEAR | cv::WARP_INVERSE_MAP);
    cv::warpPerspective(frame.background, visible, other_from_own, size, cv::INTER_LINEAR | cv::WARP_INVERSE_MAP);
    const cv::Mat whole = visible == 255;
    const auto gain =
        options_.match_exposure ? layers::exposure_gain(source(i), warped, whole) : std::array<float, 3>{1, 1, 1};
    for (std::size_t m = 0; m < missing.size(); ++m)
      if (whole.at<std::uint8_t>(missing[m]) != 0 && static_cast<int>(sightings[m].size()) < options_.max_samples)
        sightings[m].push_back(scaled(warped.at<cv::Vec3b>(missing[m]), gain));
  }

  void fill_from_others(int i) {
    std::vector<cv::Point> missing;
    const cv::Mat hidden = source(i).background == 0;
    cv::findNonZero(hidden, missing);
    std::vector<std::vector<cv::Vec3b>> sightings(missing.size());
    gather(i, sightings, missing);
    cv::Mat out = picture(i), from = origin(i);
    for (std::size_t m = 0; m < missing.size(); ++m) {
      const bool found = !sightings[m].empty();
      from.at<std::uint8_t>(missing[m]) = found ? seen : invented;
      if (found) out.at<cv::Vec3b>(missing[m]) = median(sightings[m]);
    }
  }

  /// Takes over what was invented for the frame before, where that is known; inpaints the rest.
  void fill_rest(int i) {
    cv::Mat out = picture(i);
    cv::Mat missing = origin(i) == invented;
    if (i > 0 && tied_[static_cast<std::size_t>(i - 1)] != 0 && cv::countNonZero(missing) > 0) {
      const cv::Mat& own_from_before = next_from_[static_cast<std::size_t>(i - 1)];
      cv::Mat warped, reached;
      const cv::Mat everywhere(out.size(), CV_8U, cv::Scalar(255));
      cv::warpPerspective(picture(i - 1), warped, own_from_before, out.size());
      cv::warpPerspective(everywhere, reached, own_from_before, out.size());
      const cv::Mat carried = missing & (reached == 255);
      warped.copyTo(out, carried);
      missing &= ~carried;
    }
    layers::invent(out, missing, options_);
  }

  void run_moving() {
    chain_frames();
    monitor_.step("background: camera", 1, 1);
    pool_.run(count_, [&](int i) { fill_from_others(i); });
    monitor_.step("background: sightings", count_, count_);
    for (int i = 0; i < count_; ++i) {
      fill_rest(i);
      monitor_.step("background: inventing", i + 1, count_);
    }
  }

  void count_origins() {
    std::size_t found = 0, made = 0, all = 0;
    for (const auto& map : result_.origin) {
      found += static_cast<std::size_t>(std::count(map.pixels().begin(), map.pixels().end(), seen));
      made += static_cast<std::size_t>(std::count(map.pixels().begin(), map.pixels().end(), invented));
      all += map.pixels().size();
    }
    result_.share_seen = static_cast<double>(found) / static_cast<double>(all);
    result_.share_invented = static_cast<double>(made) / static_cast<double>(all);
  }

  const CompletionOptions& options_;
  ThreadPool& pool_;
  Monitor& monitor_;
  int count_;
  std::vector<SeenFrame> source_;
  cv::Mat reference_, unseen_;      // still
  std::vector<cv::Mat> next_from_;  // moving
  std::vector<std::uint8_t> tied_;
  BackgroundClip result_;
};

}  // namespace

void CompletionOptions::check() const {
  require(margin_px >= 0, "background: margin_px must not be negative, got {}", margin_px);
  require(max_samples >= 1, "background: max_samples must be positive, got {}", max_samples);
  require(reach_frames >= 1, "background: reach_frames must be positive, got {}", reach_frames);
  require(inpaint_radius >= 1, "background: inpaint_radius must be positive, got {}", inpaint_radius);
  require(inpaint_side >= 16, "background: inpaint_side must be at least 16, got {}", inpaint_side);
}

std::string BackgroundClip::brief() const {
  return fmt::format("background of {} frames: {:.1f} % of it seen in other frames, {:.1f} % invented", frames.size(),
                     100 * share_seen, 100 * share_invented);
}

BackgroundClip complete_background(std::span<const ImageRgb> frames, std::span<const ForegroundMask> foreground,
                                   const CompletionOptions& options, ThreadPool& pool, Monitor& monitor) {
  options.check();
  require(!frames.empty() && !frames.front().empty(), "a background needs frames, got {}", frames.size());
  require(frames.size() == foreground.size(), "{} foreground masks for {} frames", foreground.size(), frames.size());
  for (std::size_t i = 0; i < frames.size(); ++i)
    require(frames[i].size() == frames.front().size() && foreground[i].size() == frames.front().size(),
            "frame {} has {}x{} pixels and a mask of {}x{}, the first frame {}x{}", i, frames[i].width(),
            frames[i].height(), foreground[i].width(), foreground[i].height(), frames.front().width(),
            frames.front().height());
  const DeterministicCv deterministic;
  return Completion(frames, foreground, options, pool, monitor).run();
}

}  // namespace uwv
