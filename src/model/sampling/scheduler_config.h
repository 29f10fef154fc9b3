// SPDX-License-Identifier: Apache-2.0
// The sampler a checkpoint was published with: scheduler/scheduler_config.json of its folder.
#pragma once

#include <string>

#include "uwv/model/sampler_options.h"

namespace uwv::model {

/// Kind and shift; `steps` stays the default, as the file does not say. Throws Error: file_not_found; file_damaged;
/// value_invalid naming the key for another scheduler, or a setting of it that we do not have.
SamplerOptions read_scheduler_config(const std::string& path);

}  // namespace uwv::model
