// SPDX-License-Identifier: Apache-2.0
#include "model/transformer/forward_pass.h"

#include <ATen/ATen.h>

#include "model/layers/token_kernels.h"
#include "uwv/core/error.h"

namespace uwv::model {

at::Tensor ForwardPass::run(const at::Tensor& latents, const at::Tensor& timestep) {
  check_inputs(latents, timestep);
  prepare_positions(latents);
  x_ = kept_of(network_.ends().patches(latents));
  time_ = network_.ends().time(timestep);
  show("tokens_patch", x_);
  show("tokens_control", context_.control);
  show("tokens_ref", context_.reference);
  show("text_tokens", context_.text);
  show("time_sinusoid", time_.sinusoid);
  show("temb", time_.embedded);
  show("timestep_proj", time_.parts.flatten(1));
  if (skip_blocks()) {
    x_.add_(context_.change);
    return finish(latents);
  }
  const at::Tensor before = hooks_.skip_blocks ? x_.clone() : at::Tensor();
  run_blocks();
  if (before.defined()) context_.change = x_ - before;
  return finish(latents);
}

void ForwardPass::check_inputs(const at::Tensor& latents, const at::Tensor& timestep) const {
  require(context_.text.defined(), "{} text tokens are prepared, wanted some: call prepare() first", 0);
  require(timestep.dim() == 1 && timestep.size(0) == latents.size(0), "{} timesteps are given for a batch of {}",
          timestep.numel(), latents.size(0));
  for (const at::Tensor& part : {context_.text, context_.control, context_.reference})
    require(!part.defined() || part.size(0) == 1 || part.size(0) == latents.size(0),
            "a context of batch {} meets latents of batch {}", part.defined() ? part.size(0) : 0, latents.size(0));
}

void ForwardPass::show(const std::string& name, const at::Tensor& value) const {
  if (hooks_.inspect && value.defined()) hooks_.inspect(name, value);
}

void ForwardPass::show(const char* name, int index, const char* part, const at::Tensor& value) const {
  if (hooks_.inspect) hooks_.inspect(fmt::format("{}_{:02}{}", name, index, part), value);
}

void ForwardPass::prepare_positions(const at::Tensor& latents) {
  const TokenGrid grid = network_.ends().patches.grid(latents);
  require(!context_.control.defined() || context_.control.size(1) <= grid.tokens(),
          "control has {} tokens and the latents only {}", context_.control.defined() ? context_.control.size(1) : 0,
          grid.tokens());
  const TokenGrid& known = context_.grid;
  if (known.frames == grid.frames && known.rows == grid.rows && known.columns == grid.columns) return;
  check_kept(grid);
  context_.grid = grid;
  context_.rotary = rotary_tables(grid, network_.config().head_dim, latents.device());
  if (context_.kept.defined())
    context_.rotary = {context_.rotary.cosine.index_select(0, context_.kept),
                       context_.rotary.sine.index_select(0, context_.kept)};
  context_.change = at::Tensor();
}

void ForwardPass::check_kept(const TokenGrid& grid) const {
  const at::Tensor& kept = context_.kept;
  if (!kept.defined()) return;
  require(kept.dim() == 1 && kept.scalar_type() == at::kLong && kept.numel() > 0,
          "kept tokens have {} dimensions and {} values, wanted a list of one or more whole numbers", kept.dim(),
          kept.numel());
  const auto first = kept.min().item<std::int64_t>(), last = kept.max().item<std::int64_t>();
  require(first >= 0 && last < grid.tokens(), "kept tokens are {} to {}, wanted 0 to {}", first, last,
          grid.tokens() - 1);
}

at::Tensor ForwardPass::kept_of(const at::Tensor& tokens) const {
  return context_.kept.defined() ? tokens.index_select(1, context_.kept) : tokens;
}

bool ForwardPass::skip_blocks() const {
  if (!hooks_.skip_blocks || !context_.change.defined() || context_.change.sizes() != x_.sizes()) return false;
  const std::vector<StageId>& order = network_.stages().order();
  for (std::size_t at = 0; at < order.size(); ++at)
    if (!order[at].vace) return hooks_.skip_blocks(network_.stages().get(at)->block.modulated(x_, time_.parts));
  return false;
}

void ForwardPass::run_blocks() {
  const std::vector<StageId>& order = network_.stages().order();
  for (std::size_t at = 0; at < order.size(); ++at) {
    const StageId& id = order[at];
    if (hooks_.between) hooks_.between(id.name(), static_cast<double>(at) / static_cast<double>(order.size()));
    const auto stage = network_.stages().get(at);
    if (id.vace)
      run_vace(at, id, *stage);
    else
      run_main(at, id, *stage);
    network_.stages().done(at);
  }
}

void ForwardPass::run_main(std::size_t at, const StageId& id, const Stage& stage) {
  stage.block(x_, time_.parts, text_keys(at, stage.block), context_.rotary, network_.options().ffn_rows);
  check_finite(x_, id);
  show("block", id.index, "", x_);
  if (hint_.defined())
    add_gated(x_, hint_, context_.control_scale[network_.config().vace_block_of(id.index)].expand({1, x_.size(2)}));
  hint_ = at::Tensor();
  if (stage.reference) run_reference(at, network_.config().reference_of(id.index), stage, x_);
}

void ForwardPass::run_vace(std::size_t at, const StageId& id, const Stage& stage) {
  if (id.index == 0) start_control(stage);
  stage.block(control_, time_.parts, text_keys(at, stage.block), context_.rotary, network_.options().ffn_rows);
  check_finite(control_, id);
  show("vace", id.index, "_state", control_);
  hint_ = stage.proj_out(control_);
  show("vace", id.index, "_hint", hint_);
  if (stage.reference) run_reference(at, network_.config().reference_of(id.index), stage, hint_);
}

/// The control stream starts as its own tokens, zero past their end, plus the main stream's.
void ForwardPass::start_control(const Stage& first) {
  at::Tensor tokens = context_.control.expand({x_.size(0), -1, -1});
  if (const std::int64_t missing = context_.grid.tokens() - tokens.size(1); missing > 0)
    tokens = at::cat({tokens, at::zeros({x_.size(0), missing, x_.size(2)}, tokens.options())}, 1);
  control_ = first.proj_in(kept_of(tokens).contiguous());
  add_gated(control_, x_, {});
}

void ForwardPass::run_reference(std::size_t at, int index, const Stage& stage, const at::Tensor& x) {
  if (!context_.reference.defined()) return;
  KeysValues keys = context_.reference_keys[at];
  if (!keys.defined()) keys = stage.reference->keys_values(context_.reference);
  if (network_.options().keep_keys) context_.reference_keys[at] = keys;
  const at::Tensor delta = (*stage.reference)(x, keys);
  show("ref_attn", index, "", delta);
  stage.reference->add(x, delta);
}

const KeysValues& ForwardPass::text_keys(std::size_t at, const TransformerBlock& block) {
  if (context_.text_keys[at].defined()) return context_.text_keys[at];
  KeysValues& place = network_.options().keep_keys ? context_.text_keys[at] : keys_now_;
  place = block.text_keys(context_.text.to(token_type(network_.options().form)));
  return place;
}

void ForwardPass::check_finite(const at::Tensor& x, const StageId& id) const {
  if (all_finite(x)) return;
  fail(ErrorCode::value_invalid,
       "the numbers are no longer finite after {}; hold its weights in another form ({} now), "
       "or look for damaged weights or latents",
       id.name(), to_string(network_.options().form));
}

at::Tensor ForwardPass::finish(const at::Tensor& latents) const {
  const TransformerConfig& config = network_.config();
  const at::Tensor parts = network_.ends().out_table + time_.embedded.unsqueeze(1);
  if (hooks_.inspect)
    show("norm_out", layer_norm(x_, at::ones({config.dim()}, x_.options()), at::zeros({config.dim()}, x_.options()),
                                config.eps, at::kFloat));
  const at::Tensor normed = layer_norm(x_, parts.select(1, 1) + 1, parts.select(1, 0), config.eps, at::kFloat);
  const TokenGrid& grid = context_.grid;
  const auto& patch = config.patch;
  at::Tensor patches = network_.ends().out(normed);
  if (context_.kept.defined())
    patches = at::zeros({patches.size(0), grid.tokens(), patches.size(2)}, patches.options())
                  .index_copy_(1, context_.kept, patches);
  return patches
      .reshape(
          {latents.size(0), grid.frames, grid.rows, grid.columns, patch[0], patch[1], patch[2], config.out_channels})
      .permute({0, 7, 1, 4, 2, 5, 3, 6})
      .reshape({latents.size(0), config.out_channels, latents.size(2), latents.size(3), latents.size(4)});
}

}  // namespace uwv::model
