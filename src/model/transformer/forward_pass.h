// SPDX-License-Identifier: Apache-2.0
// One evaluation of the transformer. Sheet model.md, 3.
#pragma once

#include "model/transformer/wan_network.h"

namespace uwv::model {

class ForwardPass {
 public:
  ForwardPass(const WanTransformer::Network& network, TransformerContext& context, const TransformerHooks& hooks)
      : network_(network), context_(context), hooks_(hooks) {}

  at::Tensor run(const at::Tensor& latents, const at::Tensor& timestep);

 private:
  void check_inputs(const at::Tensor& latents, const at::Tensor& timestep) const;
  void show(const std::string& name, const at::Tensor& value) const;
  void show(const char* name, int index, const char* part, const at::Tensor& value) const;
  void prepare_positions(const at::Tensor& latents);
  void check_kept(const TokenGrid& grid) const;
  /// Of (batch, all tokens, dim) those that take part.
  at::Tensor kept_of(const at::Tensor& tokens) const;
  /// Leaves the blocks out when the caller wants it, see TransformerHooks::skip_blocks.
  bool skip_blocks() const;
  void run_blocks();
  void run_main(std::size_t at, const StageId& id, const Stage& stage);
  void run_vace(std::size_t at, const StageId& id, const Stage& stage);
  void run_reference(std::size_t at, int index, const Stage& stage, const at::Tensor& x);
  void start_control(const Stage& first);
  const KeysValues& text_keys(std::size_t at, const TransformerBlock& block);
  void check_finite(const at::Tensor& x, const StageId& id) const;
  at::Tensor finish(const at::Tensor& latents) const;

  const WanTransformer::Network& network_;
  TransformerContext& context_;
  const TransformerHooks& hooks_;
  TimeEmbedding time_;
  at::Tensor x_, control_, hint_;
  KeysValues keys_now_;  ///< Of a block whose keys are not kept.
};

}  // namespace uwv::model
