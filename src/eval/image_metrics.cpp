// SPDX-License-Identifier: Apache-2.0
#include "uwv/eval/image_metrics.h"

#include <array>
#include <cmath>
#include <limits>

namespace uwv {
namespace {

constexpr int window_radius = 5;  // 3.5 sigma
constexpr int window_side = 2 * window_radius + 1;
constexpr double nothing_to_average = std::numeric_limits<double>::quiet_NaN();

void require_alike(const MetricImage& a, const MetricImage& b, const ValidityMask* mask) {
  require(a.size() == b.size() && a.planes().size() == b.planes().size(),
          "cannot compare a picture of {}x{} pixels in {} channels with one of {}x{} in {}", a.size().width,
          a.size().height, a.planes().size(), b.size().width, b.size().height, b.planes().size());
  require(mask == nullptr || mask->size() == a.size(), "the mask is {}x{}, the pictures {}x{} pixels",
          mask == nullptr ? 0 : mask->width(), mask == nullptr ? 0 : mask->height(), a.size().width, a.size().height);
}

std::array<double, window_side> gaussian_window() {
  std::array<double, window_side> weights{};
  double sum = 0;
  for (int i = 0; i < window_side; ++i) {
    const double x = (i - window_radius) / 1.5;
    sum += weights[static_cast<std::size_t>(i)] = std::exp(-0.5 * x * x);
  }
  for (double& weight : weights) weight /= sum;
  return weights;
}

// Mirrors an index into [0, n): -1 -> 0, -2 -> 1, n -> n - 1; again and again where a picture is smaller than a window.
int mirrored(int i, int n) {
  const int period = 2 * n;
  i = ((i % period) + period) % period;
  return i < n ? i : period - 1 - i;
}

// A line that can be read up to window_radius beyond both its ends.
class PaddedLine {
 public:
  explicit PaddedLine(int length) : length_(length), values_(static_cast<std::size_t>(length + 2 * window_radius)) {}
  template <class Value>
  void load(const Value& value_at) {
    for (int i = -window_radius; i < length_ + window_radius; ++i)
      values_[static_cast<std::size_t>(i + window_radius)] = value_at(mirrored(i, length_));
  }
  double filtered(int i, const std::array<double, window_side>& weights) const {
    double sum = 0;
    for (std::size_t k = 0; k < weights.size(); ++k) sum += weights[k] * values_[static_cast<std::size_t>(i) + k];
    return sum;
  }

