// SPDX-License-Identifier: Apache-2.0
// The estimate of vae_cost.h against the memory that encoding and decoding take.
#include <ATen/ATen.h>
#include <gtest/gtest.h>

#include "model/layers/torch_scope.h"
#include "model/measured_peak.h"
#include "model/vae/vae_cost.h"
#include "model/vae/vae_shapes.h"
#include "model/vae/wan_vae.h"
#include "support/temp_folder.h"

namespace uwv::model {
namespace {

/// What docs/model.md promises.
constexpr double promised = 0.25;

/// Random weights in a folder.
class RandomVae {
 public:
  explicit RandomVae(std::int64_t width) {
    config_.base_dim = config_.decoder_base_dim = width;
    const nlohmann::json json{{"base_dim", width},
                              {"dim_mult", config_.dim_mult},
                              {"num_res_blocks", config_.num_res_blocks},
                              {"temperal_downsample", config_.temperal_downsample},
                              {"z_dim", config_.z_dim},
                              {"latents_mean", std::vector<float>(16, 0)},
                              {"latents_std", std::vector<float>(16, 1)}};
    uwv::testing::write_text(folder_.file("config.json"), json.dump());
    TensorShapes shapes = vae_shapes(config_);
    uwv::testing::write_random_weights(folder_.file("diffusion_pytorch_model.safetensors"), shapes, at::kFloat);
  }
  double peak(const ClipSize& clip, const VaeOptions& options, VaeWay way) const {
    const at::Tensor input =
        way == VaeWay::encode ? at::rand({1, 3, clip.frames, clip.height, clip.width}) * 2 - 1
                              : at::randn({1, 16, config_.latent_frames(clip.frames), clip.height / 8, clip.width / 8});
    return uwv::testing::measured_peak([&] {
      Monitor monitor;
      const WanVae vae = WanVae::open(folder_.path().string(), options);
      if (way == VaeWay::encode)
        vae.encode(input, monitor);
      else
        vae.decode(
            input, [](auto, const auto&) {}, monitor);
    });
  }
  double estimate(const ClipSize& clip, const VaeOptions& options, VaeWay way) const {
    return estimated_peak_bytes(config_, clip, options, way);
  }

 private:
  test::TempFolder folder_;
  VaeConfig config_;
};

TEST(WanVaeMemory, IsAsEstimatedWithBandsAndTiles) {
  if (!uwv::testing::peaks_can_be_measured()) GTEST_SKIP() << "the system does not count peaks anew";
  const TorchScope scope(2);
  const RandomVae vae(48), nothing(16);
  const ClipSize clip{5, 192, 256}, small{1, 16, 16};
  struct Cut {
    int bands, tile;
  };
  for (const VaeWay way : {VaeWay::encode, VaeWay::decode})
    for (const VaePrecision precision : {VaePrecision::f32, VaePrecision::bf16})
      for (const auto& [bands, tile] : {Cut{1, 0}, Cut{4, 0}, Cut{1, 128}}) {
        VaeOptions options;
        options.precision = precision;
        // The libraries' share differs from program to program, so it is measured with a network of next to no size.
        const double libraries = nothing.peak(small, options, way) - nothing.estimate(small, options, way);
        options.bands = bands;
        options.tile = tile;
        EXPECT_TRUE(uwv::testing::estimates(vae.estimate(clip, options, way) + libraries, vae.peak(clip, options, way),
                                            promised))
            << (way == VaeWay::encode ? "encode " : "decode ") << to_string(precision) << ", bands " << bands
            << ", tile " << tile;
        EXPECT_LT(libraries, 0);
      }
}

}  // namespace
}  // namespace uwv::model
