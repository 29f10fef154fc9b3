// SPDX-License-Identifier: Apache-2.0
#include "model/text/umt5_encoder.h"

#include <ATen/ATen.h>

#include <cmath>
#include <filesystem>
#include <limits>

#include "uwv/core/error.h"

namespace uwv::model {
namespace {

namespace fs = std::filesystem;

/// T5's norm: no mean is taken away and nothing added.
at::Tensor rms_norm(const at::Tensor& x, const at::Tensor& weight, double epsilon) {
  return x * at::rsqrt(x.square().mean(-1, /*keepdim=*/true) + epsilon) * weight;
}

std::string block(std::int64_t layer) { return "encoder.block." + std::to_string(layer) + ".layer."; }

}  // namespace

at::Tensor relative_buckets(const at::Tensor& positions, std::int64_t buckets, std::int64_t max_distance) {
  // Half of the buckets for keys behind the query, half for those before it; of each half the first half holds one
  // distance each, the rest grow by a constant factor.
  const std::int64_t half = buckets / 2, exact = half / 2;
  const at::Tensor distance = positions.abs();
  const at::Tensor grown = at::log(distance.to(at::kFloat) / static_cast<double>(exact));
  // Divided and multiplied in the reference's order: a rounding apart would move a distance to the next bucket.
  const at::Tensor large = (exact + (grown / std::log(static_cast<double>(max_distance) / static_cast<double>(exact)) *
                                     static_cast<double>(half - exact))
                                        .to(at::kLong))
                               .clamp_max(half - 1);
  return at::where(distance < exact, distance, large) + (positions > 0).to(at::kLong) * half;
}

struct Umt5Encoder::Layer {
  at::Tensor attention_norm, dense_norm;  // (d_model)
  at::Tensor position_bias;               // (buckets, heads)
  Linear q, k, v, o, gate, up, down;

