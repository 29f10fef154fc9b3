// SPDX-License-Identifier: Apache-2.0
// What this program was built with and runs on: for run.json, and for `uwv_app doctor`.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "uwv/render/gl_context.h"

namespace uwv {

/// The version of the library, e.g. "0.1.0".
std::string version();

/// The linker's identity of the program or library this code was linked into: another one after any change of code.
/// Hexadecimal; empty when the linker left none.
std::string build_id();

/// Names and versions of this library, its compiler and the libraries that decide bytes of the results.
std::vector<std::pair<std::string, std::string>> component_versions();

struct Machine {
  std::string processor;  ///< Model name as the system reports it; empty when it doesn't.
  int threads = 1;        ///< Processors this process may use.
  double memory_gib = 0;  ///< Physical memory; 0 = unknown.
};
Machine this_machine();

/// A component some option needs.
struct Capability {
  std::string name;  ///< For example "H.264 encoder (libx264)".
  bool usable = false;
  std::string effect;  ///< What cannot be done without it.
};
std::vector<Capability> encoders();

}  // namespace uwv
