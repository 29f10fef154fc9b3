// SPDX-License-Identifier: Apache-2.0
#include "model/transformer/transformer_config.h"

#include <algorithm>

#include "io/disk_file.h"
#include "io/json_text.h"
#include "uwv/core/error.h"

namespace uwv::model {
namespace {

constexpr std::uint64_t max_config_bytes = 1'000'000;
constexpr int max_size = 1'000'000;

/// config.json, key by key, with complaints that name the key.
class Fields {
 public:
  explicit Fields(std::string path) : path_(std::move(path)) {
    json_ = io::parse_json(io::read_text(path_, max_config_bytes), path_);
    if (!json_.is_object()) fail(ErrorCode::file_damaged, "{}: is not a JSON object", path_);
  }

  /// False also for null, which diffusers writes where something is left at its default.
  bool has(const char* key) const { return json_.contains(key) && !json_.at(key).is_null(); }

  int size(const char* key, int otherwise) const { return has(key) ? size_of(json_.at(key), key) : otherwise; }

  std::vector<int> sizes(const char* key, std::vector<int> otherwise, int least) const {
    if (!has(key)) return otherwise;
    if (!json_.at(key).is_array()) complain(key, "a list of whole numbers");
    std::vector<int> values;
    for (const auto& value : json_.at(key)) values.push_back(size_of(value, key, least));
    return values;
  }

  double number(const char* key, double otherwise) const {
    if (!has(key)) return otherwise;
    if (!json_.at(key).is_number()) complain(key, "a number");
    return json_.at(key).get<double>();
  }

  bool flag(const char* key, bool otherwise) const {
    if (!has(key)) return otherwise;
    if (!json_.at(key).is_boolean()) complain(key, "true or false");
    return json_.at(key).get<bool>();
  }

  std::string text(const char* key, const std::string& otherwise) const {
    if (!has(key)) return otherwise;
    if (!json_.at(key).is_string()) complain(key, "a text");
    return json_.at(key).get<std::string>();
  }

  [[noreturn]] void complain(const char* key, const std::string& wanted) const {
    fail(ErrorCode::value_invalid, "{}: '{}' is {}, wanted {}", path_, key,
         json_.contains(key) ? json_.at(key).dump() : "missing", wanted);
  }

 private:
  int size_of(const nlohmann::json& value, const char* key, int least = 1) const {
    if (!value.is_number_integer() || value < least || value > max_size)
      complain(key, fmt::format("a whole number from {} to {}", least, max_size));
    return value.get<int>();
  }

