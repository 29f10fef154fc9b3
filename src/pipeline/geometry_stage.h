// SPDX-License-Identifier: Apache-2.0
// The stage before all others: OUT/geometry, for clips that come without depth.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "pipeline/output_folder.h"
#include "uwv/core/monitor.h"
#include "uwv/core/thread_pool.h"
#include "uwv/pipeline/run.h"

namespace uwv::pipeline {

inline constexpr const char* geometry_folder_name = "geometry";

/// Everything that decides the bytes of the estimated geometry. `inputs`: the identity of each file it reads, by
/// option.
std::string geometry_key(const RunOptions& options, const nlohmann::ordered_json& inputs);

/// Reads the clip, estimates its geometry and writes the folder `geometry` into `into`. Answers with what run.json says
/// of it.
nlohmann::ordered_json make_geometry(const RunOptions& options, const RunComponents& components, ThreadPool& pool,
                                     Monitor& monitor, const PartialFolder& into);

}  // namespace uwv::pipeline
