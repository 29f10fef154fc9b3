// SPDX-License-Identifier: Apache-2.0
// What a step of the transformer will cost, before any weight is read.
#pragma once

#include <cstdint>

#include "model/layers/linear_form.h"
#include "model/transformer/transformer_config.h"

namespace uwv::model {

/// What uwv_app holds before a network is opened: a small clip it has rendered, libtorch and other libraries. Programs
/// that do less hold half of it.
inline constexpr double program_bytes = 0.36e9;

/// What is run: sizes of the clip, and how weights are held; fields as in TransformerOptions.
struct TransformerLoad {
  std::int64_t tokens = 0;  ///< frames x rows x columns of patches.
  std::int64_t text_tokens = 512;
  std::int64_t reference_tokens = 0;
  std::int64_t batch = 1;
  LinearForm form = LinearForm::f32;
  int stored_bytes = 2;  ///< Of a number in the checkpoint: 4 float32, 2 bfloat16, 1 float8.
  bool streamed = false, keep_keys = true;
  std::int64_t ffn_rows = 8192;

  void check() const;
};

/// Additions and multiplications of one step, a multiply-add as two; without the keys that only the first step works
/// out.
double estimated_flops(const TransformerConfig& config, const TransformerLoad& load);

/// Those of them that attention makes: products of queries with keys, and of values with what comes out.
double estimated_attention_flops(const TransformerConfig& config, const TransformerLoad& load);

/// Bytes of the weights while a step runs: all of them, or, streamed, the largest block and what lies outside the
/// blocks.
double estimated_weight_bytes(const TransformerConfig& config, const TransformerLoad& load);

/// The most memory the program holds while the network is opened and during a step, libtorch's own included.
double estimated_peak_bytes(const TransformerConfig& config, const TransformerLoad& load);

/// Of these, what stays from step to step: the libraries, weights, keys and what else depends on the clip alone.
double estimated_resting_bytes(const TransformerConfig& config, const TransformerLoad& load);

/// Bytes read from the file in a step: none once all weights are held, all of the blocks when streamed.
double estimated_read_bytes(const TransformerConfig& config, const TransformerLoad& load);

}  // namespace uwv::model
