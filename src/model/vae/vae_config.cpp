// SPDX-License-Identifier: Apache-2.0
#include "model/vae/vae_config.h"

#include <algorithm>

#include "io/disk_file.h"
#include "io/json_text.h"
#include "trajectory/json_node.h"

namespace uwv::model {
namespace {

using detail::JsonNode;

constexpr std::uint64_t max_config_bytes = 1'000'000;
constexpr long widest = 4096;
constexpr std::size_t most_levels = 6;

std::vector<std::int64_t> integers(const JsonNode& node, std::size_t least, std::size_t most, long largest) {
  std::vector<std::int64_t> values;
  for (const JsonNode& element : node.elements(least, most, "an array of numbers"))
    values.push_back(element.integer(1, largest));
  return values;
}

std::vector<float> per_channel(const JsonNode& node, std::int64_t channels, detail::Range range) {
  std::vector<float> values;
  const auto count = static_cast<std::size_t>(channels);
  for (const double value : node.numbers(count, count, range)) values.push_back(static_cast<float>(value));
  return values;
}

/// Keys that turn it into another network, with the value that leaves it as it is.
void refuse_variants(const JsonNode& node) {
  if (node.has("is_residual") && node["is_residual"].boolean())
    node["is_residual"].complain("is true: a residual autoencoder (Wan 2.2), which is not supported; Wan 2.1's is");
  if (node.has("patch_size") && !node["patch_size"].value().is_null())
    node["patch_size"].complain("is set: an autoencoder of patches (Wan 2.2), which is not supported; Wan 2.1's is");
  if (node.has("attn_scales") && !node["attn_scales"].elements(0, most_levels, "an array").empty())
    node["attn_scales"].complain("is not empty: attention is supported in the middle only");
  for (const char* key : {"in_channels", "out_channels"})
    if (node.has(key) && node[key].integer(1, widest) != 3) node[key].complain("is not 3: colour pictures are wanted");
}

}  // namespace

VaeConfig VaeConfig::read(const std::string& path) {
  const nlohmann::json json = io::parse_json(io::read_text(path, max_config_bytes), path);
  const JsonNode node(json, "", path);
  if (!json.is_object()) node.refuse("an object");
  refuse_variants(node);
  VaeConfig config;
  config.base_dim = node["base_dim"].integer(1, widest);
  const bool own_width = node.has("decoder_base_dim") && !node["decoder_base_dim"].value().is_null();
  config.decoder_base_dim = own_width ? node["decoder_base_dim"].integer(1, widest) : config.base_dim;
  config.dim_mult = integers(node["dim_mult"], 2, most_levels, 64);
  config.num_res_blocks = node["num_res_blocks"].integer(1, 16);
  config.temperal_downsample.clear();
  for (const JsonNode& element : node["temperal_downsample"].elements(config.levels() - 1, config.levels() - 1,
                                                                      "one truth value per level but the last"))
    config.temperal_downsample.push_back(element.boolean());
  config.z_dim = node["z_dim"].integer(1, widest);
  config.latents_mean = per_channel(node["latents_mean"], config.z_dim, {-1e6, 1e6});
  config.latents_std = per_channel(node["latents_std"], config.z_dim, {0, 1e6, true});
  // Each upsampler halves the channels.
  for (const std::int64_t mult : config.dim_mult)
    if (config.decoder_base_dim * mult % 2 != 0 && mult != config.dim_mult.front())
      node["base_dim"].complain("makes an odd number of channels, which an upsampler cannot halve");
  return config;
}

std::int64_t VaeConfig::temporal_factor() const {
  return std::int64_t{1} << std::count(temperal_downsample.begin(), temperal_downsample.end(), true);
}

}  // namespace uwv::model
