// SPDX-License-Identifier: Apache-2.0
// A transformer of random weights in a folder of its own, small enough for any test.
#pragma once

#include <ATen/CPUGeneratorImpl.h>

#include <cmath>
#include <functional>
#include <string>

#include "model/tensor_support.h"
#include "model/transformer/transformer_shapes.h"
#include "model/transformer/wan_transformer.h"
#include "support/temp_folder.h"

namespace uwv::testing {

using Tensors = std::map<std::string, at::Tensor>;

class TinyModel {
 public:
  /// `more` are entries of config.json after the sizes; `change` may edit the weights before they are written.
  explicit TinyModel(const std::string& more = R"("vace_layers": [0, 2], "uniview_ref_num_inject": 1)",
                     const std::function<void(Tensors&)>& change = {}, int layers = 3) {
    write_text(folder_.file("config.json"),
               R"({"num_attention_heads": 2, "attention_head_dim": 12, "ffn_dim": 40, "text_dim": 10, "num_layers": )" +
                   std::to_string(layers) + (more.empty() ? "" : ", " + more) + "}");
    const at::Generator generator = at::detail::createCPUGenerator(11);
    for (const auto& [name, shape] : model::transformer_shapes(model::TransformerConfig::read(path()))) {
      std::int64_t reads = 1;
      for (std::size_t i = 1; i < shape.size(); ++i) reads *= shape[i];
      tensors_[name] =
          at::randn(shape, generator, at::TensorOptions(at::kFloat)) / std::sqrt(static_cast<double>(reads));
    }
    if (change) change(tensors_);
    write_safetensors(folder_.file("diffusion_pytorch_model.safetensors"), tensors_);
  }

  std::string path() const { return folder_.path().string(); }
  const Tensors& tensors() const { return tensors_; }
  model::WanTransformer open(const model::TransformerOptions& options = {}) const {
    return model::WanTransformer::open(path(), options);
  }

 private:
  test::TempFolder folder_;
  Tensors tensors_;
};

/// What one step reads, random.
struct TinyInputs {
  explicit TinyInputs(std::int64_t frames = 2, std::int64_t rows = 4, std::int64_t columns = 6,
                      std::int64_t batch = 1) {
    const at::Generator generator = at::detail::createCPUGenerator(5);
    const auto random = [&](at::IntArrayRef shape) {
      return at::randn(shape, generator, at::TensorOptions(at::kFloat));
    };
    latents = random({batch, 16, frames, rows, columns});
    control = random({batch, 96, frames, rows, columns});
    reference = random({batch, 16, 1, 4, 4});
    text = random({batch, 7, 10});
    timestep = at::full({batch}, 321.0);
  }
  at::Tensor run(const model::WanTransformer& network, const model::TransformerHooks& hooks = {}) const {
    const bool vace = !network.config().vace_layers.empty();
    model::TransformerContext context = network.prepare(vace ? control : at::Tensor(), reference, text);
    return network.forward(context, latents, timestep, hooks);
  }
  at::Tensor latents, control, reference, text, timestep;
};

}  // namespace uwv::testing
