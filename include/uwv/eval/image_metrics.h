// SPDX-License-Identifier: Apache-2.0
// How alike two pictures are: PSNR and SSIM, over whole pictures or over the pixels a mask leaves.
//
// Computed in double on sRGB values in [0, 1] as they are (8-bit values divided by 255), which is how the literature
// and scikit-image compute them. Both pictures and the mask must have the same size; a difference is
// std::invalid_argument.
#pragma once

#include "uwv/core/image.h"
#include "uwv/core/mask.h"

namespace uwv {

/// A picture for metrics: `channels` planes of doubles.
class MetricImage {
 public:
  /// From interleaved values in [0, 1]; `values` holds width * height * channels of them.
  MetricImage(Size size, int channels, std::span<const float> values);
  /// Three channels, divided by 255.
  explicit MetricImage(const ImageRgb& picture);

  Size size() const { return planes_.front().size(); }
  const std::vector<Image<double>>& planes() const { return planes_; }
  /// One channel: 0.299 r + 0.587 g + 0.114 b of a three-channel picture.
  MetricImage grey() const;

 private:
  MetricImage() = default;
  std::vector<Image<double>> planes_;
};

/// Mean squared error over all channels of the pixels with mask 1 (null = all); NaN when there are none.
double mean_squared_error(const MetricImage& a, const MetricImage& b, const ValidityMask* mask = nullptr);

/// 10 log10(1 / mean squared error) in dB: infinite for equal pictures, NaN when the mask leaves nothing.
double psnr(const MetricImage& a, const MetricImage& b, const ValidityMask* mask = nullptr);

/// SSIM of Wang et al. 2004 ("Image quality assessment: from error visibility to structural similarity"): Gaussian
/// window of sigma 1.5 and side 11, K1 = 0.01, K2 = 0.03.
struct SsimOptions {
  /// The paper weights by the window alone. True multiplies variances by 121/120, scikit-image's default.
  bool sample_covariance = false;
};

/// SSIM at every pixel, per channel; beyond its edges the picture is mirrored (edge pixels repeated).
std::vector<Image<double>> ssim_map(const MetricImage& a, const MetricImage& b, const SsimOptions& options = {});

/// Mean of the SSIM map over channels and over the pixels whose 11x11 window lies inside the picture and, with a mask,
/// holds mask 1 throughout. NaN when there is no such pixel.
double ssim(const MetricImage& a, const MetricImage& b, const ValidityMask* mask = nullptr,
            const SsimOptions& options = {});

/// Pixels with mask 1 as a share of all; NaN for an empty mask.
double valid_share(const ValidityMask& mask);

}  // namespace uwv