  /// x (B, N, d_model), bias (1, heads, N, N) or (B, heads, N, N).
  at::Tensor attend(const at::Tensor& x, const at::Tensor& bias, const Umt5Config& config) const {
    const auto heads = [&](const at::Tensor& t) {
      return t.reshape({t.size(0), t.size(1), config.heads, config.d_kv}).transpose(1, 2);
    };
    const at::Tensor y = rms_norm(x, attention_norm, config.norm_epsilon);
    const at::Tensor seen = at::scaled_dot_product_attention(heads(q(y)), heads(k(y)), heads(v(y)), bias,
                                                             /*dropout_p=*/0.0, /*is_causal=*/false, /*scale=*/1.0);
    return x + o(seen.transpose(1, 2).reshape({x.size(0), x.size(1), config.heads * config.d_kv}));
  }
  at::Tensor think(const at::Tensor& x, const Umt5Config& config) const {
    const at::Tensor y = rms_norm(x, dense_norm, config.norm_epsilon);
    return x + down(at::gelu(gate(y), "tanh") * up(y));
  }
};

namespace {

/// What a layer adds to the attention scores: its bias by relative position, and the least number where a key is
/// padding.
at::Tensor attention_bias(const at::Tensor& table, const at::Tensor& buckets, const at::Tensor& mask) {
  const at::Tensor by_position = table.index({buckets}).permute({2, 0, 1}).unsqueeze(0);
  const at::Tensor hidden_keys = (1 - mask.to(at::kFloat)) * std::numeric_limits<float>::lowest();
  return (by_position + hidden_keys.unsqueeze(1).unsqueeze(1)).contiguous();
}

/// (N, N): the bucket of each query and key.
at::Tensor bucket_table(std::int64_t length, const Umt5Config& config) {
  const at::Tensor at_place = at::arange(length, at::kLong);
  return relative_buckets(at_place.unsqueeze(0) - at_place.unsqueeze(1), config.buckets, config.max_distance);
}

}  // namespace

Umt5Encoder Umt5Encoder::open(const std::string& path, LinearForm form, c10::Device device) {
  Umt5Encoder encoder;
  encoder.form_ = form;
  encoder.weights_ = WeightFiles::open(path);
  encoder.weights_.put_on(device);
  // Files that hold the embeddings under both of their names need only one.
  const bool twice = encoder.weights_.has("shared.weight") && encoder.weights_.has("encoder.embed_tokens.weight");
  encoder.weights_.rename([&](const std::string& name) {
    return twice && name == "encoder.embed_tokens.weight" ? std::string() : umt5_name(name);
  });
  const fs::path config = fs::path(path) / "config.json";
  encoder.config_ = fs::exists(config) ? Umt5Config::read(config.string()) : Umt5Config::of(encoder.weights_);
  encoder.weights_.check(encoder.config_.shapes());
  return encoder;
}

at::Tensor Umt5Encoder::embed(const at::Tensor& ids) const {
  const at::Tensor flat = ids.reshape({-1});
  if (flat.numel() > 0 &&
      (flat.min().item<std::int64_t>() < 0 || flat.max().item<std::int64_t>() >= config_.vocabulary))
    fail(ErrorCode::value_invalid,
         "{}: the tokenizer gives the id {}, but the text encoder knows {}; are they of one "
         "model?",
         weights_.path(), flat.max().item<std::int64_t>(), config_.vocabulary);
  // Only the rows of these tokens are read of the mapped table.
  return weights_.mapped("shared.weight")
      .index_select(0, flat)
      .to(weights_.device())
      .to(at::kFloat)
      .reshape({ids.size(0), ids.size(1), config_.d_model});
}

Umt5Encoder::Layer Umt5Encoder::load_layer(std::int64_t index) const {
  const std::string attention = block(index) + "0.SelfAttention.", dense = block(index) + "1.DenseReluDense.";
  const auto linear = [&](const std::string& prefix) { return Linear(weights_, prefix, form_); };
  const auto vector = [&](const std::string& name) { return weights_.load(name, at::kFloat); };
  return {vector(block(index) + "0.layer_norm.weight"),
          vector(block(index) + "1.layer_norm.weight"),
          vector(attention + "relative_attention_bias.weight"),
          linear(attention + "q"),
          linear(attention + "k"),
          linear(attention + "v"),
          linear(attention + "o"),
          linear(dense + "wi_0"),
          linear(dense + "wi_1"),
          linear(dense + "wo")};
}

void Umt5Encoder::each_weight(std::int64_t layer, const std::function<void(const std::string&)>& act) const {
  if (layer >= config_.layers) return;
  for (const char* name : {"q", "k", "v", "o"}) act(block(layer) + "0.SelfAttention." + name + ".weight");
  for (const char* name : {"wi_0", "wi_1", "wo"}) act(block(layer) + "1.DenseReluDense." + name + ".weight");
}

std::vector<at::Tensor> Umt5Encoder::encode(const std::vector<TokenBatch>& batches,
                                            const AfterLayer& after_layer) const {
  std::vector<at::Tensor> hidden, buckets, masks;
  for (const TokenBatch& batch : batches) {
    require(batch.ids.dim() == 2 && batch.mask.sizes() == batch.ids.sizes(),
            "token ids have {} axes and a mask of {}; two of the same sizes are wanted", batch.ids.dim(),
            batch.mask.dim());
    hidden.push_back(embed(batch.ids));
    buckets.push_back(bucket_table(batch.ids.size(1), config_).to(weights_.device()));
    masks.push_back(batch.mask.to(weights_.device()));
  }
  if (after_layer) after_layer(0, config_.layers, hidden);
  for (std::int64_t i = 0; i < config_.layers; ++i) {
    // The disk works on the next layer while this one is computed.
    each_weight(i + 1, [&](const std::string& name) { weights_.will_need(name); });
    const Layer layer = load_layer(i);
    for (std::size_t b = 0; b < batches.size(); ++b) {
      const at::Tensor bias = attention_bias(layer.position_bias, buckets[b], masks[b]);
      hidden[b] = layer.think(layer.attend(hidden[b], bias, config_), config_);
      if (!hidden[b].isfinite().all().item<bool>())
        fail(ErrorCode::value_invalid,
             "{}: layer {} of the text encoder gives numbers that are not finite; the weights "
             "are damaged, or hold a type too narrow for them",
             weights_.path(), i);
    }
    each_weight(i, [&](const std::string& name) { weights_.release(name); });
    if (after_layer) after_layer(i + 1, config_.layers, hidden);
  }
  const at::Tensor norm = weights_.load("encoder.final_layer_norm.weight", at::kFloat);
  for (at::Tensor& h : hidden) h = rms_norm(h, norm, config_.norm_epsilon);
  return hidden;
}

}  // namespace uwv::model
