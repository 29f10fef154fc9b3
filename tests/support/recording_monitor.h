// SPDX-License-Identifier: Apache-2.0
// A monitor that remembers the warnings it heard.
#pragma once

#include <string>
#include <vector>

#include "uwv/core/monitor.h"

namespace uwv::test {

class RecordingMonitor : public Monitor {
 public:
  void warn(const std::string& sentence) override { warnings.push_back(sentence); }
  std::vector<std::string> warnings;
};

}  // namespace uwv::test
