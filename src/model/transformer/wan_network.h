// SPDX-License-Identifier: Apache-2.0
// The parts WanTransformer is made of, and their loading.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "model/transformer/embedders.h"
#include "model/transformer/stage.h"
#include "model/transformer/wan_transformer.h"

namespace uwv::model {

class WanTransformer::Network {
 public:
  Network(const std::string& folder, TransformerOptions options);
  /// Makes all parts anew from the weights as the LoRAs leave them.
  void set_loras(std::vector<WeightedLora> loras);

  const TransformerConfig& config() const { return config_; }
  const TransformerOptions& options() const { return options_; }
  const std::vector<std::string>& warnings() const { return warnings_; }

  /// The layers outside the blocks.
  struct Ends {
    explicit Ends(const FusedWeights& weights, const TransformerConfig& config);
    PatchEmbedder patches;
    std::optional<PatchEmbedder> control_patches, reference_patches;
    TimeEmbedder time;
    TextEmbedder text;
    at::Tensor out_table;  ///< (1, 2, dim)
    Linear out;
  };
  const Ends& ends() const { return *ends_; }
  Stages& stages() const { return *stages_; }

 private:
  void settle_reference_branch();
  void check_weights();

  TransformerOptions options_;
  TransformerConfig config_;
  FusedWeights weights_;
  std::vector<std::string> warnings_;
  std::unique_ptr<Ends> ends_;
  std::unique_ptr<Stages> stages_;
};

}  // namespace uwv::model
