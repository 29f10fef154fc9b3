// SPDX-License-Identifier: Apache-2.0
// What the program freed but its allocator keeps.
#pragma once

namespace uwv::model {

/// Gives freed pages back to the system, where the C library can. Between many large pieces of work whose results stay,
/// the gaps would add up.
void give_back_freed_memory();

}  // namespace uwv::model