  std::string path_;
  nlohmann::json json_;
};

/// Which VACE blocks' hints are refined: those that exist, at most so many.
std::vector<int> hints_refined(const Fields& fields, int vace_blocks) {
  std::vector<int> at = fields.sizes("uniview_ref_inject_vace_block_indices", {0, 2, 4, 6}, 0);
  std::erase_if(at, [&](int block) { return block >= vace_blocks; });
  const auto most = static_cast<std::size_t>(fields.size("uniview_ref_num_inject", 4));
  if (at.size() > most) at.resize(most);
  return at;
}

void read_reference(const Fields& fields, TransformerConfig& config) {
  const bool uniview = fields.has("uniview_ref_in_channels") || fields.has("uniview_ref_num_inject") ||
                       fields.has("uniview_ref_inject_vace_block_indices") || fields.has("uniview_ref_gate_init");
  const std::string branch = fields.text("uniview_ref_branch", uniview ? "hint" : "none");
  if (branch == "none") return;
  if (branch != "hint" && branch != "dit") fields.complain("uniview_ref_branch", "\"hint\", \"dit\" or \"none\"");
  config.reference = branch == "hint" ? ReferenceBranch::hint : ReferenceBranch::dit;
  config.ref_in_channels = fields.size("uniview_ref_in_channels", 16);
  config.ref_at = hints_refined(fields, static_cast<int>(config.vace_layers.size()));
  if (config.reference == ReferenceBranch::hint) return;
  for (int& at : config.ref_at) at = config.vace_layers[static_cast<std::size_t>(at)];
  config.ref_at = fields.sizes("uniview_ref_dit_layers", config.ref_at, 0);
}

int index_in(const std::vector<int>& values, int wanted) {
  const auto found = std::find(values.begin(), values.end(), wanted);
  return found == values.end() ? -1 : static_cast<int>(found - values.begin());
}

bool rises(const std::vector<int>& values) {
  return std::adjacent_find(values.begin(), values.end(), std::greater_equal<>()) == values.end();
}

}  // namespace

int TransformerConfig::vace_block_of(int layer) const { return index_in(vace_layers, layer); }

int TransformerConfig::reference_of(int at) const { return index_in(ref_at, at); }

std::int64_t TransformerConfig::parameters() const {
  const std::int64_t d = dim(), f = ffn_dim;
  const std::int64_t attention = 4 * (d * d + d) + 2 * d;
  const std::int64_t block = 2 * attention + 2 * d * f + f + d + 6 * d + (cross_attn_norm ? 2 * d : 0);
  const auto patch_weights = [&](std::int64_t channels) { return d * channels * patch_values() + d; };
  const std::int64_t out = std::int64_t{out_channels} * patch_values();
  const std::int64_t time = freq_dim * d + d + d * d + d + 6 * (d * d + d);
  const std::int64_t text = text_dim * d + d + d * d + d;
  std::int64_t sum = patch_weights(in_channels) + time + text + layers * block + d * out + out + 2 * d;
  const auto vace_blocks = static_cast<std::int64_t>(vace_layers.size());
  if (vace_blocks > 0) sum += patch_weights(vace_in_channels) + vace_blocks * (block + d * d + d) + d * d + d;
  if (reference != ReferenceBranch::none)
    sum += patch_weights(ref_in_channels) + static_cast<std::int64_t>(ref_at.size()) * (attention + 4 * d + 1);
  return sum;
}

void TransformerConfig::check() const {
  require(head_dim % 2 == 0 && head_dim >= 6, "attention_head_dim is {}, wanted an even number of at least 6",
          head_dim);
  require(freq_dim % 2 == 0, "freq_dim is {}, wanted an even number", freq_dim);
  require(eps >= 0 && eps < 1, "eps is {}, wanted a number from 0 to 1", eps);
  require(patch[0] == 1, "patch_size takes {} frames, wanted 1", patch[0]);
  require(vace_layers.empty() || (vace_layers.front() == 0 && rises(vace_layers) && vace_layers.back() < layers),
          "vace_layers are {}, wanted rising numbers from 0 to below num_layers {}", vace_layers.size(), layers);
  const int places = reference == ReferenceBranch::dit ? layers : static_cast<int>(vace_layers.size());
  require(reference == ReferenceBranch::none || (rises(ref_at) && (ref_at.empty() || ref_at.back() < places)),
          "{} reference attentions do not rise below {}", ref_at.size(), places);
}

TransformerConfig TransformerConfig::read(const std::string& folder) {
  const std::string path = folder + "/config.json";
  const Fields fields(path);
  TransformerConfig config;
  config.heads = fields.size("num_attention_heads", config.heads);
  config.head_dim = fields.size("attention_head_dim", config.head_dim);
  config.ffn_dim = fields.size("ffn_dim", config.ffn_dim);
  config.layers = fields.size("num_layers", config.layers);
  config.in_channels = fields.size("in_channels", config.in_channels);
  config.out_channels = fields.size("out_channels", config.in_channels);
  config.text_dim = fields.size("text_dim", config.text_dim);
  config.freq_dim = fields.size("freq_dim", config.freq_dim);
  config.eps = fields.number("eps", config.eps);
  config.cross_attn_norm = fields.flag("cross_attn_norm", true);
  const std::vector<int> patch = fields.sizes("patch_size", {1, 2, 2}, 1);
  if (patch.size() != 3) fields.complain("patch_size", "three numbers");
  std::copy(patch.begin(), patch.end(), config.patch.begin());
  for (const char* key : {"image_dim", "added_kv_proj_dim", "pos_embed_seq_len"})
    if (fields.has(key)) fields.complain(key, "null: models that take a picture's embedding are not supported");
  if (const std::string norm = fields.text("qk_norm", "rms_norm_across_heads"); norm != "rms_norm_across_heads")
    fields.complain("qk_norm", "\"rms_norm_across_heads\"");
  config.vace_layers = fields.sizes("vace_layers", {}, 0);
  config.vace_in_channels = fields.size("vace_in_channels", config.vace_in_channels);
  read_reference(fields, config);
  try {
    config.check();
  } catch (const std::invalid_argument& error) {
    fail(ErrorCode::value_invalid, "{}: {}", path, error.what());
  }
  return config;
}

TransformerConfig TransformerConfig::wan_1_3b() {
  TransformerConfig config;
  config.heads = 12;
  config.ffn_dim = 8960;
  config.layers = 30;
  for (int layer = 0; layer < config.layers; layer += 2) config.vace_layers.push_back(layer);
  return config;
}

TransformerConfig TransformerConfig::wan_14b() {
  TransformerConfig config;
  for (int layer = 0; layer < config.layers; layer += 5) config.vace_layers.push_back(layer);
  config.reference = ReferenceBranch::hint;
  config.ref_at = {0, 2, 4, 6};
  return config;
}

}  // namespace uwv::model
