// SPDX-License-Identifier: Apache-2.0
#include "uwv/pipeline/compare.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "pipeline/whole_clip.h"
#include "uwv/eval/image_metrics.h"

namespace uwv {
namespace {

using pipeline::open_whole_clip;

void require_alike(const FrameSource& a, const FrameSource& b) {
  const Size one = a.info().size, other = b.info().size;
  if (one != other || a.frames() != b.frames())
    fail(ErrorCode::size_mismatch, "{} has {} frames of {}x{} pixels, {} has {} of {}x{}: they cannot be compared",
         a.info().path, a.frames(), one.width, one.height, b.info().path, b.frames(), other.width, other.height);
}

ImageRgb read(FrameSource& clip, long index) {
  ImageRgb frame;
  if (!clip.read(index, frame)) fail(ErrorCode::file_damaged, "{}: ends before frame {}", clip.info().path, index);
  return frame;
}

ValidityMask compared_pixels(const ImageRgb& generate) {
  ValidityMask mask(generate.size());
  for (std::size_t i = 0; i < mask.pixels().size(); ++i) mask.pixels()[i] = generate.pixels()[i].g > 127 ? 0 : 1;
  return mask;
}

/// The mean of what `keep` accepts.
template <class Keep>
double mean(const std::vector<FrameComparison>& frames, double FrameComparison::*field, Keep keep) {
  double sum = 0;
  long count = 0;
  for (const FrameComparison& frame : frames)
    if (keep(frame.*field)) sum += frame.*field, ++count;
  return count > 0 ? sum / static_cast<double>(count) : std::numeric_limits<double>::quiet_NaN();
}

bool is_finite(double value) { return std::isfinite(value); }

}  // namespace

void CompareOptions::check() const { require(!a.empty() && !b.empty(), "two clips are needed: --a and --b"); }

double ClipComparison::mean_psnr() const {
  const double finite = mean(frames, &FrameComparison::psnr, is_finite);
  return std::isnan(finite) && equal_frames() > 0 ? std::numeric_limits<double>::infinity() : finite;
}
double ClipComparison::mean_ssim() const { return mean(frames, &FrameComparison::ssim, is_finite); }
double ClipComparison::mean_valid_share() const { return mean(frames, &FrameComparison::valid_share, is_finite); }

long ClipComparison::equal_frames() const {
  return std::count_if(frames.begin(), frames.end(), [](const FrameComparison& f) { return std::isinf(f.psnr); });
}

std::string ClipComparison::report() const {
  return fmt::format("frames {}, PSNR {:.3f} dB, SSIM {:.4f}, compared share {:.4f}, equal frames {}\n", frames.size(),
                     mean_psnr(), mean_ssim(), mean_valid_share(), equal_frames());
}

ClipComparison compare_clips(const CompareOptions& options, Monitor& monitor) {
  options.check();
  const auto a = open_whole_clip(options.a, monitor), b = open_whole_clip(options.b, monitor);
  require_alike(*a, *b);
  const auto generate = options.mask.empty() ? nullptr : open_whole_clip(options.mask, monitor);
  if (generate) require_alike(*a, *generate);
  ClipComparison comparison;
  for (long i = 0; i < a->frames(); ++i) {
    const MetricImage one(read(*a, i)), other(read(*b, i));
    const ValidityMask mask =
        generate ? compared_pixels(read(*generate, i)) : ValidityMask(a->info().size, std::uint8_t{1});
    comparison.frames.push_back(
        {.psnr = psnr(one, other, &mask), .ssim = ssim(one, other, &mask), .valid_share = valid_share(mask)});
    monitor.step("compare", i + 1, a->frames());
  }
  return comparison;
}

}  // namespace uwv
