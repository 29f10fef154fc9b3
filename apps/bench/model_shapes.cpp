// SPDX-License-Identifier: Apache-2.0
#include "bench/model_shapes.h"

#include <fmt/format.h>

namespace uwv::bench {
namespace {

/// Collects the VAE's layers by what they are.
class VaeShapes {
 public:
  void conv(const std::string& name, std::int64_t out, std::int64_t in, std::vector<std::int64_t> kernel) {
    kernel.insert(kernel.begin(), {out, in});
    shapes_[name + ".weight"] = std::move(kernel);
    shapes_[name + ".bias"] = {out};
  }
  void gamma(const std::string& name, std::int64_t channels, int dimensions) {
    std::vector<std::int64_t> shape(static_cast<std::size_t>(dimensions), 1);
    shape[0] = channels;
    shapes_[name + ".gamma"] = shape;
  }
  void residual(const std::string& name, std::int64_t in, std::int64_t out) {
    gamma(name + ".norm1", in, 4);
    conv(name + ".conv1", out, in, {3, 3, 3});
    gamma(name + ".norm2", out, 4);
    conv(name + ".conv2", out, out, {3, 3, 3});
    if (in != out) conv(name + ".conv_shortcut", out, in, {1, 1, 1});
  }
  void middle(const std::string& name, std::int64_t channels) {
    residual(name + ".resnets.0", channels, channels);
    residual(name + ".resnets.1", channels, channels);
    gamma(name + ".attentions.0.norm", channels, 3);
    conv(name + ".attentions.0.to_qkv", 3 * channels, channels, {1, 1});
    conv(name + ".attentions.0.proj", channels, channels, {1, 1});
  }
  Shapes take() { return std::move(shapes_); }

 private:
  Shapes shapes_;
};

void add_encoder(VaeShapes& shapes) {
  const std::string down = "encoder.down_blocks.";
  shapes.conv("encoder.conv_in", 96, 3, {3, 3, 3});
  shapes.residual(down + "0", 96, 96);
  shapes.residual(down + "1", 96, 96);
  shapes.conv(down + "2.resample.1", 96, 96, {3, 3});
  shapes.residual(down + "3", 96, 192);
  shapes.residual(down + "4", 192, 192);
  shapes.conv(down + "5.resample.1", 192, 192, {3, 3});
  shapes.conv(down + "5.time_conv", 192, 192, {3, 1, 1});
  shapes.residual(down + "6", 192, 384);
  shapes.residual(down + "7", 384, 384);
  shapes.conv(down + "8.resample.1", 384, 384, {3, 3});
  shapes.conv(down + "8.time_conv", 384, 384, {3, 1, 1});
  shapes.residual(down + "9", 384, 384);
  shapes.residual(down + "10", 384, 384);
  shapes.middle("encoder.mid_block", 384);
  shapes.gamma("encoder.norm_out", 384, 4);
  shapes.conv("encoder.conv_out", 32, 384, {3, 3, 3});
}

void add_decoder(VaeShapes& shapes) {
  struct Level {
    std::int64_t in, out;
    bool doubles_time, doubles_size;
  };
  const std::vector<Level> levels{
      {384, 384, true, true}, {192, 384, true, true}, {192, 192, false, true}, {96, 96, false, false}};
  shapes.conv("decoder.conv_in", 384, 16, {3, 3, 3});
  shapes.middle("decoder.mid_block", 384);
  for (std::size_t i = 0; i < levels.size(); ++i) {
    const std::string name = fmt::format("decoder.up_blocks.{}", i);
    const Level& level = levels[i];
    for (int r = 0; r < 3; ++r)
      shapes.residual(fmt::format("{}.resnets.{}", name, r), r == 0 ? level.in : level.out, level.out);
    if (level.doubles_size) shapes.conv(name + ".upsamplers.0.resample.1", level.out / 2, level.out, {3, 3});
    if (level.doubles_time) shapes.conv(name + ".upsamplers.0.time_conv", 2 * level.out, level.out, {3, 1, 1});
  }
  shapes.gamma("decoder.norm_out", 96, 4);
  shapes.conv("decoder.conv_out", 3, 96, {3, 3, 3});
}

}  // namespace

Shapes vae_shapes() {
  VaeShapes shapes;
  add_encoder(shapes);
  add_decoder(shapes);
  shapes.conv("quant_conv", 32, 32, {1, 1, 1});
  shapes.conv("post_quant_conv", 16, 16, {1, 1, 1});
  return shapes.take();
}

std::string vae_config() {
  return R"({
  "_class_name": "AutoencoderKLWan",
  "attn_scales": [],
  "base_dim": 96,
  "dim_mult": [1, 2, 4, 4],
  "dropout": 0.0,
  "latents_mean": [-0.7571, -0.7089, -0.9113, 0.1075, -0.1745, 0.9653, -0.1517, 1.5508, 0.4134, -0.0715, 0.5517, -0.3632, -0.1922, -0.9497, 0.2503, -0.2921],
  "latents_std": [2.8184, 1.4541, 2.3275, 2.6558, 1.2196, 1.7708, 2.6052, 2.0743, 3.2687, 2.1526, 2.8652, 1.5579, 1.6382, 1.1253, 2.8251, 1.9160],
  "num_res_blocks": 2,
  "temperal_downsample": [false, true, true],
  "z_dim": 16
}
)";
}

Shapes text_encoder_shapes() {
  constexpr std::int64_t width = 4096, feed_forward = 10240, words = 256384;
  Shapes shapes{{"shared.weight", {words, width}}, {"encoder.final_layer_norm.weight", {width}}};
  for (int i = 0; i < 24; ++i) {
    const std::string attention = fmt::format("encoder.block.{}.layer.0.", i);
    const std::string after = fmt::format("encoder.block.{}.layer.1.", i);
    for (const char* part : {"q", "k", "v", "o"})
      shapes[attention + "SelfAttention." + part + ".weight"] = {width, width};
    shapes[attention + "SelfAttention.relative_attention_bias.weight"] = {32, 64};
    shapes[attention + "layer_norm.weight"] = {width};
    shapes[after + "DenseReluDense.wi_0.weight"] = {feed_forward, width};
    shapes[after + "DenseReluDense.wi_1.weight"] = {feed_forward, width};
    shapes[after + "DenseReluDense.wo.weight"] = {width, feed_forward};
    shapes[after + "layer_norm.weight"] = {width};
  }
  return shapes;
}

std::string text_encoder_config() {
  return R"({
  "architectures": ["UMT5EncoderModel"],
  "d_ff": 10240,
  "d_kv": 64,
  "d_model": 4096,
  "dense_act_fn": "gelu_new",
  "feed_forward_proj": "gated-gelu",
  "is_gated_act": true,
  "layer_norm_epsilon": 1e-06,
  "model_type": "umt5",
  "num_heads": 64,
  "num_layers": 24,
  "relative_attention_max_distance": 128,
  "relative_attention_num_buckets": 32,
  "vocab_size": 256384
}
)";
}

}  // namespace uwv::bench
