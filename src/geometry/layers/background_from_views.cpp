// SPDX-License-Identifier: Apache-2.0
#include "uwv/geometry/background_from_views.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "geometry/deterministic_cv.h"
#include "geometry/layers/completion_parts.h"
#include "geometry/layers/cv_bridge.h"
#include "geometry/layers/smooth_fill.h"
#include "geometry/layers/view_sightings.h"
#include "uwv/core/depth.h"

namespace uwv {
namespace {

using layers::StaticView;

constexpr auto own = static_cast<std::uint8_t>(BackgroundOrigin::own);
constexpr auto seen = static_cast<std::uint8_t>(BackgroundOrigin::seen);
constexpr auto invented = static_cast<std::uint8_t>(BackgroundOrigin::invented);
constexpr int frames_at_once = 4;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

std::uint8_t to_byte(float value) { return static_cast<std::uint8_t>(std::clamp(value + 0.5F, 0.0F, 255.0F)); }

/// Median by channel; `values` is reordered and not empty.
Rgb8 median(std::vector<cv::Vec3f>& values) {
  float out[3];
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  for (int c = 0; c < 3; ++c) {
    std::nth_element(values.begin(), middle, values.end(),
                     [c](const cv::Vec3f& a, const cv::Vec3f& b) { return a[c] < b[c]; });
    out[c] = (*middle)[c];
  }
  return {to_byte(out[0]), to_byte(out[1]), to_byte(out[2])};
}

/// From 0.5 on a confidence is a measurement (scene_geometry.h), but for what is near a moving thing.
cv::Mat worth_of(const FrameGeometry& geometry, const cv::Mat& moves, int doubt_px) {
  cv::Mat worth(moves.size(), CV_8U, cv::Scalar(layers::guessed));
  worth.setTo(layers::measured, layers::view(geometry.confidence) >= 0.5F);
  cv::Mat near;
  cv::dilate(moves, near, cv::Mat::ones(2 * doubt_px + 1, 2 * doubt_px + 1, CV_8U));
  worth.setTo(layers::guessed, near);
  worth.setTo(layers::nothing, moves);
  return worth;
}

/// What several views say of one place: what was measured, else what was guessed.
template <class T>
struct Votes {
  std::vector<T> measured, guessed;
  void clear() { measured.clear(), guessed.clear(); }
  std::vector<T>& best() { return measured.empty() ? guessed : measured; }
};

class Completion {
 public:
  Completion(std::span<const ImageRgb> frames, std::span<const Camera> cameras, std::span<const FrameGeometry> geometry,
             std::span<const ForegroundMask> foreground, const ViewsOptions& options, ThreadPool& pool,
             Monitor& monitor)
      : options_(options), pool_(pool), monitor_(monitor), count_(static_cast<int>(frames.size())) {
    views_.resize(frames.size());
    result_.frames.assign(frames.begin(), frames.end());
    result_.depth.resize(frames.size());
    result_.origin.resize(frames.size());
    const int side = 2 * options.margin_px + 1;
    const int doubt_px = static_cast<int>(std::lround(options.doubt * frames[0].height()));
    const cv::Mat around = cv::getStructuringElement(cv::MORPH_ELLIPSE, {side, side});
    pool.run(count_, [&](int i) {
      cv::Mat grown;
      cv::dilate(layers::view(foreground[at(i)]), grown, around);
      views_[at(i)] = {&frames[at(i)], &geometry[at(i)].depth, &cameras[at(i)],
                       worth_of(geometry[at(i)], grown, doubt_px)};
      result_.depth[at(i)] = geometry[at(i)].depth;
      sanitize_depth(result_.depth[at(i)]);
      result_.origin[at(i)] = Image<std::uint8_t>(frames[at(i)].size(), own);
    });
  }

  ViewsBackground run() {
    for (int first = 0; first < count_; first += frames_at_once) {
      monitor_.step("background: sightings", first, count_);
      pool_.run(std::min(frames_at_once, count_ - first), [&](int part) {
        find_depth(first + part);
        find_colour(first + part);
      });
    }
    for (int i = 0; i < count_; ++i) {
      monitor_.step("background: inventing", i, count_);
      invent_rest(i);
    }
    count_origins();
    return std::move(result_);
  }

 private:
  cv::Mat hidden(int i) const { return views_[at(i)].worth == layers::nothing; }

  /// Frames to be asked about frame i, spread evenly over the reach.
  std::vector<int> others_of(int i) const {
    const int first = std::max(0, i - options_.reach_frames), last = std::min(count_ - 1, i + options_.reach_frames);
    const int candidates = last - first, taken = std::min(candidates, options_.views);
    std::vector<int> others;
    for (int k = 0; k < taken; ++k) {
      const int place = first + (2 * k + 1) * candidates / (2 * taken);
      others.push_back(place < i ? place : place + 1);
    }
    return others;
  }

