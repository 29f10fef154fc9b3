// SPDX-License-Identifier: Apache-2.0
// Whether the lens a caller gave can be the one the clip was filmed with.
#pragma once

#include <optional>

#include "geometry/sfm/hypotheses.h"
#include "uwv/geometry/structure_from_motion.h"

namespace uwv::sfm {

/// What a lens leaves unexplained, in pixels of the tracked picture.
struct LensFit {
  Intrinsics lens;
  double error_px = 0;
};

/// Doubt needs both: another focal length, and one that explains clearly more; a clip that says little about its lens
/// raises none.
std::optional<LensDoubt> doubt_of(const LensFit& given, const LensFit& seen, Size size);

/// Whether trials, best first, are worth such a comparison: those that began with guess 0 (as given) against those
/// whose lens was free.
bool lens_is_suspect(const std::vector<Trial>& trials, const Intrinsics& given);

/// For people.
std::string sentence_of(const LensDoubt& doubt);

}  // namespace uwv::sfm
