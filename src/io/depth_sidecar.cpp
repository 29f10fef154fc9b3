// SPDX-License-Identifier: Apache-2.0
#include "io/depth_sidecar.h"

#include <cmath>
#include <filesystem>

#include "io/disk_file.h"
#include "io/json_text.h"
#include "uwv/core/error.h"

namespace uwv::io {

std::optional<double> read_depth_sidecar(const std::string& folder) {
  const std::string path = (std::filesystem::path(folder) / depth_sidecar_name).string();
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) return std::nullopt;
  constexpr std::uint64_t max_bytes = 1 << 20;
  const nlohmann::json json = parse_json(read_text(path, max_bytes), path);
  const auto scale = json.is_object() && json.contains("uwv_depth") ? json.find("scale") : json.end();
  if (scale == json.end() || !scale->is_number() || !(scale->get<double>() > 0) || !std::isfinite(scale->get<double>()))
    fail(ErrorCode::value_invalid,
         "{}: /scale must be a positive number (or state the depth scale and remove this file)", path);
  return scale->get<double>();
}

void write_depth_sidecar(const std::string& folder, double scale, long frames) {
  const nlohmann::ordered_json json = {
      {"uwv_depth", 1}, {"format", "png16"}, {"scale", scale}, {"invalid", 0}, {"frames", frames}};
  write_file((std::filesystem::path(folder) / depth_sidecar_name).string(), json.dump(2) + "\n");
}

}  // namespace uwv::io
