// SPDX-License-Identifier: Apache-2.0
// The estimate of tiny_vae_cost.h against the memory that decoding takes.
#include <ATen/ATen.h>
#include <gtest/gtest.h>

#include "model/layers/torch_scope.h"
#include "model/measured_peak.h"
#include "model/transformer/transformer_cost.h"
#include "model/vae/tiny_vae.h"
#include "model/vae/tiny_vae_cost.h"
#include "support/temp_folder.h"

namespace uwv::model {
namespace {

/// What docs/model.md promises.
constexpr double promised = 0.25;

TensorShapes shapes_of(const TinyVaeSizes& sizes) {
  TensorShapes shapes;
  const auto conv = [&](int number, const std::string& name, std::int64_t in, std::int64_t out, std::int64_t side = 3) {
    shapes["decoder." + std::to_string(number) + name + ".weight"] = {out, in, side, side};
  };
  conv(1, "", sizes.z_dim, sizes.levels[0]);
  shapes["decoder.1.bias"] = {sizes.levels[0]};
  for (std::size_t i = 0; i < 3; ++i) {
    const int first = std::array{3, 9, 15}[i];
    const std::int64_t channels = sizes.levels[i], next = i < 2 ? sizes.levels[i + 1] : sizes.last;
    for (int block = first; block < first + 3; ++block)
      for (const int number : {0, 2, 4}) {
        const std::string name = ".conv." + std::to_string(number);
        conv(block, name, number == 0 ? 2 * channels : channels, channels);
        shapes["decoder." + std::to_string(block) + name + ".bias"] = {channels};
      }
    conv(first + 4, ".conv", channels, (i == 0 ? 1 : 2) * channels, 1);
    conv(first + 5, "", channels, next);
  }
  conv(22, "", sizes.last, 3);
  shapes["decoder.22.bias"] = {3};
  return shapes;
}

TEST(TinyVaeMemory, IsAsEstimated) {
  if (!uwv::testing::peaks_can_be_measured()) GTEST_SKIP() << "the system does not count peaks anew";
  const TorchScope scope(2);
  const test::TempFolder folder;
  const TinyVaeSizes sizes;
  uwv::testing::write_random_weights(folder.file("taew2_1.safetensors"), shapes_of(sizes), at::kHalf);
  struct Case {
    VaePrecision precision;
    std::int64_t height;
  };
  for (const auto& [precision, height] : {Case{VaePrecision::f32, 240}, Case{VaePrecision::bf16, 480}}) {
    const at::Tensor latents = at::randn({1, sizes.z_dim, 2, height / 8, 52});
    VaeOptions options;
    options.precision = precision;
    const auto peak = [&](const at::Tensor& z) {
      return uwv::testing::measured_peak([&] {
        Monitor monitor;
        TinyVae::open(folder.path().string(), options)
            .decode(
                z, [](auto, const auto&) {}, monitor);
      });
    };
    // The libraries' share differs from program to program, so it is measured with next to no picture.
    const double libraries = peak(latents.narrow(3, 0, 1).narrow(4, 0, 1)) - estimated_weight_bytes(sizes, precision);
    const double estimate = estimated_peak_bytes(sizes, {5, height, 416}, precision) - program_bytes + libraries;
    EXPECT_TRUE(uwv::testing::estimates(estimate, peak(latents), promised)) << to_string(precision);
    EXPECT_LT(libraries, program_bytes);
  }
}

}  // namespace
}  // namespace uwv::model
