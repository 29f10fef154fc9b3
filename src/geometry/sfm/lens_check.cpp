// SPDX-License-Identifier: Apache-2.0
#include "geometry/sfm/lens_check.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace uwv::sfm {
namespace {

constexpr double other_lens = 1.15;     // ratio of focal lengths; a clip's own estimate may be off by a few per cent
constexpr double clearly_worse = 1.15;  // ratio of root mean square errors
constexpr double noise_px = 0.005;      // both errors below some of these say nothing

double fov_deg(const Intrinsics& lens, Size size) {
  return 2 * std::atan(0.5 * size.width / lens.fx) * 180 / std::numbers::pi;
}

bool differ(const LensFit& given, const LensFit& seen) {
  const double ratio = std::abs(std::log(seen.lens.fx / given.lens.fx));
  return ratio > std::log(other_lens) && given.error_px > clearly_worse * seen.error_px + noise_px;
}

}  // namespace

std::optional<LensDoubt> doubt_of(const LensFit& given, const LensFit& seen, Size size) {
  if (!differ(given, seen)) return std::nullopt;
  return LensDoubt{fov_deg(given.lens, size), fov_deg(seen.lens, size), given.error_px, seen.error_px};
}

bool lens_is_suspect(const std::vector<Trial>& trials, const Intrinsics& given) {
  const auto fixed = [](const Trial& trial) { return trial.guess == 0; };
  const auto best_given = std::find_if(trials.begin(), trials.end(), fixed);
  const auto best_free = std::find_if_not(trials.begin(), trials.end(), fixed);
  if (best_free == trials.end()) return false;
  return best_given == trials.end() ||
         differ({given, std::sqrt(best_given->misfit)}, {best_free->reconstruction.lens, std::sqrt(best_free->misfit)});
}

std::string sentence_of(const LensDoubt& doubt) {
  return fmt::format(
      "the given lens sees {:.1f} degrees across, but the pictures fit one of {:.1f} degrees better: {:.2f} px left "
      "unexplained instead of {:.2f} px; leave it out to have it estimated",
      doubt.given_fov_deg, doubt.seen_fov_deg, doubt.seen_error_px, doubt.given_error_px);
}

}  // namespace uwv::sfm
