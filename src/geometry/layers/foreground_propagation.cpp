// SPDX-License-Identifier: Apache-2.0
#include "uwv/geometry/foreground_propagation.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

#include "geometry/deterministic_cv.h"
#include "geometry/layers/colour_model.h"
#include "geometry/layers/cv_bridge.h"

namespace uwv {
namespace {

constexpr int flows_held = 8;           // pairs whose flow is worked out at once: also bounds memory
constexpr int surroundings_reach = 24;  // shrunk pixels around the foreground that its colours are held against

struct Shrunk {
  cv::Mat colour, grey;
};
struct FlowPair {
  cv::Mat backward, forward;  // from this frame to the one before it, and the other way
};

Shrunk shrink(const ImageRgb& frame, cv::Size size) {
  Shrunk out;
  cv::resize(layers::view(frame), out.colour, size, 0, 0, cv::INTER_AREA);
  cv::cvtColor(out.colour, out.grey, cv::COLOR_RGB2GRAY);
  return out;
}

/// Flow by dense inverse search; it refuses pictures smaller than its patches, which then do not move.
cv::Mat flow_between(const cv::Mat& from, const cv::Mat& to) {
  if (std::min(from.cols, from.rows) < 32) return cv::Mat::zeros(from.size(), CV_32FC2);
  cv::Mat flow;
  cv::DISOpticalFlow::create(cv::DISOpticalFlow::PRESET_MEDIUM)->calc(from, to, flow);
  return flow;
}

cv::Mat map_of(const cv::Mat& flow) {
  cv::Mat map(flow.size(), CV_32FC2);
  for (int y = 0; y < flow.rows; ++y)
    for (int x = 0; x < flow.cols; ++x)
      map.at<cv::Vec2f>(y, x) = flow.at<cv::Vec2f>(y, x) + cv::Vec2f(static_cast<float>(x), static_cast<float>(y));
  return map;
}

/// Box-filtered linear model of the mask in the picture's brightness: the outline moves to edges of the picture.
cv::Mat follow_edges(const cv::Mat& grey, const cv::Mat& soft) {
  constexpr double strength = 1e-3;
  const cv::Size window(7, 7);
  cv::Mat guide, mean_g, mean_s, mean_gs, mean_gg;
  grey.convertTo(guide, CV_32F, 1.0 / 255);
  cv::blur(guide, mean_g, window);
  cv::blur(soft, mean_s, window);
  cv::blur(guide.mul(soft), mean_gs, window);
  cv::blur(guide.mul(guide), mean_gg, window);
  cv::Mat slope = (mean_gs - mean_g.mul(mean_s)) / (mean_gg - mean_g.mul(mean_g) + strength);
  cv::Mat offset = mean_s - slope.mul(mean_g);
  cv::blur(slope, slope, window);
  cv::blur(offset, offset, window);
  return slope.mul(guide) + offset;
}

class Propagation {
 public:
  Propagation(std::span<const ImageRgb> frames, const ForegroundMask& first, ForegroundFinder* finder,
              const PropagationOptions& options, ThreadPool& pool, Monitor& monitor)
      : frames_(frames), finder_(finder), options_(options), pool_(pool), monitor_(monitor) {
    small_ = cv::Size(std::max(1, cvRound(first.width() * options.flow_scale)),
                      std::max(1, cvRound(first.height() * options.flow_scale)));
    result_.masks.push_back(first);
    result_.doubt.push_back(0);
    before_ = shrink(frames.front(), small_);
    cv::Mat full;
    layers::view(first).convertTo(full, CV_32F);
    cv::resize(full, soft_, small_, 0, 0, cv::INTER_AREA);
    colours_.learn(before_.colour, soft_ > 0.5, surroundings_reach, 1.0);
  }

  PropagationResult run() {
    const int count = static_cast<int>(frames_.size());
    for (int from = 1; from < count; from += flows_held) {
      const int to = std::min(count, from + flows_held);
      find_flows(from, to);
      for (int i = from; i < to; ++i) {
        advance(i, pictures_[static_cast<std::size_t>(i - from)], flows_[static_cast<std::size_t>(i - from)]);
        monitor_.step("foreground", i + 1, count);
      }
      before_ = pictures_.back();
    }
    return std::move(result_);
  }

