// SPDX-License-Identifier: Apache-2.0
// Names and shapes of the published networks around the transformer. Sheet model.md, 6 and 7.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace uwv::bench {

using Shapes = std::map<std::string, std::vector<std::int64_t>>;

Shapes vae_shapes();
Shapes text_encoder_shapes();

/// Their config.json.
std::string vae_config();
std::string text_encoder_config();

}  // namespace uwv::bench
