// SPDX-License-Identifier: Apache-2.0
// What this machine offers the programs, and why some of it is missing.
#pragma once

#include <string>

namespace uwv::app {

/// Several lines for people.
std::string doctor_report();

}  // namespace uwv::app