  void find_depth(int i) {
    const cv::Mat hole = hidden(i);
    const cv::Rect box = cv::boundingRect(hole);
    if (box.area() == 0) return;
    std::vector<layers::DepthSighting> sightings;
    for (const int other : others_of(i))
      sightings.push_back(layers::splat_depth(views_[at(other)], *views_[at(i)].camera, box));
    DepthMap& depth = result_.depth[at(i)];
    cv::Mat unseen = cv::Mat::zeros(hole.size(), CV_8U);
    Votes<float> votes;
    for (int y = box.y; y < box.y + box.height; ++y)
      for (int x = box.x; x < box.x + box.width; ++x) {
        if (hole.at<std::uint8_t>(y, x) == 0) continue;
        votes.clear();
        for (const layers::DepthSighting& sighting : sightings) {
          const float sure = sighting.by_measured(y - box.y, x - box.x);
          const float vague = sighting.by_guessed(y - box.y, x - box.x);
          if (sure > 0) votes.measured.push_back(sure);
          if (vague > 0) votes.guessed.push_back(vague);
        }
        const float w = layers::agreed_surface(votes.best(), options_.depth_tolerance);
        depth(x, y) = w > 0 && is_valid_depth(1 / w) ? 1 / w : 0.0F;
        if (!(depth(x, y) > 0)) unseen.at<std::uint8_t>(y, x) = 255;
      }
    layers::fill_smoothly(depth, unseen);
  }

  /// The frames within reach that others_of leaves out, nearest first.
  std::vector<int> rest_of(int i, const std::vector<int>& asked) const {
    std::vector<int> rest;
    for (int away = 1; away <= options_.reach_frames; ++away)
      for (const int other : {i - away, i + away})
        if (other >= 0 && other < count_ && std::find(asked.begin(), asked.end(), other) == asked.end())
          rest.push_back(other);
    return rest;
  }

  /// Adds what one view says of places of frame i.
  void ask(int i, int other, const std::vector<cv::Point>& places, std::vector<Votes<cv::Vec3f>>& votes) const {
    const layers::ViewLookup lookup(*views_[at(i)].camera, views_[at(other)], options_.depth_tolerance);
    const auto factor =
        options_.match_exposure ? layers::view_gain(views_[at(i)], lookup) : std::array<float, 3>{1, 1, 1};
    const cv::Vec3f gain(factor[0], factor[1], factor[2]);
    for (std::size_t k = 0; k < places.size(); ++k) {
      const float z = result_.depth[at(i)](places[k].x, places[k].y);
      cv::Vec3f colour;
      if (!(z > 0)) continue;
      const layers::Worth worth = lookup.colour({places[k].x + 0.5, places[k].y + 0.5}, z, colour);
      if (worth == layers::measured) votes[k].measured.push_back(colour.mul(gain));
      if (worth == layers::guessed) votes[k].guessed.push_back(colour.mul(gain));
    }
  }

  void settle(int i, const std::vector<cv::Point>& places, std::vector<Votes<cv::Vec3f>>& votes) {
    for (std::size_t k = 0; k < places.size(); ++k) {
      std::vector<cv::Vec3f>& best = votes[k].best();
      result_.origin[at(i)](places[k].x, places[k].y) = best.empty() ? invented : seen;
      if (!best.empty()) result_.frames[at(i)](places[k].x, places[k].y) = median(best);
    }
  }

  void find_colour(int i) {
    std::vector<cv::Point> places;
    cv::findNonZero(hidden(i), places);
    std::vector<Votes<cv::Vec3f>> votes(places.size());
    const std::vector<int> asked = others_of(i);
    for (const int other : asked) ask(i, other, places, votes);
    settle(i, places, votes);
    // Places that no frame asked has surely seen: any other frame will do.
    std::vector<cv::Point> open;
    std::vector<Votes<cv::Vec3f>> open_votes;
    for (std::size_t k = 0; k < places.size(); ++k)
      if (votes[k].measured.empty()) {
        open.push_back(places[k]);
        open_votes.push_back(std::move(votes[k]));
      }
    if (open.empty()) return;
    for (const int other : rest_of(i, asked)) ask(i, other, open, open_votes);
    settle(i, open, open_votes);
  }

