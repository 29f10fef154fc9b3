// SPDX-License-Identifier: Apache-2.0
#include "uwv/core/processor.h"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

namespace uwv {
namespace {

/// Linux' own opinion, which also knows what the system switched off.
std::string flags_of_linux() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);)
    if (line.starts_with("flags")) return line + " ";
  return "";
}

TEST(ProcessorUnits, AgreeWithTheSystem) {
  const std::string flags = flags_of_linux();
  if (flags.empty()) GTEST_SKIP() << "/proc/cpuinfo lists no flags here";
  const auto has = [&](const std::string& name) { return flags.find(" " + name + " ") != std::string::npos; };
  const ProcessorUnits units = processor_units();
  // The system may hide what the processor has, never the other way round.
  for (const auto& [name, found] : {std::pair{"avx2", units.avx2},
                                    {"avx512f", units.avx512},
                                    {"avx512_bf16", units.avx512_bf16},
                                    {"amx_bf16", units.amx_bf16},
                                    {"avx512_vnni", units.vnni},
                                    {"amx_int8", units.amx_int8}})
    EXPECT_TRUE(found || !has(name)) << name;
  EXPECT_FALSE(units.names().empty());
}

}  // namespace
}  // namespace uwv
