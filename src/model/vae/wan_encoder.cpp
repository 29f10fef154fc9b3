// SPDX-License-Identifier: Apache-2.0
#include "model/vae/wan_encoder.h"

#include <ATen/ATen.h>
#include <fmt/format.h>

#include "uwv/core/error.h"

namespace uwv::model {

WanEncoder::WanEncoder(const WeightFiles& weights, const VaeConfig& config, const VaeArithmetic& how)
    : config_(config),
      how_(how),
      device_(weights.device()),
      conv_in_(weights, "encoder.conv_in", how),
      mid_(weights, "encoder.mid_block", how),
      head_(weights, "encoder", how),
      quant_(weights, "quant_conv", how) {
  // The checkpoint numbers blocks and what halves the picture between them in one list.
  int number = 0;
  const auto next = [&] { return fmt::format("encoder.down_blocks.{}", number++); };
  for (std::size_t i = 0; i < config.levels(); ++i) {
    Level& level = levels_.emplace_back();
    for (std::int64_t block = 0; block < config.num_res_blocks; ++block)
      level.blocks.emplace_back(weights, next(), how);
    if (i + 1 == config.levels()) break;
    const std::string prefix = next();
    level.resample =
        FrameConv(weights.load(prefix + ".resample.1.weight", how.type),
                  weights.load(prefix + ".resample.1.bias", how.type), FrameConv::Edge::halved, how.winograd);
    level.halves_frames = config.temperal_downsample[i];
    if (level.halves_frames) level.halving = CausalConv(weights, prefix + ".time_conv", how);
  }
}

WanEncoder::Pass::Pass(const WanEncoder& encoder, std::int64_t latent_height, int bands, std::function<void()> between,
                       VaeProbe probe)
    : encoder_(encoder),
      height_(latent_height * encoder.config_.spatial_factor()),
      bands_(encoder_bands(encoder.config_, latent_height, bands)),
      pass_{FramePool(encoder.how_.type, encoder.device_), std::move(between)},
      probe_(std::move(probe)),
      levels_(encoder.levels_.size()) {
  for (std::size_t i = 0; i < levels_.size(); ++i) levels_[i].blocks.resize(encoder.levels_[i].blocks.size());
  plan();
}

void WanEncoder::Pass::plan() {
  pass_.enter({band_ == 0, band_ + 1 == bands_.size()});
  BandLines lines = bands_[band_].lines;
  std::int64_t height = height_;
  conv_in_.enter(band_step(RowLayer::convolution, height, lines));
  for (LevelMemory& level : levels_) {
    for (ResBlock::Memory& block : level.blocks) block.enter(height, lines);
    level.halving = {};
    level.seen = 0;
    if (&level == &levels_.back()) break;
    level.resample.enter(band_step(RowLayer::halving, height, lines));
    height /= 2;
  }
}

void WanEncoder::Pass::enter(std::size_t index) {
  if (index == 0) return;
  require(index == band_ + 1 && index < bands_.size(), "WanEncoder: band {} of {} does not follow band {}", index,
          bands_.size(), band_);
  band_ = index;
  plan();
}

std::optional<at::Tensor> WanEncoder::Pass::push(const at::Tensor& picture) {
  at::Tensor frame = begin(picture);
  if (probe_) probe_("conv_in", frame);
  for (std::size_t i = 0;; ++i) {
    const Level& level = encoder_.levels_[i];
    for (std::size_t block = 0; block < level.blocks.size(); ++block)
      frame = level.blocks[block](std::move(frame), levels_[i].blocks[block], pass_);
    if (i + 1 == levels_.size()) return frame;
    frame = halve_picture(i, frame);
    if (!level.halves_frames) continue;
    std::optional<at::Tensor> halved = halve_frames(i, frame);
    if (!halved) return std::nullopt;
    frame = std::move(*halved);
  }
}

at::Tensor WanEncoder::Pass::begin(const at::Tensor& picture) {
  const BandStep& step = conv_in_.step;
  const at::Tensor all = pass_.joined(picture.to(encoder_.device_, encoder_.how_.type), conv_in_);
  if (step.made.count() == 0) return no_rows(all, all.size(1), encoder_.conv_in_.results());
  BorderedFrame newest = bordered_frame(pass_.pool, pass_.place, step, all.size(0), all.size(1), all.size(2));
  newest.inside.copy_(all);
  conv_in_.frames.push(std::move(newest.frame));
  return encoder_.conv_in_(conv_in_.frames, pass_.pool, pass_.row_edge());
}

at::Tensor WanEncoder::Pass::halve_picture(std::size_t index, const at::Tensor& frame) {
  ConvMemory& memory = levels_[index].resample;
  const FrameConv& conv = encoder_.levels_[index].resample;
  const at::Tensor all = pass_.joined(frame, memory);
  if (memory.step.made.count() == 0) return no_rows(all, all.size(1) / 2, conv.results());
  // Zeros to the right, and below where the picture ends, for the last of the windows of three.
  const std::int64_t height = all.size(0), width = all.size(1), below = memory.step.at_bottom ? 1 : 0;
  const at::Tensor seen = pass_.pool.take(height + below, width + 1, all.size(2));
  seen.narrow(0, 0, height).narrow(1, 0, width).copy_(all);
  seen.narrow(1, width, 1).zero_();
  if (below > 0) seen.narrow(0, height, 1).zero_();
  return conv(seen, pass_.pool);
}

std::optional<at::Tensor> WanEncoder::Pass::halve_frames(std::size_t index, const at::Tensor& frame) {
  LevelMemory& memory = levels_[index];
  const std::int64_t number = memory.seen++;
  memory.halving.push(pass_.pool.copy_of(frame));
  // The first frame stays as it is; the frames after it look back at it.
  if (number == 0) return frame;
  if (number % 2 != 0) {
    memory.halving.keep(2);
    return std::nullopt;
  }
  if (frame.size(0) == 0) {
    memory.halving.keep(2);
    return frame;
  }
  return encoder_.levels_[index].halving(memory.halving, pass_.pool);
}

WanEncoder::Ending::Ending(const WanEncoder& encoder, const FramePool& pool, std::int64_t latent_height,
                           std::function<void()> between, VaeProbe probe)
    : encoder_(encoder), pass_{pool, std::move(between)}, probe_(std::move(probe)) {
  mid_.enter(latent_height);
  BandLines lines{{0, latent_height + 1}};
  head_.enter(band_step(RowLayer::convolution, latent_height, lines));
}

at::Tensor WanEncoder::Ending::push(at::Tensor features) {
  const at::Tensor frame = encoder_.mid_(std::move(features), mid_, pass_);
  if (probe_) probe_("mid_block", frame);
  return encoder_.quant_(encoder_.head_(frame, head_, pass_));
}

}  // namespace uwv::model
