// SPDX-License-Identifier: Apache-2.0
// Wan's diffusion transformer with VACE's context blocks and the reference branch: from noisy latents to the velocity
// that takes the noise away. Sheet model.md, 1 to 3.
//
// Call everything under a TorchScope. Borders are float32; what lies between follows the options.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "model/layers/linear.h"
#include "model/lora/lora_file.h"
#include "model/transformer/attention.h"
#include "model/transformer/transformer_config.h"

namespace uwv::model {

struct TransformerOptions {
  c10::Device device = c10::kCPU;     ///< Where it is run; weights move there as they are read.
  LinearForm form = LinearForm::f32;  ///< Of the blocks' linear layers; embedders and the last layer stay float32.
  /// Blocks are read from the mapped file when their turn comes and given back after it: a model larger than memory
  /// runs.
  bool streamed = false;
  /// Text and reference keys of every block are kept for the next step: 2 * text tokens * dim numbers a block.
  bool keep_keys = true;
  /// Tokens that go through a feed-forward layer at once. It is up to six times as wide as a token, so long clips need
  /// less memory with fewer; below some thousand, weights held in few bits are widened too often.
  std::int64_t ffn_rows = 8192;
  std::vector<WeightedLora> loras;

  void check() const;
};

/// All that stays the same from step to step of one clip. Made by prepare(); forward() fills in what it finds out.
struct TransformerContext {
  at::Tensor text;           ///< (batch, tokens, dim)
  at::Tensor control;        ///< (batch or 1, tokens, dim) or undefined.
  at::Tensor reference;      ///< (batch or 1, tokens, dim) or undefined.
  at::Tensor control_scale;  ///< One factor a VACE block.
  /// Places of the tokens that take part, rising (int64); undefined = all. To be set before the first forward(). The
  /// others are as if the clip had never had them; their velocity comes back as 0.
  at::Tensor kept;
  TokenGrid grid;  ///< Of `rotary`.
  RotaryTables rotary;
  std::vector<KeysValues> text_keys, reference_keys;  ///< By place in the order of blocks.
  at::Tensor change;  ///< What all blocks together added to the tokens when they last ran; see skip_blocks.
};

/// What a caller may watch and decide while forward() runs. Any of them may throw to stop.
struct TransformerHooks {
  /// Before each block: its name and how far the step is, 0 to 1.
  std::function<void(std::string_view name, double done)> between;
  /// Every intermediate by the name the fixtures give it. The tensor changes later; keep a clone.
  std::function<void(const std::string& name, const at::Tensor& value)> inspect;
  /// Step caching: given the first block's modulated input (batch, tokens, dim), true leaves all blocks out and adds
  /// the change that they made in the last step instead. Only asked when there is one.
  std::function<bool(const at::Tensor& modulated)> skip_blocks;
};

class WanTransformer {
 public:
  class Network;

  /// `folder` holds config.json and safetensors. Throws Error: as TransformerConfig::read and WeightFiles::open do;
  /// value_invalid naming tensors that are missing or misshaped, or LoRA layers that do not fit.
  static WanTransformer open(const std::string& folder, const TransformerOptions& options);
  WanTransformer(WanTransformer&&) noexcept;
  WanTransformer& operator=(WanTransformer&&) noexcept;
  ~WanTransformer();

  const TransformerConfig& config() const;
  /// What was out of the ordinary in the checkpoint: unknown tensors, a reference branch that is not there.
  const std::vector<std::string>& warnings() const;

  /// Replaces all LoRAs; none gives the checkpoint's own weights again, bit by bit.
  void set_loras(std::vector<WeightedLora> loras);

  /// control (batch or 1, vace_in_channels, frames, rows, columns), undefined for a model without VACE, may have fewer
  /// tokens than the latents; ref_latents (batch or 1, ref_in_channels, any frames, rows, columns) or undefined to skip
  /// the reference branch; text (batch, tokens, text_dim); control_scale one factor a VACE block, undefined for ones.
  TransformerContext prepare(const at::Tensor& control, const at::Tensor& ref_latents, const at::Tensor& text,
                             const at::Tensor& control_scale = {}) const;
  /// The same clip with another text, for the other branch of guidance: shares all that does not depend on text.
  TransformerContext with_text(const TransformerContext& context, const at::Tensor& text) const;

  /// latents (batch, in_channels, frames, rows, columns), timestep (batch) in 0..1000; the velocity has out_channels
  /// and lies on options.device. Here and in prepare(), tensors from anywhere are taken and moved. Throws
  /// Error(value_invalid) naming the block after which numbers are no longer finite.
  at::Tensor forward(TransformerContext& context, const at::Tensor& latents, const at::Tensor& timestep,
                     const TransformerHooks& hooks = {}) const;

 private:
  explicit WanTransformer(std::unique_ptr<Network> network);
  std::unique_ptr<Network> network_;
};

}  // namespace uwv::model
