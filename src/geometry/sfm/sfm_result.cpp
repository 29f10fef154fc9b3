// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "uwv/geometry/structure_from_motion.h"

namespace uwv {

std::string_view to_string(ClipMotion motion) {
  switch (motion) {
    case ClipMotion::moving: return "moving";
    case ClipMotion::turning: return "turning";
    case ClipMotion::still: return "still";
    default: return "indeterminate";
  }
}

void SfmOptions::check() const {
  require(max_features >= 50 && max_features <= 100000, "max_features: found {}, wanted 50 to 100000", max_features);
  require(tracking_height >= 16, "tracking_height: found {}, wanted at least 16", tracking_height);
  require(min_parallax_px > 0 && std::isfinite(min_parallax_px), "min_parallax_px: found {}, wanted a positive number",
          min_parallax_px);
  require(max_error_px > 0 && std::isfinite(max_error_px), "max_error_px: found {}, wanted a positive number",
          max_error_px);
  require(!intrinsics || (std::isfinite(intrinsics->fx) && std::isfinite(intrinsics->fy) && intrinsics->fx != 0 &&
                          intrinsics->fy != 0),
          "intrinsics: found focal lengths {} and {}, wanted finite ones other than 0", intrinsics ? intrinsics->fx : 0,
          intrinsics ? intrinsics->fy : 0);
}

std::string SfmResult::brief() const {
  std::string text = fmt::format("camera {}: {}", to_string(motion), reason);
  if (motion == ClipMotion::moving) {
    const auto measured = std::count(registered.begin(), registered.end(), std::uint8_t{1});
    text += fmt::format("; {} of {} cameras from {} points, {:.2f} px off", measured, registered.size(), points.size(),
                        rms_error_px);
  }
  if (!cuts.empty()) text += fmt::format("; {} cuts", cuts.size());
  return text;
}

}  // namespace uwv
