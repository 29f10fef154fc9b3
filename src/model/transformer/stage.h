// SPDX-License-Identifier: Apache-2.0
// The transformer in the order it is run, one block at a time, each either kept or fetched when its turn comes.
//
// VACE block k runs just before main layer vace_layers[k], whose hint it is, not before the whole main stream: the
// answer is the same, and one hint is held instead of all of them.
#pragma once

#include <future>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "model/transformer/block.h"
#include "model/transformer/reference_attention.h"

namespace uwv::model {

/// Which block.
struct StageId {
  bool vace = false;
  int index = 0;
  std::string prefix() const { return (vace ? "vace_blocks." : "blocks.") + std::to_string(index); }
  /// For people: "block 3", "VACE block 1".
  std::string name() const { return (vace ? "VACE block " : "block ") + std::to_string(index); }
};

std::vector<StageId> stages_in_order(const TransformerConfig& config);

struct Stage {
  TransformerBlock block;
  Linear proj_in, proj_out;                     ///< Of VACE blocks; proj_in of the first only.
  std::optional<ReferenceAttention> reference;  ///< Where one acts after this block.
};

class Stages {
 public:
  /// With `streamed`, blocks are made when they are asked for, the next one is read ahead in the background, and what
  /// the last one was read from is given back.
  Stages(const FusedWeights& weights, const TransformerConfig& config, LinearForm form, bool streamed);
  ~Stages();

  const std::vector<StageId>& order() const { return order_; }
  /// Number `at` in order().
  std::shared_ptr<const Stage> get(std::size_t at);
  /// Called when number `at` has been run.
  void done(std::size_t at);

 private:
  std::shared_ptr<const Stage> make(const StageId& id) const;
  /// Which reference attention acts after a block, or -1.
  int reference_behind(const StageId& id) const;
  std::vector<std::string> names_of(const StageId& id) const;
  void release(const StageId& id) const;
  void read_ahead(std::size_t at);

  const FusedWeights& weights_;
  const TransformerConfig& config_;
  LinearForm form_;
  bool streamed_;
  std::vector<StageId> order_;
  std::vector<std::shared_ptr<const Stage>> kept_;
  std::future<void> ahead_;
};

}  // namespace uwv::model
