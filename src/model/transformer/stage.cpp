// SPDX-License-Identifier: Apache-2.0
#include "model/transformer/stage.h"

#include "model/transformer/weight_access.h"
#include "model/weights/freed_memory.h"

namespace uwv::model {

std::vector<StageId> stages_in_order(const TransformerConfig& config) {
  std::vector<StageId> order;
  for (int layer = 0; layer < config.layers; ++layer) {
    if (const int k = config.vace_block_of(layer); k >= 0) order.push_back({true, k});
    order.push_back({false, layer});
  }
  return order;
}

Stages::Stages(const FusedWeights& weights, const TransformerConfig& config, LinearForm form, bool streamed)
    : weights_(weights), config_(config), form_(form), streamed_(streamed), order_(stages_in_order(config)) {
  if (streamed_) return;
  for (const StageId& id : order_) {
    kept_.push_back(make(id));
    // Where making a layer rounded its weights, the pages they were read from would count twice, and so would what
    // rounding took.
    release(id);
    give_back_freed_memory();
  }
}

Stages::~Stages() {
  if (ahead_.valid()) ahead_.wait();
}

std::shared_ptr<const Stage> Stages::make(const StageId& id) const {
  const std::string prefix = id.prefix();
  auto stage = std::make_shared<Stage>(Stage{TransformerBlock(weights_, prefix, config_, form_), {}, {}, {}});
  if (id.vace) {
    if (id.index == 0) stage->proj_in = linear(weights_, prefix + ".proj_in", form_);
    stage->proj_out = linear(weights_, prefix + ".proj_out", form_);
  }
  if (const int j = reference_behind(id); j >= 0)
    stage->reference.emplace(weights_, j, config_.heads, config_.eps, form_);
  return stage;
}

int Stages::reference_behind(const StageId& id) const {
  const bool refers = config_.reference == (id.vace ? ReferenceBranch::hint : ReferenceBranch::dit);
  return refers ? config_.reference_of(id.index) : -1;
}

std::vector<std::string> Stages::names_of(const StageId& id) const {
  std::vector<std::string> names;
  const std::string start = id.prefix() + ".";
  const int j = reference_behind(id);
  const std::string reference = "uniview_ref_attn." + std::to_string(j) + ".";
  for (const std::string& name : weights_.files().names())
    if (name.starts_with(start) || (j >= 0 && name.starts_with(reference))) names.push_back(name);
  return names;
}

std::shared_ptr<const Stage> Stages::get(std::size_t at) {
  if (!streamed_) return kept_[at];
  if (ahead_.valid()) ahead_.get();
  read_ahead((at + 1) % order_.size());
  return make(order_[at]);
}

void Stages::done(std::size_t at) {
  if (streamed_) release(order_[at]);
}

void Stages::release(const StageId& id) const {
  for (const std::string& name : names_of(id)) weights_.files().release(name);
}

void Stages::read_ahead(std::size_t at) {
  ahead_ = std::async(std::launch::async, [this, names = names_of(order_[at])] {
    for (const std::string& name : names) weights_.files().will_need(name);
  });
}

}  // namespace uwv::model
