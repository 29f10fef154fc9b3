// SPDX-License-Identifier: Apache-2.0
// Golden cases of the transformer: files case_*.safetensors beside its weights.
#pragma once

#include <algorithm>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "model/tensor_support.h"
#include "model/transformer/wan_transformer.h"
#include "support/matchers.h"

namespace uwv::testing {

/// The cases in a folder, sorted.
inline std::vector<std::string> cases_in(const std::string& folder) {
  std::vector<std::string> found;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    if (entry.path().filename().string().starts_with("case_")) found.push_back(entry.path().string());
  std::sort(found.begin(), found.end());
  return found;
}

/// Names of the folders of transformers among the fixtures, sorted; with `shards`, only those whose weights are in
/// several files.
inline std::vector<std::string> transformers(bool shards = false) {
  std::vector<std::string> found;
  for (const auto& entry : std::filesystem::directory_iterator(fixture_folder("transformer"))) {
    const bool whole = std::filesystem::exists(entry.path() / "diffusion_pytorch_model.safetensors");
    if (entry.is_directory() && !(shards && whole)) found.push_back(entry.path().filename().string());
  }
  std::sort(found.begin(), found.end());
  return found;
}

/// One call of the network with what came of it.
class GoldenCase {
 public:
  explicit GoldenCase(const std::string& path) : files_(model::WeightFiles::open(path)) {}

  at::Tensor get(const std::string& name) const { return files_.has(name) ? files_.view(name) : at::Tensor(); }
  at::Tensor in(const std::string& name) const { return get("in." + name); }
  std::vector<std::string> names() const { return files_.names(); }
  bool is_bf16() const { return in("hidden_states").scalar_type() == at::kBFloat16; }

  model::TransformerContext prepare(const model::WanTransformer& network) const {
    return network.prepare(in("control_hidden_states"), in("ref_latents"), in("encoder_hidden_states"),
                           in("control_hidden_states_scale"));
  }
  at::Tensor forward(const model::WanTransformer& network, model::TransformerContext& context,
                     const model::TransformerHooks& hooks = {}) const {
    return network.forward(context, in("hidden_states"), in("timestep"), hooks);
  }
  at::Tensor run(const model::WanTransformer& network) const {
    model::TransformerContext context = prepare(network);
    return forward(network, context);
  }

 private:
  model::WeightFiles files_;
};

inline double rms(const at::Tensor& x) { return x.to(at::kDouble).square().mean().sqrt().item<double>(); }

}  // namespace uwv::testing
