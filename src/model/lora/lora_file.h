// SPDX-License-Identifier: Apache-2.0
// Low-rank changes of a transformer's weights (LoRA), read from any of the dialects they are published in.
// Sheet model.md, 5.
//
//   names    original Wan's ("blocks.0.self_attn.q") or diffusers' ("blocks.0.attn1.to_q"), with or without the prefix
//            "diffusion_model.", "transformer." or "model."
//   factors  <name>.lora_A.weight and .lora_B.weight, or .lora_down.weight and .lora_up.weight, with an adapter's name
//            in between (".lora_A.default.weight") or not
//   .alpha   scales the product by alpha / rank; 1 without it
//   .diff_b  is added to the bias;  .diff  of norms and of others is left out, as the official code leaves it
#pragma once

#include <ATen/core/Tensor.h>

#include <map>
#include <string>
#include <vector>

namespace uwv::model {

/// The change of one linear layer.
struct LoraLayer {
  at::Tensor down, up;  ///< (rank, in) and (out, rank); both undefined where only the bias changes.
  at::Tensor bias;      ///< (out) or undefined.
  double scale = 1;     ///< Of the product: alpha / rank.
};

class LoraFile {
 public:
  /// Throws Error: as SafeTensors does; value_invalid naming keys of no known dialect, a factor without its partner,
  /// and factors whose ranks differ.
  static LoraFile open(const std::string& path);

  const std::string& path() const { return path_; }
  /// By the diffusers name of the layer, e.g. "blocks.0.attn1.to_q".
  const std::map<std::string, LoraLayer>& layers() const { return layers_; }
  /// Keys left out, as told above.
  const std::vector<std::string>& left_out() const { return left_out_; }

 private:
  std::string path_;
  std::map<std::string, LoraLayer> layers_;
  std::vector<std::string> left_out_;
};

struct WeightedLora {
  LoraFile file;
  double weight = 1;  ///< W + weight * alpha / rank * up down, bias + weight * diff_b.
};

}  // namespace uwv::model
