// SPDX-License-Identifier: Apache-2.0
// From latents, time and text to tokens. Sheet model.md, 3.2 and 3.3. All of it in float32 whatever form the blocks
// have: these layers are few and the whole answer hangs on them.
#pragma once

#include "model/layers/linear.h"
#include "model/lora/fused_weights.h"
#include "model/transformer/transformer_config.h"

namespace uwv::model {

/// Cuts latents into patches, one token each.
class PatchEmbedder {
 public:
  /// Weights are prefix + ".weight" (dim, channels, patch) and ".bias".
  PatchEmbedder(const FusedWeights& weights, const std::string& prefix);

  /// (batch, channels, frames, rows, columns) to (batch, tokens, dim). Throws std::invalid_argument unless the channels
  /// fit and rows and columns are whole patches.
  at::Tensor operator()(const at::Tensor& latents) const;
  TokenGrid grid(const at::Tensor& latents) const;

 private:
  std::string name_;
  std::vector<std::int64_t> patch_;  ///< Frames, rows, columns.
  std::int64_t channels_;
  Linear linear_;
};

/// The embedding of a timestep.
struct TimeEmbedding {
  at::Tensor sinusoid;  ///< (batch, freq_dim)
  at::Tensor embedded;  ///< (batch, dim); modulates the last norm.
  at::Tensor parts;     ///< (batch, 6, dim); modulates every block.
};

class TimeEmbedder {
 public:
  TimeEmbedder(const FusedWeights& weights, int freq_dim);
  /// `timestep` is (batch), 0 to 1000, of any type of number.
  TimeEmbedding operator()(const at::Tensor& timestep) const;

 private:
  int freq_dim_;
  Linear first_, second_, parts_;
};

class TextEmbedder {
 public:
  explicit TextEmbedder(const FusedWeights& weights);
  /// (batch, tokens, text_dim) to (batch, tokens, dim).
  at::Tensor operator()(const at::Tensor& text) const;

 private:
  Linear first_, second_;
};

}  // namespace uwv::model
