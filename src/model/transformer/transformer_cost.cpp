// SPDX-License-Identifier: Apache-2.0
#include "model/transformer/transformer_cost.h"

#include <algorithm>

#include "uwv/core/error.h"

namespace uwv::model {
namespace {

/// What the libraries' products take for themselves.
constexpr double scratch_bytes = 16e6;
/// Of a weight that is widened, or read to be rounded, so much at a time; twice, before and after a change.
constexpr double widened_piece = 8e6;

/// Sizes as doubles, so that products of many cannot overflow.
struct Sizes {
  Sizes(const TransformerConfig& config, const TransformerLoad& load)
      : d(config.dim()),
        f(config.ffn_dim),
        n(static_cast<double>(load.tokens)),
        text(static_cast<double>(load.text_tokens)),
        reference(config.reference == ReferenceBranch::none ? 0 : static_cast<double>(load.reference_tokens)),
        batch(static_cast<double>(load.batch)),
        vace(static_cast<double>(config.vace_layers.size())),
        blocks(config.layers + static_cast<double>(config.vace_layers.size())),
        references(reference > 0 ? static_cast<double>(config.ref_at.size()) : 0) {}
  double d, f, n, text, reference, batch, vace, blocks, references;
};

double held_bytes(const TransformerLoad& load) {
  const double stored = load.stored_bytes;
  switch (load.form) {
    case LinearForm::f32: return stored;
    case LinearForm::bf16_stored: return std::min(stored, 2.0);
    case LinearForm::bf16: return 2;
    case LinearForm::int8_stored:
    case LinearForm::int8: return 1;
  }
  return stored;
}

double block_weights(const Sizes& s) { return 8 * s.d * s.d + 2 * s.d * s.f; }

/// Of linear layers within blocks and of the reference attention behind some of them.
double weights_in_blocks(const TransformerConfig& config, const Sizes& s) {
  return s.blocks * block_weights(s) + (s.vace > 0 ? (s.vace + 1) * s.d * s.d : 0) +
         static_cast<double>(config.ref_at.size()) * 4 * s.d * s.d;
}

double weights_outside(const TransformerConfig& config, const Sizes& s) {
  return static_cast<double>(config.parameters()) - weights_in_blocks(config, s);
}

double largest_block(const TransformerConfig& config, const Sizes& s) {
  return block_weights(s) + (s.vace > 0 ? 2 : 0) * s.d * s.d + (config.ref_at.empty() ? 0 : 4) * s.d * s.d;
}

/// What is there while a block works: its weights as they were read, and its copy where rounding makes one.
double streamed_bytes(const TransformerConfig& config, const TransformerLoad& load, const Sizes& s) {
  const double copy =
      held_bytes(load) < load.stored_bytes || load.form == LinearForm::bf16 || load.form == LinearForm::int8
          ? held_bytes(load)
          : 0;
  return largest_block(config, s) * (load.stored_bytes + (copy == load.stored_bytes ? 0 : copy));
}

/// Weights that are there when the last block is rounded: it as the file holds it, too. What lies outside the blocks
/// has not been touched then, and there are no tokens.
double opening_bytes(const TransformerConfig& config, const TransformerLoad& load, const Sizes& s) {
  const bool rounded = held_bytes(load) != load.stored_bytes;
  if (load.streamed || !rounded) return 0;
  return weights_in_blocks(config, s) * held_bytes(load) + largest_block(config, s) * load.stored_bytes;
}

double widened_bytes(const TransformerLoad& load, const Sizes& s) {
  const bool never = load.form == LinearForm::bf16 || (load.form == LinearForm::f32 && load.stored_bytes == 4);
  return never ? 0 : 2 * std::min(widened_piece, 4 * s.d * s.f);
}

/// Keys and values of one block's text.
double text_keys(const TransformerLoad& load, const Sizes& s) {
  return s.batch * 2 * s.d * token_bytes(load.form) * s.text;
}

}  // namespace

void TransformerLoad::check() const {
  require(tokens > 0 && text_tokens > 0 && reference_tokens >= 0 && batch > 0,
          "{} tokens, {} of text and {} of reference in a batch of {}", tokens, text_tokens, reference_tokens, batch);
  require(stored_bytes == 1 || stored_bytes == 2 || stored_bytes == 4, "stored_bytes is {}, wanted 1, 2 or 4",
          stored_bytes);
  require(ffn_rows > 0, "ffn_rows is {}, wanted at least 1", ffn_rows);
}

double estimated_flops(const TransformerConfig& config, const TransformerLoad& load) {
  load.check();
  const Sizes s(config, load);
  const double self = 8 * s.n * s.d * s.d + 4 * s.n * s.n * s.d;
  const double text = 4 * s.n * s.d * s.d + 4 * s.n * s.text * s.d;
  const double feed_forward = 4 * s.n * s.d * s.f;
  const double hints = s.vace > 0 ? (s.vace + 1) * 2 * s.n * s.d * s.d : 0;
  const double references = s.references * (4 * s.n * s.d * s.d + 4 * s.n * s.reference * s.d);
  const double ends =
      2 * s.n * s.d * config.patch_values() * (config.in_channels + config.out_channels) + 14 * s.d * s.d;
  return s.batch * (s.blocks * (self + text + feed_forward) + hints + references + ends);
}

double estimated_attention_flops(const TransformerConfig& config, const TransformerLoad& load) {
  load.check();
  const Sizes s(config, load);
  return s.batch * 4 * s.n * s.d * (s.blocks * (s.n + s.text) + s.references * s.reference);
}

double estimated_weight_bytes(const TransformerConfig& config, const TransformerLoad& load) {
  load.check();
  const Sizes s(config, load);
  return weights_outside(config, s) * load.stored_bytes +
         (load.streamed ? streamed_bytes(config, load, s) : weights_in_blocks(config, s) * held_bytes(load));
}

double estimated_resting_bytes(const TransformerConfig& config, const TransformerLoad& load) {
  load.check();
  const Sizes s(config, load);
  const double weights = weights_outside(config, s) * load.stored_bytes +
                         (load.streamed ? 0 : weights_in_blocks(config, s) * held_bytes(load));
  const double control = s.vace > 0 ? 4 * s.batch * s.n * s.d : 0;
  const double references = s.batch * 2 * s.d * token_bytes(load.form) * s.references * s.reference;
  const double keys = load.keep_keys ? s.blocks * text_keys(load, s) + references : 0;
  const double positions = 4.0 * s.n * config.head_dim;
  const double text = s.batch * s.text * 4 * (s.d + config.text_dim) + s.batch * s.reference * 4 * s.d;
  return program_bytes + weights + control + keys + positions + text;
}

double estimated_peak_bytes(const TransformerConfig& config, const TransformerLoad& load) {
  const Sizes s(config, load);
  const double token = token_bytes(load.form);
  const double rows = s.batch * s.n, row = rows * s.d;
  // The main stream; the control stream and a hint.
  const double streams = 4 * row + (s.vace > 0 ? 8 * row : 0);
  // Normed tokens, their 8-bit twin, queries, keys, values, what attention mixes of them.
  const double attention = row * (5 * token + (load.form == LinearForm::int8 ? 1 : 0));
  const double wide = std::min(rows, static_cast<double>(load.ffn_rows)) * s.f;
  const double feed_forward = 2 * row * token + wide * (token + (load.form == LinearForm::int8 ? 1 : 0));
  const double passing = load.keep_keys ? 0 : text_keys(load, s);
  const double step = estimated_resting_bytes(config, load) + (load.streamed ? streamed_bytes(config, load, s) : 0) +
                      streams + std::max(attention, feed_forward) + passing;
  return widened_bytes(load, s) + std::max(program_bytes + opening_bytes(config, load, s), scratch_bytes + step);
}

double estimated_read_bytes(const TransformerConfig& config, const TransformerLoad& load) {
  load.check();
  return load.streamed ? weights_in_blocks(config, Sizes(config, load)) * load.stored_bytes : 0;
}

}  // namespace uwv::model
