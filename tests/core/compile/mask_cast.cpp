// SPDX-License-Identifier: Apache-2.0
// Must not compile: an explicit construction would keep the bytes and thereby turn their meaning around.
#include "uwv/core/mask.h"

std::size_t holes(const uwv::GenerateMask& generate) { return generate.count(); }
std::size_t use(const uwv::ValidityMask& known) { return holes(uwv::GenerateMask(known)); }
