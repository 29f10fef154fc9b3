// SPDX-License-Identifier: Apache-2.0
// How fast this machine reads what it does not hold in memory.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace uwv::model {

struct DiskSpeed {
  double bytes_a_second = 0;
  double cached = 0;  ///< Share of the files that was in memory, of what was looked at.
};

/// Of the disk the files lie on, read as streamed weights are: scattered pieces, each dropped from the system's cache
/// before it is read, for about a third of a second. Nothing where the system does not let go of them (another program
/// has them mapped, they belong to somebody else, they live in memory) or cannot be asked.
std::optional<DiskSpeed> disk_speed(const std::vector<std::string>& files);

}  // namespace uwv::model
