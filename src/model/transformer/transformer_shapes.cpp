// SPDX-License-Identifier: Apache-2.0
#include "model/transformer/transformer_shapes.h"

namespace uwv::model {
namespace {

class Shapes {
 public:
  explicit Shapes(const TransformerConfig& config) : config_(config), d_(config.dim()) {}

  void add(const std::string& name, std::vector<std::int64_t> shape) { shapes_.emplace(name, std::move(shape)); }

  void add_linear(const std::string& name, std::int64_t out, std::int64_t in) {
    add(name + ".weight", {out, in});
    add(name + ".bias", {out});
  }

  void add_norm(const std::string& name) {
    add(name + ".weight", {d_});
    add(name + ".bias", {d_});
  }

  void add_patches(const std::string& name, std::int64_t channels) {
    add(name + ".weight", {d_, channels, config_.patch[0], config_.patch[1], config_.patch[2]});
    add(name + ".bias", {d_});
  }

  void add_attention(const std::string& name) {
    for (const char* part : {".to_q", ".to_k", ".to_v", ".to_out.0"}) add_linear(name + part, d_, d_);
    add(name + ".norm_q.weight", {d_});
    add(name + ".norm_k.weight", {d_});
  }

  void add_block(const std::string& name) {
    add(name + ".scale_shift_table", {1, 6, d_});
    if (config_.cross_attn_norm) add_norm(name + ".norm2");
    add_attention(name + ".attn1");
    add_attention(name + ".attn2");
    add_linear(name + ".ffn.net.0.proj", config_.ffn_dim, d_);
    add_linear(name + ".ffn.net.2", d_, config_.ffn_dim);
  }

  std::map<std::string, std::vector<std::int64_t>> take() { return std::move(shapes_); }

 private:
  const TransformerConfig& config_;
  std::int64_t d_;
  std::map<std::string, std::vector<std::int64_t>> shapes_;
};

}  // namespace

std::map<std::string, std::vector<std::int64_t>> transformer_shapes(const TransformerConfig& config) {
  const std::int64_t d = config.dim(), out = std::int64_t{config.out_channels} * config.patch_values();
  Shapes shapes(config);
  shapes.add_patches("patch_embedding", config.in_channels);
  shapes.add_linear("condition_embedder.time_embedder.linear_1", d, config.freq_dim);
  shapes.add_linear("condition_embedder.time_embedder.linear_2", d, d);
  shapes.add_linear("condition_embedder.time_proj", 6 * d, d);
  shapes.add_linear("condition_embedder.text_embedder.linear_1", d, config.text_dim);
  shapes.add_linear("condition_embedder.text_embedder.linear_2", d, d);
  for (int i = 0; i < config.layers; ++i) shapes.add_block("blocks." + std::to_string(i));
  shapes.add_linear("proj_out", out, d);
  shapes.add("scale_shift_table", {1, 2, d});
  if (!config.vace_layers.empty()) shapes.add_patches("vace_patch_embedding", config.vace_in_channels);
  for (std::size_t k = 0; k < config.vace_layers.size(); ++k) {
    const std::string name = "vace_blocks." + std::to_string(k);
    shapes.add_block(name);
    if (k == 0) shapes.add_linear(name + ".proj_in", d, d);
    shapes.add_linear(name + ".proj_out", d, d);
  }
  if (config.reference == ReferenceBranch::none) return shapes.take();
  shapes.add_patches("ref_patch_embedding", config.ref_in_channels);
  shapes.add("uniview_ref_gates", {static_cast<std::int64_t>(config.ref_at.size())});
  for (std::size_t j = 0; j < config.ref_at.size(); ++j) {
    const std::string name = "uniview_ref_attn." + std::to_string(j);
    shapes.add_norm(name + ".norm_kv");
    shapes.add_norm(name + ".norm_q");
    shapes.add_attention(name + ".attn");
  }
  return shapes.take();
}

}  // namespace uwv::model
