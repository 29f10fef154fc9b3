// SPDX-License-Identifier: Apache-2.0
#include "geometry/alignment/samples.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "uwv/core/depth.h"
#include "uwv/geometry/depth_composite.h"

namespace uwv {
namespace alignment {
namespace {

template <class Picture>
void require_fits(const Picture* picture, const char* what, Size size) {
  require(picture == nullptr || picture->size() == size, "the {} is {}x{}, the relative depth {}x{} pixels", what,
          picture == nullptr ? 0 : picture->width(), picture == nullptr ? 0 : picture->height(), size.width,
          size.height);
}

}  // namespace

std::uint64_t mixed(std::uint64_t seed, std::uint64_t frame) {
  std::seed_seq sequence{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32U),
                         static_cast<std::uint32_t>(frame), static_cast<std::uint32_t>(frame >> 32U)};
  std::uint32_t words[2];
  sequence.generate(words, words + 2);
  return (static_cast<std::uint64_t>(words[0]) << 32U) | words[1];
}

Samples candidates_of(const AlignmentFrame& frame, const AlignmentOptions& options) {
  require(frame.relative != nullptr && frame.reference != nullptr,
          "aligning depth wants relative and reference depth, one is missing");
  const Size size = frame.relative->size();
  require_fits(frame.reference, "reference depth", size);
  require_fits(frame.mask, "mask", size);
  require_fits(frame.weights, "picture of weights", size);
  const bool invert_x = of_inverse(options.model) != (options.relative == RelativeDepth::inverse);
  const bool invert_y = of_inverse(options.model);
  Samples samples;
  double heaviest = 0;
  for (std::size_t p = 0; p < size.pixels(); ++p) {
    if (frame.mask != nullptr && frame.mask->pixels()[p] == 0) continue;
    const double relative = static_cast<double>(frame.relative->pixels()[p]);
    const float depth = frame.reference->pixels()[p];
    const double weight = frame.weights == nullptr ? 1.0 : static_cast<double>(frame.weights->pixels()[p]);
    if (!(relative > 0) || !std::isfinite(relative) || !is_valid_depth(depth)) continue;
    if (!(weight > 0) || !std::isfinite(weight)) continue;
    const double z = static_cast<double>(depth);
    samples.push_back({invert_x ? 1 / relative : relative, invert_y ? 1 / z : z, weight});
    heaviest = std::max(heaviest, weight);
  }
  for (Sample& s : samples) s.weight /= heaviest;
  // A weight 1e-308 of the heaviest rounds to nothing.
  std::erase_if(samples, [](const Sample& s) { return !(s.weight > 0); });
  return samples;
}

void draw(Samples& samples, double share, std::size_t at_least, std::uint64_t seed) {
  const std::size_t all = samples.size();
  const auto wanted = static_cast<std::size_t>(share * static_cast<double>(all));
  const std::size_t keep = std::min(all, std::max(wanted, at_least));
  if (keep == all) return;
  // Each sample is taken with the chance that is right for what is still wanted and still to come.
  std::mt19937_64 random(seed);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < all && kept < keep; ++i)
    if (random() % (all - i) < keep - kept) samples[kept++] = samples[i];
  samples.resize(keep);
}

}  // namespace alignment

void SampleSelection::check() const {
  require(erode_window >= 1 && erode_window <= 255 && erode_window % 2 == 1,
          "erode_window {} is not an odd number in 1..255", erode_window);
  require(erode_iterations >= 0, "erode_iterations {} is negative", erode_iterations);
  require(min_relative >= 0, "min_relative {} is negative", min_relative);
  reliability.check();
}

ValidityMask alignment_samples(const Image<float>& relative_inverse, const ForegroundMask& foreground,
                               const SampleSelection& selection, ThreadPool& pool) {
  selection.check();
  require(relative_inverse.size() == foreground.size(), "the relative depth is {}x{}, its mask {}x{} pixels",
          relative_inverse.width(), relative_inverse.height(), foreground.width(), foreground.height());
  DepthMap depth(relative_inverse.size());
  std::transform(relative_inverse.pixels().begin(), relative_inverse.pixels().end(), depth.pixels().begin(),
                 [](float v) { return v > 0 ? 1.0F / v : 0.0F; });
  sanitize_depth(depth);
  ValidityMask samples = reliable_depth(depth, selection.reliability, pool);
  const ForegroundMask inside = erode_mask(foreground, selection.erode_window, selection.erode_iterations);
  for (std::size_t p = 0; p < samples.pixels().size(); ++p)
    if (inside.pixels()[p] == 0 || !(relative_inverse.pixels()[p] > selection.min_relative)) samples.pixels()[p] = 0;
  return samples;
}

}  // namespace uwv
