// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <regex>

#include "io/disk_file.h"
#include "io/json_fields.h"
#include "io/json_text.h"
#include "model/text/umt5_encoder.h"
#include "uwv/core/error.h"

namespace uwv::model {
namespace {

constexpr std::uint64_t max_config_bytes = 1'000'000;
/// Far beyond any text encoder; small enough that no product of two sizes overflows.
constexpr int max_size = 10'000'000, max_layers = 1000, max_heads = 10'000;

std::string block(std::int64_t layer) { return "encoder.block." + std::to_string(layer) + ".layer."; }

/// A member that must have one of two values when it is there.
void check_kind(const io::JsonPlace& root, const char* key, std::string_view wanted, std::string_view also) {
  if (!root.has(key)) return;
  const std::string& found = root.at(key).string();
  if (found != wanted && found != also)
    fail(ErrorCode::value_invalid, "{}: '{}' is '{}'; only '{}' is known", root.path, key, found, wanted);
}

}  // namespace

Umt5Config Umt5Config::read(const std::string& path) {
  const nlohmann::json json = io::parse_json(io::read_text(path, max_config_bytes), path);
  const io::JsonPlace root{json, path, ""};
  root.require_object();
  check_kind(root, "model_type", "umt5", "umt5");
  check_kind(root, "feed_forward_proj", "gated-gelu", "gated-gelu");
  check_kind(root, "dense_act_fn", "gelu_new", "gelu_pytorch_tanh");
  Umt5Config config;
  config.d_model = root.at("d_model").positive(max_size);
  config.d_kv = root.at("d_kv").positive(max_size);
  config.d_ff = root.at("d_ff").positive(max_size);
  config.heads = root.at("num_heads").positive(max_heads);
  config.layers = root.at("num_layers").positive(max_layers);
  config.vocabulary = root.at("vocab_size").positive(max_size);
  config.buckets = root.at("relative_attention_num_buckets").positive(max_size);
  config.max_distance = root.at("relative_attention_max_distance").positive(max_size);
  config.norm_epsilon = root.at("layer_norm_epsilon").number();
  if (config.buckets < 4 || config.buckets % 4 != 0 || config.max_distance <= config.buckets / 4)
    fail(ErrorCode::value_invalid, "{}: {} buckets for distances up to {} are none of T5's", path, config.buckets,
         config.max_distance);
  return config;
}

Umt5Config Umt5Config::of(const WeightFiles& weights) {
  const auto size = [&](const std::string& name, std::size_t axis) {
    const auto shape = weights.shape(name);
    if (axis >= shape.size() || shape[axis] < 1 || shape[axis] > max_size)
      fail(ErrorCode::value_invalid, "{}: tensor '{}' has no usable size {}", weights.path(), name, axis);
    return shape[axis];
  };
  Umt5Config config;
  const std::string attention = block(0) + "0.SelfAttention.";
  config.vocabulary = size("shared.weight", 0);
  config.d_model = size("shared.weight", 1);
  config.d_ff = size(block(0) + "1.DenseReluDense.wi_0.weight", 0);
  config.buckets = size(attention + "relative_attention_bias.weight", 0);
  config.heads = size(attention + "relative_attention_bias.weight", 1);
  config.d_kv = size(attention + "q.weight", 0) / config.heads;
  config.layers = 0;
  while (config.layers < max_layers && weights.has(block(config.layers) + "0.SelfAttention.q.weight")) ++config.layers;
  return config;
}

TensorShapes Umt5Config::shapes() const {
  TensorShapes shapes{{"shared.weight", {vocabulary, d_model}}, {"encoder.final_layer_norm.weight", {d_model}}};
  const std::int64_t inner = heads * d_kv;
  for (std::int64_t i = 0; i < layers; ++i) {
    const std::string attention = block(i) + "0.SelfAttention.", dense = block(i) + "1.DenseReluDense.";
    for (const char* name : {"q", "k", "v"}) shapes[attention + name + ".weight"] = {inner, d_model};
    shapes[attention + "o.weight"] = {d_model, inner};
    shapes[attention + "relative_attention_bias.weight"] = {buckets, heads};
    for (const char* name : {"wi_0", "wi_1"}) shapes[dense + name + ".weight"] = {d_ff, d_model};
    shapes[dense + "wo.weight"] = {d_model, d_ff};
    for (const char* name : {"0.layer_norm.weight", "1.layer_norm.weight"}) shapes[block(i) + name] = {d_model};
  }
  return shapes;
}

std::string umt5_name(const std::string& name) {
  if (name == "encoder.embed_tokens.weight" || name == "token_embedding.weight") return "shared.weight";
  if (name == "norm.weight") return "encoder.final_layer_norm.weight";
  static const std::regex in_block(R"(blocks\.(\d+)\.(.+)\.weight)");
  std::smatch match;
  if (!std::regex_match(name, match, in_block)) return name;
  constexpr std::array<std::array<const char*, 2>, 10> parts{
      {{"norm1", "0.layer_norm"},
       {"attn.q", "0.SelfAttention.q"},
       {"attn.k", "0.SelfAttention.k"},
       {"attn.v", "0.SelfAttention.v"},
       {"attn.o", "0.SelfAttention.o"},
       {"pos_embedding.embedding", "0.SelfAttention.relative_attention_bias"},
       {"norm2", "1.layer_norm"},
       {"ffn.gate.0", "1.DenseReluDense.wi_0"},
       {"ffn.fc1", "1.DenseReluDense.wi_1"},
       {"ffn.fc2", "1.DenseReluDense.wo"}}};
  for (const auto& [theirs, ours] : parts)
    if (match[2] == theirs) return "encoder.block." + match[1].str() + ".layer." + ours + ".weight";
  return name;
}

}  // namespace uwv::model
