// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "geometry/layers/cv_bridge.h"
#include "uwv/geometry/layers.h"

namespace uwv {
namespace {

std::string sentence(const std::string& finder, double share, const ForegroundOptions& options) {
  if (share >= options.min_share)
    return fmt::format("{} found a foreground of {:.1f} % of the picture", finder, 100 * share);
  return fmt::format("{} found nothing that fills {:.1f} % of the picture ({:.2f} %): {}", finder,
                     100 * options.min_share, 100 * share,
                     options.all_when_none ? "everything is foreground" : "there is no foreground");
}

bool inside(const cv::Mat& eroded, int step, std::vector<PixelIndex>& out) {
  out.clear();
  for (int y = 0; y < eroded.rows; y += step)
    for (int x = 0; x < eroded.cols; x += step)
      if (eroded.at<std::uint8_t>(y, x) != 0) out.push_back({x, y});
  return !out.empty();
}

}  // namespace

void ForegroundOptions::check() const {
  require(threshold > 0 && threshold < 1, "foreground threshold must be in (0, 1), got {}", threshold);
  require(min_share >= 0 && min_share <= 1, "smallest foreground share must be in [0, 1], got {}", min_share);
}

void PromptOptions::check() const {
  require(erode_window >= 1 && erode_window % 2 == 1, "erosion window must be odd and positive, got {}", erode_window);
  require(erode_rounds >= 0, "erosion rounds must not be negative, got {}", erode_rounds);
  require(step_decrement >= 1 && first_step >= step_decrement, "grid steps must satisfy 1 <= {} <= {}", step_decrement,
          first_step);
  require(min_points >= 1, "at least one prompt point must be wanted, got {}", min_points);
}

Foreground foreground_from(const Image<float>& probability, const std::string& finder_name,
                           const ForegroundOptions& options) {
  options.check();
  require(!probability.empty(), "a foreground needs a picture, got {}x{} pixels", probability.width(),
          probability.height());
  Foreground out;
  out.mask = ForegroundMask(probability.size());
  const auto limit = static_cast<float>(options.threshold);
  std::transform(probability.pixels().begin(), probability.pixels().end(), out.mask.pixels().begin(),
                 [&](float p) { return static_cast<std::uint8_t>(p > limit); });
  out.share = static_cast<double>(out.mask.count()) / static_cast<double>(probability.size().pixels());
  out.note = sentence(finder_name, out.share, options);
  if (out.share < options.min_share) out.mask.fill(options.all_when_none ? 1 : 0);
  return out;
}

Foreground find_foreground(const ImageRgb& picture, ForegroundFinder& finder, const ForegroundOptions& options) {
  require(!picture.empty(), "a foreground needs a picture, got {}x{} pixels", picture.width(), picture.height());
  return foreground_from(finder.find(picture), finder.name(), options);
}

Foreground foreground_from_picture(const ImageRgb& picture, Size wanted, const std::string& what) {
  if (picture.size() != wanted)
    fail(ErrorCode::size_mismatch, "{}: the foreground mask has {}x{} pixels, the frames have {}x{}; resize the mask",
         what, picture.width(), picture.height(), wanted.width, wanted.height);
  Foreground out;
  out.mask = ForegroundMask(wanted);
  std::transform(picture.pixels().begin(), picture.pixels().end(), out.mask.pixels().begin(),
                 [](Rgb8 v) { return static_cast<std::uint8_t>(v.r + v.g + v.b >= 3 * 128); });
  if (!picture.empty()) out.share = static_cast<double>(out.mask.count()) / static_cast<double>(wanted.pixels());
  out.note = fmt::format("the foreground is {:.1f} % of the picture, by the mask {}", 100 * out.share, what);
  return out;
}

std::vector<PixelIndex> prompt_points(const ForegroundMask& mask, const PromptOptions& options) {
  options.check();
  std::vector<PixelIndex> points;
  if (mask.empty()) return points;
  cv::Mat eroded;
  cv::erode(layers::view(mask), eroded, cv::Mat::ones(options.erode_window, options.erode_window, CV_8U), {-1, -1},
            options.erode_rounds);
  int step = options.first_step;
  inside(eroded, step, points);
  while (static_cast<int>(points.size()) < options.min_points && step > options.step_decrement) {
    step -= options.step_decrement;
    if (step < 1) break;
    inside(eroded, step, points);
  }
  return points;
}

ForegroundMask unite(std::span<const ForegroundMask> masks) {
  require(!masks.empty(), "a union needs at least one mask, got {}", masks.size());
  ForegroundMask out = masks.front();
  for (const ForegroundMask& mask : masks.subspan(1)) {
    require(mask.size() == out.size(), "masks to unite have {}x{} and {}x{} pixels", out.width(), out.height(),
            mask.width(), mask.height());
    std::transform(out.pixels().begin(), out.pixels().end(), mask.pixels().begin(), out.pixels().begin(),
                   [](std::uint8_t a, std::uint8_t b) { return static_cast<std::uint8_t>((a | b) != 0); });
  }
  return out;
}

ForegroundMask close_gaps(const ForegroundMask& mask, int dilate, int erode) {
  require(dilate >= 0 && erode >= 0, "closing needs counts that are not negative, got {} and {}", dilate, erode);
  ForegroundMask out = mask;
  if (mask.empty()) return out;
  const cv::Mat square = cv::Mat::ones(3, 3, CV_8U);
  cv::Mat view = layers::view(out);
  cv::Mat grown;
  cv::dilate(view, grown, square, {-1, -1}, dilate);
  cv::erode(grown, view, square, {-1, -1}, erode);
  return out;
}

}  // namespace uwv
