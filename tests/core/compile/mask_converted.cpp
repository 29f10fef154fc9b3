// SPDX-License-Identifier: Apache-2.0
// Must compile: the polarity is turned around by name.
#include "uwv/core/mask.h"

std::size_t holes(const uwv::GenerateMask& generate) { return generate.count(); }
std::size_t use(const uwv::ValidityMask& known) { return holes(uwv::to_generate(known)); }