 private:
  int length_;
  std::vector<double> values_;
};

Image<double> window_mean(const Image<double>& image) {
  static const std::array<double, window_side> weights = gaussian_window();
  Image<double> rows(image.size());
  PaddedLine row(image.width());
  for (int y = 0; y < image.height(); ++y) {
    row.load([&](int x) { return image(x, y); });
    for (int x = 0; x < image.width(); ++x) rows(x, y) = row.filtered(x, weights);
  }
  // Whole rows at a time: the vertical pass reads memory in order.
  Image<double> out(image.size());
  for (int y = 0; y < image.height(); ++y) {
    for (int k = 0; k < window_side; ++k) {
      const double* from = rows.row(mirrored(y + k - window_radius, image.height()));
      const double weight = weights[static_cast<std::size_t>(k)];
      for (int x = 0; x < image.width(); ++x) out(x, y) += weight * from[x];
    }
  }
  return out;
}

Image<double> product(const Image<double>& a, const Image<double>& b) {
  Image<double> out(a.size());
  for (std::size_t i = 0; i < out.pixels().size(); ++i) out.pixels()[i] = a.pixels()[i] * b.pixels()[i];
  return out;
}

Image<double> ssim_plane(const Image<double>& a, const Image<double>& b, const SsimOptions& options) {
  constexpr double c1 = 0.01 * 0.01;
  constexpr double c2 = 0.03 * 0.03;
  constexpr double samples = window_side * window_side;
  const double scale = options.sample_covariance ? samples / (samples - 1) : 1.0;
  const Image<double> mean_a = window_mean(a);
  const Image<double> mean_b = window_mean(b);
  const Image<double> mean_aa = window_mean(product(a, a));
  const Image<double> mean_bb = window_mean(product(b, b));
  const Image<double> mean_ab = window_mean(product(a, b));
  Image<double> out(a.size());
  for (std::size_t i = 0; i < out.pixels().size(); ++i) {
    const double ma = mean_a.pixels()[i];
    const double mb = mean_b.pixels()[i];
    const double variance_a = scale * (mean_aa.pixels()[i] - ma * ma);
    const double variance_b = scale * (mean_bb.pixels()[i] - mb * mb);
    const double covariance = scale * (mean_ab.pixels()[i] - ma * mb);
    out.pixels()[i] =
        (2 * ma * mb + c1) * (2 * covariance + c2) / ((ma * ma + mb * mb + c1) * (variance_a + variance_b + c2));
  }
  return out;
}

// 1 where the whole window around a pixel lies in the picture and the mask is 1 throughout.
Image<std::uint8_t> full_windows(Size size, const ValidityMask* mask) {
  // Length of the run of usable pixels that ends here, first along rows, then of usable row windows along columns.
  Image<std::uint8_t> row_window(size);
  for (int y = 0; y < size.height; ++y) {
    int run = 0;
    for (int x = 0; x < size.width; ++x) {
      run = mask == nullptr || (*mask)(x, y) != 0 ? run + 1 : 0;
      if (run >= window_side) row_window(x - window_radius, y) = 1;
    }
  }
  Image<std::uint8_t> full(size);
  for (int x = 0; x < size.width; ++x) {
    int run = 0;
    for (int y = 0; y < size.height; ++y) {
      run = row_window(x, y) != 0 ? run + 1 : 0;
      if (run >= window_side) full(x, y - window_radius) = 1;
    }
  }
  return full;
}

}  // namespace

MetricImage::MetricImage(Size size, int channels, std::span<const float> values) {
  require(size.width > 0 && size.height > 0 && channels > 0, "a picture of {}x{} pixels in {} channels has no metrics",
          size.width, size.height, channels);
  const std::size_t n = static_cast<std::size_t>(channels);
  require(values.size() == size.pixels() * n, "{}x{} pixels in {} channels are not {} values", size.width, size.height,
          channels, values.size());
  planes_.assign(n, Image<double>(size));
  for (std::size_t i = 0; i < values.size(); ++i) planes_[i % n].pixels()[i / n] = static_cast<double>(values[i]);
}

MetricImage::MetricImage(const ImageRgb& picture) {
  require(!picture.empty(), "an empty picture has no metrics");
  planes_.assign(3, Image<double>(picture.size()));
  for (std::size_t i = 0; i < picture.pixels().size(); ++i) {
    const Rgb8 pixel = picture.pixels()[i];
    planes_[0].pixels()[i] = pixel.r / 255.0;
    planes_[1].pixels()[i] = pixel.g / 255.0;
    planes_[2].pixels()[i] = pixel.b / 255.0;
  }
}

MetricImage MetricImage::grey() const {
  require(planes_.size() == 3, "grey wants three channels, not {}", planes_.size());
  MetricImage out;
  out.planes_.emplace_back(size());
  for (std::size_t i = 0; i < size().pixels(); ++i)
    out.planes_[0].pixels()[i] =
        0.299 * planes_[0].pixels()[i] + 0.587 * planes_[1].pixels()[i] + 0.114 * planes_[2].pixels()[i];
  return out;
}

double mean_squared_error(const MetricImage& a, const MetricImage& b, const ValidityMask* mask) {
  require_alike(a, b, mask);
  double sum = 0;
  std::size_t count = 0;
  for (std::size_t c = 0; c < a.planes().size(); ++c) {
    const auto values_a = a.planes()[c].pixels();
    const auto values_b = b.planes()[c].pixels();
    for (std::size_t i = 0; i < values_a.size(); ++i) {
      if (mask != nullptr && mask->pixels()[i] == 0) continue;
      const double difference = values_a[i] - values_b[i];
      sum += difference * difference;
      ++count;
    }
  }
  return count == 0 ? nothing_to_average : sum / static_cast<double>(count);
}

double psnr(const MetricImage& a, const MetricImage& b, const ValidityMask* mask) {
  return -10 * std::log10(mean_squared_error(a, b, mask));
}

std::vector<Image<double>> ssim_map(const MetricImage& a, const MetricImage& b, const SsimOptions& options) {
  require_alike(a, b, nullptr);
  std::vector<Image<double>> map;
  for (std::size_t c = 0; c < a.planes().size(); ++c) map.push_back(ssim_plane(a.planes()[c], b.planes()[c], options));
  return map;
}

double ssim(const MetricImage& a, const MetricImage& b, const ValidityMask* mask, const SsimOptions& options) {
  require_alike(a, b, mask);
  const Image<std::uint8_t> counted = full_windows(a.size(), mask);
  double sum = 0;
  std::size_t count = 0;
  for (const Image<double>& plane : ssim_map(a, b, options)) {
    for (std::size_t i = 0; i < counted.pixels().size(); ++i) {
      if (counted.pixels()[i] == 0) continue;
      sum += plane.pixels()[i];
      ++count;
    }
  }
  return count == 0 ? nothing_to_average : sum / static_cast<double>(count);
}

double valid_share(const ValidityMask& mask) {
  if (mask.empty()) return nothing_to_average;
  return static_cast<double>(mask.count()) / static_cast<double>(mask.pixels().size());
}

}  // namespace uwv
