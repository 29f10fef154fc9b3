// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "geometry/deterministic_cv.h"
#include "geometry/layers/cv_bridge.h"
#include "uwv/geometry/saliency.h"

namespace uwv {
namespace {

/// Lab colours, float, one row a pixel of the border.
cv::Mat border_samples(const cv::Mat& lab, int width) {
  cv::Mat samples;
  for (int y = 0; y < lab.rows; ++y)
    for (int x = 0; x < lab.cols; ++x) {
      // The lower border is left out where there is more picture: subjects stand there.
      const bool at_border = y < width || x < width || x >= lab.cols - width;
      if (at_border) samples.push_back(cv::Mat(1, 3, CV_32F, const_cast<float*>(lab.ptr<float>(y, x))));
    }
  return samples;
}

cv::Mat cluster_centres(const cv::Mat& samples, int wanted) {
  const int clusters = std::min(wanted, samples.rows);
  cv::Mat labels, centres;
  cv::kmeans(samples, clusters, labels, {cv::TermCriteria::COUNT, 10, 0}, 1, cv::KMEANS_PP_CENTERS, centres);
  return centres;
}

/// Distance to the nearest colour of the border, less towards the picture's edges.
cv::Mat contrast(const cv::Mat& lab, const cv::Mat& centres) {
  cv::Mat out(lab.size(), CV_32F);
  for (int y = 0; y < lab.rows; ++y)
    for (int x = 0; x < lab.cols; ++x) {
      const float* v = lab.ptr<float>(y, x);
      float nearest = 1e9F;
      for (int c = 0; c < centres.rows; ++c) {
        const float* centre = centres.ptr<float>(c);
        const float l = v[0] - centre[0], a = v[1] - centre[1], b = v[2] - centre[2];
        nearest = std::min(nearest, 0.5F * l * l + a * a + b * b);  // light changes more easily than hue
      }
      const float dx = (static_cast<float>(x) + 0.5F) / static_cast<float>(lab.cols) - 0.5F;
      const float dy = (static_cast<float>(y) + 0.5F) / static_cast<float>(lab.rows) - 0.55F;
      out.at<float>(y, x) = std::sqrt(nearest) * std::exp(-3.0F * (dx * dx + dy * dy));
    }
  return out;
}

/// GrabCut from the soft answer; false when one of its two classes would be empty.
bool draw_outline(const cv::Mat& picture, const cv::Mat& soft, int rounds, cv::Mat& out) {
  cv::Mat classes(soft.size(), CV_8U);
  for (int y = 0; y < soft.rows; ++y)
    for (int x = 0; x < soft.cols; ++x) {
      const float p = soft.at<float>(y, x);
      classes.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(p > 0.5F    ? cv::GC_PR_FGD
                                                                 : p > 0.05F ? cv::GC_PR_BGD
                                                                             : cv::GC_BGD);
    }
  const int probable = cv::countNonZero(classes == cv::GC_PR_FGD);
  // Its colour models have five components each and want samples for them.
  if (probable < 20 || probable > classes.rows * classes.cols - 20) return false;
  cv::Mat background, foreground;
  cv::grabCut(picture, classes, {}, background, foreground, rounds, cv::GC_INIT_WITH_MASK);
  out = (classes == cv::GC_FGD) | (classes == cv::GC_PR_FGD);
  return true;
}

class ContrastFinder : public ForegroundFinder {
 public:
  explicit ContrastFinder(const ContrastFinderOptions& options) : options_(options) { options_.check(); }

  Image<float> find(const ImageRgb& picture) override {
    require(!picture.empty(), "a foreground needs a picture, got {}x{} pixels", picture.width(), picture.height());
    const DeterministicCv deterministic;
    const cv::Mat small = shrink(layers::view(picture));
    cv::Mat answer = soft_answer(small);
    cv::Mat outline;
    if (options_.outline_rounds > 0 && draw_outline(small, answer, options_.outline_rounds, outline)) {
      outline.convertTo(answer, CV_32F, 1.0 / 255);
      cv::GaussianBlur(answer, answer, {5, 5}, 0);
    }
    Image<float> out(picture.size());
    cv::Mat view = layers::view(out);
    cv::resize(answer, view, view.size(), 0, 0, cv::INTER_LINEAR);
    return out;
  }

  std::string name() const override { return "colour contrast"; }

 private:
  cv::Mat shrink(const cv::Mat& picture) const {
    const double scale =
        std::min(1.0, options_.working_side / static_cast<double>(std::max(picture.cols, picture.rows)));
    cv::Mat small;
    const cv::Size size(std::max(1, cvRound(picture.cols * scale)), std::max(1, cvRound(picture.rows * scale)));
    cv::resize(picture, small, size, 0, 0, cv::INTER_AREA);
    return small;
  }

  /// 0.5 lies at Otsu's threshold of the contrast.
  cv::Mat soft_answer(const cv::Mat& small) const {
    cv::Mat lab;
    small.convertTo(lab, CV_32F, 1.0 / 255);
    cv::cvtColor(lab, lab, cv::COLOR_RGB2Lab);
    const int width = std::max(1, cvRound(options_.border * std::min(small.cols, small.rows)));
    cv::Mat strength = contrast(lab, cluster_centres(border_samples(lab, width), options_.border_colours));
    cv::GaussianBlur(strength, strength, {0, 0}, 2.0);
    double highest = 0;
    cv::minMaxLoc(strength, nullptr, &highest);
    if (highest < options_.min_contrast) return cv::Mat::zeros(small.size(), CV_32F);
    cv::Mat bytes, thresholded;
    strength.convertTo(bytes, CV_8U, 255 / highest);
    const double split = std::max(1.0, cv::threshold(bytes, thresholded, 0, 255, cv::THRESH_OTSU));
    return cv::min(strength * (0.5 * 255 / highest / split), 1.0);
  }

  ContrastFinderOptions options_;
};

}  // namespace

void ContrastFinderOptions::check() const {
  require(working_side >= 16, "contrast finder: working_side must be at least 16, got {}", working_side);
  require(border > 0 && border < 0.5, "contrast finder: border must be in (0, 0.5), got {}", border);
  require(border_colours >= 1, "contrast finder: border_colours must be positive, got {}", border_colours);
  require(min_contrast >= 0, "contrast finder: min_contrast must not be negative, got {}", min_contrast);
  require(outline_rounds >= 0, "contrast finder: outline_rounds must not be negative, got {}", outline_rounds);
}

std::unique_ptr<ForegroundFinder> make_contrast_finder(const ContrastFinderOptions& options) {
  return std::make_unique<ContrastFinder>(options);
}

}  // namespace uwv
