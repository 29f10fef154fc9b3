// SPDX-License-Identifier: Apache-2.0
#include "uwv/pipeline/environment.h"

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libswscale/swscale.h>
}
#include <fmt/format.h>

#include <Eigen/Core>
#include <opencv2/core/version.hpp>

#include <fstream>

#include "uwv/core/thread_pool.h"

namespace uwv {
namespace {

std::string dotted(unsigned libav_version) {
  return fmt::format("{}.{}.{}", libav_version >> 16U, (libav_version >> 8U) & 255U, libav_version & 255U);
}

/// The rest of the first line that starts with `key`, behind its colon.
std::string line_of(const char* path, std::string_view key) {
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    if (!line.starts_with(key)) continue;
    const auto value = line.find_first_not_of(" \t", line.find(':') + 1);
    return value == std::string::npos ? "" : line.substr(value);
  }
  return "";
}

}  // namespace

std::string version() { return UWV_VERSION; }

std::vector<std::pair<std::string, std::string>> component_versions() {
  return {{"uwv", version()},
          {"compiler", __VERSION__},
          {"opencv", CV_VERSION},
          {"eigen", fmt::format("{}.{}.{}", EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION)},
          {"libavcodec", dotted(avcodec_version())},
          {"libavformat", dotted(avformat_version())},
          {"libswscale", dotted(swscale_version())}};
}

Machine this_machine() {
  const std::string memory = line_of("/proc/meminfo", "MemTotal");
  return {.processor = line_of("/proc/cpuinfo", "model name"),
          .threads = ThreadPool(0).size(),
          .memory_gib = memory.empty() ? 0 : std::stod(memory) / (1024.0 * 1024.0)};
}

std::vector<Capability> encoders() {
  const bool h264 = avcodec_find_encoder_by_name("libx264") != nullptr;
  return {{.name = "H.264 encoder (libx264)", .usable = h264, .effect = "no video can be written without it"}};
}

}  // namespace uwv
