// SPDX-License-Identifier: Apache-2.0
#include "model/vae/vae_shapes.h"

#include <fmt/format.h>

namespace uwv::model {
namespace {

/// Collects the shapes of layers by their prefix.
class ShapeList {
 public:
  void conv(const std::string& prefix, std::int64_t in, std::int64_t out, std::vector<std::int64_t> kernel) {
    std::vector<std::int64_t> shape{out, in};
    shape.insert(shape.end(), kernel.begin(), kernel.end());
    shapes_[prefix + ".weight"] = std::move(shape);
    shapes_[prefix + ".bias"] = {out};
  }
  void norm(const std::string& prefix, std::int64_t channels) { shapes_[prefix + ".gamma"] = {channels, 1, 1, 1}; }
  void res_block(const std::string& prefix, std::int64_t in, std::int64_t out) {
    norm(prefix + ".norm1", in);
    conv(prefix + ".conv1", in, out, {3, 3, 3});
    norm(prefix + ".norm2", out);
    conv(prefix + ".conv2", out, out, {3, 3, 3});
    if (in != out) conv(prefix + ".conv_shortcut", in, out, {1, 1, 1});
  }
  void mid_block(const std::string& prefix, std::int64_t channels) {
    res_block(prefix + ".resnets.0", channels, channels);
    shapes_[prefix + ".attentions.0.norm.gamma"] = {channels, 1, 1};
    conv(prefix + ".attentions.0.to_qkv", channels, 3 * channels, {1, 1});
    conv(prefix + ".attentions.0.proj", channels, channels, {1, 1});
    res_block(prefix + ".resnets.1", channels, channels);
  }
  TensorShapes take() { return std::move(shapes_); }

 private:
  TensorShapes shapes_;
};

void add_encoder(ShapeList& list, const VaeConfig& config) {
  std::int64_t channels = config.base_dim;
  list.conv("encoder.conv_in", 3, channels, {3, 3, 3});
  int number = 0;
  const auto next = [&] { return fmt::format("encoder.down_blocks.{}", number++); };
  for (std::size_t i = 0; i < config.levels(); ++i) {
    const std::int64_t out = config.base_dim * config.dim_mult[i];
    for (std::int64_t block = 0; block < config.num_res_blocks; ++block) {
      list.res_block(next(), channels, out);
      channels = out;
    }
    if (i + 1 == config.levels()) break;
    const std::string prefix = next();
    list.conv(prefix + ".resample.1", channels, channels, {3, 3});
    if (config.temperal_downsample[i]) list.conv(prefix + ".time_conv", channels, channels, {3, 1, 1});
  }
  list.mid_block("encoder.mid_block", channels);
  list.norm("encoder.norm_out", channels);
  list.conv("encoder.conv_out", channels, 2 * config.z_dim, {3, 3, 3});
}

void add_decoder(ShapeList& list, const VaeConfig& config) {
  std::int64_t channels = config.decoder_base_dim * config.dim_mult.back();
  list.conv("decoder.conv_in", config.z_dim, channels, {3, 3, 3});
  list.mid_block("decoder.mid_block", channels);
  for (std::size_t i = 0; i < config.levels(); ++i) {
    const std::string prefix = fmt::format("decoder.up_blocks.{}", i);
    const std::int64_t out = config.decoder_base_dim * config.dim_mult[config.levels() - 1 - i];
    for (std::int64_t block = 0; block <= config.num_res_blocks; ++block) {
      list.res_block(fmt::format("{}.resnets.{}", prefix, block), channels, out);
      channels = out;
    }
    if (i + 1 == config.levels()) break;
    const std::string upsampler = prefix + ".upsamplers.0";
    if (config.temperal_downsample[config.levels() - 2 - i])
      list.conv(upsampler + ".time_conv", channels, 2 * channels, {3, 1, 1});
    list.conv(upsampler + ".resample.1", channels, channels / 2, {3, 3});
    channels /= 2;
  }
  list.norm("decoder.norm_out", channels);
  list.conv("decoder.conv_out", channels, 3, {3, 3, 3});
}

}  // namespace

TensorShapes vae_shapes(const VaeConfig& config) {
  ShapeList list;
  add_encoder(list, config);
  add_decoder(list, config);
  list.conv("quant_conv", 2 * config.z_dim, 2 * config.z_dim, {1, 1, 1});
  list.conv("post_quant_conv", config.z_dim, config.z_dim, {1, 1, 1});
  return list.take();
}

}  // namespace uwv::model
