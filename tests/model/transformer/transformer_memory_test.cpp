// SPDX-License-Identifier: Apache-2.0
// The estimate of transformer_cost.h against the memory that real steps take.
#include <ATen/ATen.h>
#include <gtest/gtest.h>

#include "model/layers/torch_scope.h"
#include "model/measured_peak.h"
#include "model/transformer/transformer_cost.h"
#include "model/transformer/transformer_shapes.h"
#include "model/transformer/wan_transformer.h"
#include "support/temp_folder.h"
#include "uwv/model/compute_devices.h"

namespace uwv::model {
namespace {

using uwv::testing::estimates;

/// What docs/model.md promises.
constexpr double promised = 0.125;

/// Random weights in a folder.
class RandomTransformer {
 public:
  RandomTransformer(const TransformerConfig& config, at::ScalarType stored)
      : config_(config), stored_bytes_(static_cast<int>(c10::elementSize(stored))) {
    nlohmann::json json{{"num_attention_heads", config.heads}, {"attention_head_dim", config.head_dim},
                        {"ffn_dim", config.ffn_dim},           {"num_layers", config.layers},
                        {"text_dim", config.text_dim},         {"vace_layers", config.vace_layers}};
    uwv::testing::write_text(folder_.file("config.json"), json.dump());
    uwv::testing::write_random_weights(folder_.file("diffusion_pytorch_model.safetensors"), transformer_shapes(config),
                                       stored);
  }

  /// Opens it and makes a step.
  double peak(LinearForm form, bool streamed, std::int64_t rows, std::int64_t columns) const {
    const auto random = [](at::IntArrayRef sizes) { return at::randn(sizes, at::TensorOptions(at::kFloat)); };
    const at::Tensor latents = random({1, config_.in_channels, 1, 2 * rows, 2 * columns});
    const at::Tensor control = random({1, config_.vace_in_channels, 1, 2 * rows, 2 * columns});
    const at::Tensor text = random({1, TransformerLoad{}.text_tokens, config_.text_dim});
    return uwv::testing::measured_peak([&] {
      TransformerOptions options;
      options.form = form;
      options.streamed = streamed;
      const WanTransformer network = WanTransformer::open(folder_.path().string(), options);
      TransformerContext context = network.prepare(control, {}, text);
      network.forward(context, latents, at::full({1}, 500.0));
    });
  }
  double estimate(LinearForm form, bool streamed, std::int64_t rows, std::int64_t columns) const {
    TransformerLoad load;
    load.tokens = rows * columns;
    load.form = form;
    load.streamed = streamed;
    load.stored_bytes = stored_bytes_;
    return estimated_peak_bytes(config_, load);
  }

 private:
  test::TempFolder folder_;
  TransformerConfig config_;
  int stored_bytes_;
};

TransformerConfig medium(int layers) {
  TransformerConfig config;
  config.heads = 8;
  config.ffn_dim = 5632;
  config.layers = layers;
  config.text_dim = 512;
  config.vace_layers = {0, 2};
  return config;
}

class TransformerMemory : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!uwv::testing::peaks_can_be_measured()) GTEST_SKIP() << "the system does not count peaks anew";
    (void)fast_numbers();  // which takes some memory to find out, once
  }
  /// The libraries' share differs from program to program, so it is measured with a network of no size.
  void hold(const RandomTransformer& network, std::int64_t rows, std::int64_t columns) const {
    for (const LinearForm form :
         {LinearForm::f32, LinearForm::bf16_stored, LinearForm::bf16, LinearForm::int8_stored, LinearForm::int8})
      for (const bool streamed : {false, true}) {
        const double libraries = nothing_.peak(form, streamed, 1, 1);
        const double estimate = network.estimate(form, streamed, rows, columns) - program_bytes + libraries;
        EXPECT_TRUE(estimates(estimate, network.peak(form, streamed, rows, columns), promised))
            << to_string(form) << (streamed ? ", streamed" : "");
        EXPECT_LT(libraries, program_bytes);
      }
  }
  TorchScope scope_{2};

 private:
  static TransformerConfig no_size() {
    TransformerConfig config = medium(1);
    config.heads = 1;
    config.head_dim = 16;
    config.ffn_dim = 16;
    config.vace_layers = {0};
    return config;
  }
  RandomTransformer nothing_{no_size(), at::kFloat};
};

TEST_F(TransformerMemory, OfAHalfPrecisionFileIsAsEstimated) { hold({medium(6), at::kBFloat16}, 16, 24); }

TEST_F(TransformerMemory, OfAFloatFileIsAsEstimated) { hold({medium(3), at::kFloat}, 16, 24); }

TEST_F(TransformerMemory, OfManyTokensIsAsEstimated) {
  TransformerConfig config = medium(1);
  config.heads = 4;
  config.ffn_dim = 2048;
  config.vace_layers = {0};
  hold({config, at::kFloat}, 64, 64);
}

}  // namespace
}  // namespace uwv::model