  /// Takes over what was invented for the frame before where it shows the same place; inpaints what is left.
  void invent_rest(int i) {
    cv::Mat missing = layers::view(result_.origin[at(i)]) == invented;
    if (cv::countNonZero(missing) == 0) return;
    if (i > 0) {
      // What the frame before hides or has invented; its own pixels are sightings, which were looked at already.
      StaticView before{&result_.frames[at(i - 1)], &result_.depth[at(i - 1)], views_[at(i - 1)].camera,
                        cv::Mat(missing.size(), CV_8U, cv::Scalar(layers::measured))};
      const layers::ViewLookup lookup(*views_[at(i)].camera, before, 2 * options_.depth_tolerance);
      std::vector<cv::Point> open;
      cv::findNonZero(missing, open);
      for (const cv::Point& p : open) {
        cv::Vec3f colour;
        const float z = result_.depth[at(i)](p.x, p.y);
        if (!(z > 0) || lookup.colour({p.x + 0.5, p.y + 0.5}, z, colour) == layers::nothing) continue;
        result_.frames[at(i)](p.x, p.y) = {to_byte(colour[0]), to_byte(colour[1]), to_byte(colour[2])};
        missing.at<std::uint8_t>(p) = 0;
      }
    }
    cv::Mat picture = layers::view(result_.frames[at(i)]);
    CompletionOptions inpainting;
    inpainting.inpaint_radius = options_.inpaint_radius;
    inpainting.inpaint_side = options_.inpaint_side;
    layers::invent(picture, missing, inpainting);
  }

  void count_origins() {
    double found = 0, made = 0, all = 0, blind = 0;
    for (std::size_t i = 0; i < result_.origin.size(); ++i)
      for (std::size_t p = 0; p < result_.origin[i].pixels().size(); ++p) {
        const std::uint8_t from = result_.origin[i].pixels()[p];
        found += from == seen ? 1 : 0;
        made += from == invented ? 1 : 0;
        blind += from == invented && !(result_.depth[i].pixels()[p] > 0) ? 1 : 0;
        all += 1;
      }
    result_.share_seen = found / all;
    result_.share_invented = made / all;
    if (made > 0)
      result_.notes.push_back(
          fmt::format("{:.1f} % of what is hidden was seen by no other frame that was asked: its colour is inpainted",
                      100 * made / (made + found)));
    if (blind > 0)
      result_.notes.push_back(fmt::format("{:.1f} % of what is hidden has no known depth around it and got none",
                                          100 * blind / (made + found)));
  }

  const ViewsOptions& options_;
  ThreadPool& pool_;
  Monitor& monitor_;
  int count_;
  std::vector<StaticView> views_;
  ViewsBackground result_;
};

}  // namespace

void ViewsOptions::check() const {
  require(margin_px >= 0, "background: margin_px must not be negative, got {}", margin_px);
  require(doubt >= 0 && doubt < 1, "background: doubt {} is outside [0, 1)", doubt);
  require(views >= 1, "background: views must be positive, got {}", views);
  require(reach_frames >= 1, "background: reach_frames must be positive, got {}", reach_frames);
  require(depth_tolerance > 0 && depth_tolerance < 1, "background: depth_tolerance {} is outside (0, 1)",
          depth_tolerance);
  require(inpaint_radius >= 1, "background: inpaint_radius must be positive, got {}", inpaint_radius);
  require(inpaint_side >= 16, "background: inpaint_side must be at least 16, got {}", inpaint_side);
}

std::string ViewsBackground::brief() const {
  return fmt::format("background of {} frames: {:.1f} % of it seen in other frames, {:.1f} % invented, {:.1f} s",
                     frames.size(), 100 * share_seen, 100 * share_invented, seconds);
}

ViewsBackground background_from_views(std::span<const ImageRgb> frames, std::span<const Camera> cameras,
                                      std::span<const FrameGeometry> geometry,
                                      std::span<const ForegroundMask> foreground, const ViewsOptions& options,
                                      ThreadPool& pool, Monitor& monitor) {
  options.check();
  require(!frames.empty() && cameras.size() == frames.size() && geometry.size() == frames.size() &&
              foreground.size() == frames.size(),
          "background_from_views: {} frames, {} cameras, {} depth maps and {} masks", frames.size(), cameras.size(),
          geometry.size(), foreground.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const Size size = frames[0].size();
    require(size.pixels() > 0 && frames[i].size() == size && cameras[i].size == size &&
                geometry[i].depth.size() == size && geometry[i].confidence.size() == size &&
                foreground[i].size() == size,
            "background_from_views: what belongs to frame {} is not all {}x{}", i, size.width, size.height);
  }
  const auto begin = std::chrono::steady_clock::now();
  const DeterministicCv deterministic;
  ViewsBackground result = Completion(frames, cameras, geometry, foreground, options, pool, monitor).run();
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return result;
}

}  // namespace uwv
