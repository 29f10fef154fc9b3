// SPDX-License-Identifier: Apache-2.0
// The sizes of a Wan transformer, as config.json beside its weights states them. Sheet model.md, 1.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace uwv::model {

/// Where reference tokens are attended to.
enum class ReferenceBranch {
  none,  ///< No reference attention at all: plain VACE, plain Wan, or a stage-1 checkpoint.
  hint,  ///< As the official code does: from the VACE hints, before they enter the main stream.
  dit,   ///< As the paper tells: from the view tokens themselves, between the layers of the main stream.
};

struct TransformerConfig {
  int heads = 40, head_dim = 128;
  int ffn_dim = 13824;
  int layers = 40;
  int in_channels = 16, out_channels = 16;
  int text_dim = 4096, freq_dim = 256;
  std::array<int, 3> patch{1, 2, 2};  ///< Frames, rows, columns of latents that make a token.
  bool cross_attn_norm = true;        ///< Whether the text attention has a norm with weights of its own before it.
  double eps = 1e-6;

  std::vector<int> vace_layers;  ///< Main layer that the hint of VACE block k is added after; empty = no VACE at all.
  int vace_in_channels = 96;

  ReferenceBranch reference = ReferenceBranch::none;
  int ref_in_channels = 16;
  /// Where reference attention j acts: after VACE block ref_at[j] (hint), or after main layer ref_at[j] (dit).
  std::vector<int> ref_at;

  int dim() const { return heads * head_dim; }
  int patch_values() const { return patch[0] * patch[1] * patch[2]; }
  /// VACE block that ends before main layer `layer` is left, or -1.
  int vace_block_of(int layer) const;
  /// Reference attention that acts after VACE block or main layer `at`, or -1.
  int reference_of(int at) const;
  /// All weights of the transformer.
  std::int64_t parameters() const;

  /// Throws std::invalid_argument naming the field that no network can have.
  void check() const;

  /// Of "<folder>/config.json" in diffusers' layout. A uniview_* key asks for the official reference branch; the key
  /// "uniview_ref_branch" may be "hint", "dit" (with "uniview_ref_dit_layers", by default the VACE layers the hints
  /// would have entered at) or "none". Throws Error: file_not_found; file_damaged or value_invalid naming the key.
  static TransformerConfig read(const std::string& folder);

  static TransformerConfig wan_1_3b();  ///< VACE 1.3B, without a reference branch.
  static TransformerConfig wan_14b();   ///< VACE 14B with the official reference branch.
};

/// Patches of one clip: frames x rows x columns of tokens.
struct TokenGrid {
  std::int64_t frames = 0, rows = 0, columns = 0;
  std::int64_t tokens() const { return frames * rows * columns; }
};

}  // namespace uwv::model