 private:
  void find_flows(int from, int to) {
    pictures_.assign(static_cast<std::size_t>(to - from), {});
    flows_.assign(static_cast<std::size_t>(to - from), {});
    pool_.run(to - from, [&](int i) {
      pictures_[static_cast<std::size_t>(i)] = shrink(frames_[static_cast<std::size_t>(from + i)], small_);
    });
    pool_.run(2 * (to - from), [&](int job) {
      const auto i = static_cast<std::size_t>(job / 2);
      const cv::Mat &now = pictures_[i].grey, &earlier = i > 0 ? pictures_[i - 1].grey : before_.grey;
      (job % 2 == 0 ? flows_[i].backward : flows_[i].forward) =
          job % 2 == 0 ? flow_between(now, earlier) : flow_between(earlier, now);
    });
  }

  /// 255 where following the flow there and back does not end where it began.
  cv::Mat contradictions(const FlowPair& flow, const cv::Mat& map) const {
    cv::Mat there, out(flow.backward.size(), CV_8U);
    cv::remap(flow.forward, there, map, {}, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
    for (int y = 0; y < out.rows; ++y)
      for (int x = 0; x < out.cols; ++x) {
        const cv::Vec2f miss = flow.backward.at<cv::Vec2f>(y, x) + there.at<cv::Vec2f>(y, x);
        const bool doubted = !(std::hypot(miss[0], miss[1]) <= static_cast<float>(options_.consistency_px));
        out.at<std::uint8_t>(y, x) = doubted ? 255 : 0;
      }
    return out;
  }

  /// Pixels in which colour has a say: along the outline, and what is doubted near the foreground.
  cv::Mat open_pixels(const cv::Mat& inside, const cv::Mat& doubted) const {
    const auto square = [](int radius) {
      return cv::getStructuringElement(cv::MORPH_RECT, {2 * radius + 1, 2 * radius + 1});
    };
    cv::Mat grown, shrunk, near;
    cv::dilate(inside, grown, square(options_.band_px));
    cv::erode(inside, shrunk, square(options_.band_px));
    cv::dilate(inside, near, square(4 * options_.band_px));
    return (grown & ~shrunk) | (doubted & near);
  }

  void let_colour_decide(const Shrunk& now, const cv::Mat& doubted) {
    const cv::Mat open = open_pixels(soft_ > 0.5, doubted);
    const auto weight = static_cast<float>(options_.colour_weight);
    for (int y = 0; y < soft_.rows; ++y)
      for (int x = 0; x < soft_.cols; ++x) {
        if (open.at<std::uint8_t>(y, x) == 0) continue;
        float& p = soft_.at<float>(y, x);
        const float carried = std::clamp(p, 0.03F, 0.97F);
        // Where the way back contradicts, the frame before showed something else: mostly what the foreground hid.
        const bool uncertain = doubted.at<std::uint8_t>(y, x) != 0;
        const float flow = std::log(carried / (1 - carried));
        const float odds =
            (uncertain ? 0.35F * flow - 0.5F : flow) + weight * colours_.log_odds(now.colour.at<cv::Vec3b>(y, x));
        p = 1 / (1 + std::exp(-odds));
      }
    const cv::Mat followed = follow_edges(now.grey, soft_);
    followed.copyTo(soft_, open);
  }

  void advance(int frame, const Shrunk& now, const FlowPair& flow) {
    const cv::Mat map = map_of(flow.backward);
    cv::Mat carried;
    cv::remap(soft_, carried, map, {}, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
    soft_ = carried;
    const cv::Mat doubted = contradictions(flow, map);
    const cv::Mat inside = soft_ > 0.5;
    const int area = cv::countNonZero(inside);
    result_.doubt.push_back(area > 0 ? static_cast<double>(cv::countNonZero(inside & doubted)) / area : 0);
    if (options_.colour_weight > 0) let_colour_decide(now, doubted);
    if (options_.reanchor_every > 0 && frame % options_.reanchor_every == 0) reanchor(frame);
    // Hard again, but for the outline: soft edges would grow softer with every frame.
    soft_ = cv::max(cv::min((soft_ - 0.5) * 2 + 0.5, 1.0), 0.0);
    const cv::Mat mask = soft_ > 0.5;
    if (options_.learning_rate > 0) colours_.learn(now.colour, mask, surroundings_reach, options_.learning_rate);
    deliver(frame, area > 0 && cv::countNonZero(mask) == 0);
  }

  void reanchor(int frame) {
    const Image<float> found = finder_->find(frames_[static_cast<std::size_t>(frame)]);
    cv::Mat small;
    cv::resize(layers::view(found), small, small_, 0, 0, cv::INTER_AREA);
    const cv::Mat ours = soft_ > 0.5, theirs = small > 0.5;
    const double both = cv::countNonZero(ours & theirs), either = cv::countNonZero(ours | theirs);
    const double overlap = either > 0 ? both / either : 0;
    const bool taken = overlap >= options_.reanchor_overlap;
    if (taken) soft_ = 0.4 * soft_ + 0.6 * small;
    result_.notes.push_back(fmt::format("frame {}: {} shares {:.0f} % with the foreground followed so far and was {}",
                                        frame, finder_->name(), 100 * overlap, taken ? "taken" : "not taken"));
  }

  void deliver(int frame, bool lost) {
    const Size size = frames_.front().size();
    ForegroundMask mask(size);
    cv::Mat full;
    cv::resize(soft_, full, {size.width, size.height}, 0, 0, cv::INTER_LINEAR);
    for (int y = 0; y < size.height; ++y)
      for (int x = 0; x < size.width; ++x) mask(x, y) = full.at<float>(y, x) > 0.5F;
    result_.masks.push_back(std::move(mask));
    if (lost) result_.notes.push_back(fmt::format("the foreground is lost from frame {} on", frame));
  }

  std::span<const ImageRgb> frames_;
  ForegroundFinder* finder_;
  const PropagationOptions& options_;
  ThreadPool& pool_;
  Monitor& monitor_;
  cv::Size small_;
  cv::Mat soft_;  // foreground's probability in the frame reached
  Shrunk before_;
  std::vector<Shrunk> pictures_;
  std::vector<FlowPair> flows_;
  layers::ColourModel colours_;
  PropagationResult result_;
};

}  // namespace

void PropagationOptions::check() const {
  require(flow_scale > 0 && flow_scale <= 1, "propagation: flow_scale must be in (0, 1], got {}", flow_scale);
  require(consistency_px > 0, "propagation: consistency_px must be positive, got {}", consistency_px);
  require(band_px >= 1, "propagation: band_px must be positive, got {}", band_px);
  require(colour_weight >= 0 && std::isfinite(colour_weight), "propagation: colour_weight must not be negative, got {}",
          colour_weight);
  require(learning_rate >= 0 && learning_rate <= 1, "propagation: learning_rate must be in [0, 1], got {}",
          learning_rate);
  require(reanchor_every >= 0, "propagation: reanchor_every must not be negative, got {}", reanchor_every);
  require(reanchor_overlap >= 0 && reanchor_overlap <= 1, "propagation: reanchor_overlap must be in [0, 1], got {}",
          reanchor_overlap);
}

std::string PropagationResult::brief() const {
  double first = 0, last = 0, doubted = 0;
  if (!masks.empty() && !masks.front().empty()) {
    const auto pixels = static_cast<double>(masks.front().size().pixels());
    first = static_cast<double>(masks.front().count()) / pixels;
    last = static_cast<double>(masks.back().count()) / pixels;
  }
  for (const double share : doubt) doubted = std::max(doubted, share);
  return fmt::format(
      "foreground followed through {} frames: {:.1f} % of the first, {:.1f} % of the last, at most {:.0f} % doubted",
      masks.size(), 100 * first, 100 * last, 100 * doubted);
}

PropagationResult propagate_foreground(std::span<const ImageRgb> frames, const ForegroundMask& first,
                                       ForegroundFinder* finder, const PropagationOptions& options, ThreadPool& pool,
                                       Monitor& monitor) {
  options.check();
  require(!frames.empty() && !frames.front().empty(), "a foreground needs frames to be followed through, got {}",
          frames.size());
  require(options.reanchor_every == 0 || finder != nullptr, "re-anchoring every {} frames needs a finder",
          options.reanchor_every);
  for (const ImageRgb& frame : frames)
    require(frame.size() == first.size(), "the first mask has {}x{} pixels, a frame {}x{}", first.width(),
            first.height(), frame.width(), frame.height());
  const DeterministicCv deterministic;
  return Propagation(frames, first, finder, options, pool, monitor).run();
}

}  // namespace uwv
