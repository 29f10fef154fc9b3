// SPDX-License-Identifier: Apache-2.0
// Must not compile: a validity mask is handed to a function that wants a generate mask.
#include "uwv/core/mask.h"

std::size_t holes(const uwv::GenerateMask& generate) { return generate.count(); }
std::size_t use(const uwv::ValidityMask& known) { return holes(known); }
