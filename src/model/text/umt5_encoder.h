// SPDX-License-Identifier: Apache-2.0
// The UMT5 text encoder: token ids to one vector per token. Sheet model.md, 6.
//
// It is walked through layer by layer out of the mapped file: a layer's weights are read, used and given back before
// the next, so that the encoder of 11 GB runs in the memory of one layer.
#pragma once

#include <ATen/core/Tensor.h>

#include <functional>
#include <string>
#include <vector>

#include "model/layers/linear.h"
#include "model/weights/weight_files.h"

namespace uwv::model {

/// The sizes of config.json.
struct Umt5Config {
  std::int64_t d_model = 4096;  ///< Width of a token.
  std::int64_t d_kv = 64;       ///< Width of a head; heads * d_kv need not be d_model.
  std::int64_t d_ff = 10240;
  std::int64_t heads = 64;
  std::int64_t layers = 24;
  std::int64_t vocabulary = 256384;
  std::int64_t buckets = 32;        ///< Of relative positions, both directions together.
  std::int64_t max_distance = 128;  ///< Positions farther apart share the last bucket.
  double norm_epsilon = 1e-6;

  /// Reads config.json. Throws Error: file_damaged for one that is no such file, value_invalid for another kind of
  /// network and for sizes out of range.
  static Umt5Config read(const std::string& path);
  /// The sizes that the weights themselves show, for files that come without config.json.
  static Umt5Config of(const WeightFiles& weights);
  /// Names and shapes of all weights.
  TensorShapes shapes() const;
};

/// Sequences that are encoded together. `ids` and `mask` are (B, N) of int64; mask 1 = text, 0 = padding.
struct TokenBatch {
  at::Tensor ids, mask;
};

class Umt5Encoder {
 public:
  /// Called after each layer with how many of how many are done and what the sequences are by now, (B, N, d_model)
  /// each: the embeddings at 0, and before the final norm at the last. It may throw to stop.
  using AfterLayer = std::function<void(std::int64_t done, std::int64_t total, const std::vector<at::Tensor>& hidden)>;

  /// `path` is a folder text_encoder/ or one safetensors file, with the names of Hugging Face or of Wan's own release.
  /// It is run on `device`. Throws Error as WeightFiles and Umt5Config do.
  static Umt5Encoder open(const std::string& path, LinearForm form, c10::Device device = c10::kCPU);

  const Umt5Config& config() const { return config_; }
  const WeightFiles& weights() const { return weights_; }

  /// Encodes batches of any lengths in one walk through the weights: (B, N, d_model) float32 each, padded positions
  /// included, on the device. `batches` are on the CPU. Throws Error(value_invalid) for ids outside the vocabulary, and
  /// naming the layer when its numbers are not finite.
  std::vector<at::Tensor> encode(const std::vector<TokenBatch>& batches, const AfterLayer& after_layer) const;

 private:
  struct Layer;
  at::Tensor embed(const at::Tensor& ids) const;
  Layer load_layer(std::int64_t index) const;
  void each_weight(std::int64_t layer, const std::function<void(const std::string&)>& act) const;

  Umt5Config config_;
  WeightFiles weights_;
  LinearForm form_ = LinearForm::f32;
};

/// Bucket of each relative position (key - query), int64 in and out; sheet 6.
at::Tensor relative_buckets(const at::Tensor& positions, std::int64_t buckets, std::int64_t max_distance);

/// The Hugging Face name of a weight of Wan's own release ("blocks.0.attn.q.weight"); other names as they are.
std::string umt5_name(const std::string& name);

}  // namespace uwv::model
