// SPDX-License-Identifier: Apache-2.0
#include "model/vae/wan_decoder.h"

#include <ATen/ATen.h>
#include <fmt/format.h>

#include "uwv/core/error.h"

namespace uwv::model {

WanDecoder::WanDecoder(const WeightFiles& weights, const VaeConfig& config, const VaeArithmetic& how)
    : config_(config),
      how_(how),
      device_(weights.device()),
      post_quant_(weights, "post_quant_conv", how),
      conv_in_(weights, "decoder.conv_in", how),
      mid_(weights, "decoder.mid_block", how),
      head_(weights, "decoder", how) {
  for (std::size_t i = 0; i < config.levels(); ++i) {
    const std::string prefix = fmt::format("decoder.up_blocks.{}", i);
    Level& level = levels_.emplace_back();
    for (std::int64_t block = 0; block <= config.num_res_blocks; ++block)
      level.blocks.emplace_back(weights, fmt::format("{}.resnets.{}", prefix, block), how);
    if (i + 1 == config.levels()) break;
    const std::string upsampler = prefix + ".upsamplers.0";
    level.doubles_frames = config.temperal_downsample[config.levels() - 2 - i];
    if (level.doubles_frames) level.doubling = CausalConv(weights, upsampler + ".time_conv", how);
    level.resample =
        FrameConv(weights.load(upsampler + ".resample.1.weight", how.type),
                  weights.load(upsampler + ".resample.1.bias", how.type), FrameConv::Edge::doubled, how.winograd);
  }
}

WanDecoder::Pass::Pass(const WanDecoder& decoder, std::int64_t latent_height, int bands, std::function<void()> between,
                       VaeProbe probe)
    : decoder_(decoder),
      height_(latent_height),
      bands_(decoder_bands(decoder.config_, latent_height, bands)),
      whole_{FramePool(decoder.how_.type, decoder.device_), between},
      pass_{FramePool(decoder.how_.type, decoder.device_), std::move(between)},
      probe_(std::move(probe)),
      levels_(decoder.levels_.size()) {
  for (std::size_t i = 0; i < levels_.size(); ++i) levels_[i].blocks.resize(decoder.levels_[i].blocks.size());
  mid_.enter(height_);
  plan();
  whole_.pool = pass_.pool;  // frames of the coarsest level have the same sizes
}

void WanDecoder::Pass::plan() {
  pass_.enter({band_ == 0, band_ + 1 == bands_.size()});
  BandLines lines = bands_[band_].lines;
  std::int64_t height = height_;
  for (LevelMemory& level : levels_) {
    for (ResBlock::Memory& block : level.blocks) block.enter(height, lines);
    level.doubling = {};
    level.begun = false;
    if (&level == &levels_.back()) break;
    level.resample.enter(band_step(RowLayer::doubling, height, lines));
    height *= 2;
  }
  head_.enter(band_step(RowLayer::convolution, height, lines));
}

void WanDecoder::Pass::enter(std::size_t index) {
  if (index == 0) return;
  require(index == band_ + 1 && index < bands_.size(), "WanDecoder: band {} of {} does not follow band {}", index,
          bands_.size(), band_);
  if (index == 1) {
    conv_in_ = {};
    mid_ = {};
    whole_.enter({});
  }
  band_ = index;
  plan();
}

at::Tensor WanDecoder::Pass::before_levels(const at::Tensor& latent) {
  conv_in_.push(whole_.pool.copy_of(decoder_.post_quant_(latent.to(decoder_.device_, decoder_.how_.type))));
  at::Tensor frame = decoder_.conv_in_(conv_in_, whole_.pool);
  if (probe_) probe_("conv_in", frame);
  frame = decoder_.mid_(std::move(frame), mid_, whole_);
  if (probe_) probe_("mid_block", frame);
  return frame;
}

void WanDecoder::Pass::push(const at::Tensor& latent, const Sink& sink) {
  at::Tensor frame;
  if (pass_.place.first) {
    frame = before_levels(latent);
  } else {
    frame = std::move(below_.front());
    below_.pop_front();
  }
  if (!pass_.place.last) {
    const std::int64_t rows = bands_[band_].levels.front().in.count();
    below_.push_back(pass_.seams.copy_of(frame.narrow(0, rows, frame.size(0) - rows)));
    frame = pass_.pool.copy_of(frame.narrow(0, 0, rows));
  }
  push_level(0, std::move(frame), sink);
}

void WanDecoder::Pass::push_level(std::size_t index, at::Tensor frame, const Sink& sink) {
  const Level& level = decoder_.levels_[index];
  LevelMemory& memory = levels_[index];
  for (std::size_t i = 0; i < level.blocks.size(); ++i)
    frame = level.blocks[i](std::move(frame), memory.blocks[i], pass_);
  if (index + 1 == levels_.size()) {
    frame = decoder_.head_(frame, head_, pass_);
    if (probe_) probe_("out", frame);
    sink(frame);
    return;
  }
  // The clip's first frame stays one and is not looked back at.
  if (!level.doubles_frames || !memory.begun) {
    memory.begun = true;
    push_upsampled(index, frame, sink);
    return;
  }
  const std::int64_t channels = frame.size(2);
  const at::Tensor both = doubled_frames(index, frame);
  frame.reset();
  push_upsampled(index, both.narrow(2, 0, channels), sink);
  push_upsampled(index, both.narrow(2, channels, channels), sink);
}

at::Tensor WanDecoder::Pass::doubled_frames(std::size_t index, const at::Tensor& frame) {
  const CausalConv& conv = decoder_.levels_[index].doubling;
  if (frame.size(0) == 0) return no_rows(frame, frame.size(1), conv.results());
  levels_[index].doubling.push(pass_.pool.copy_of(frame));
  return conv(levels_[index].doubling, pass_.pool);
}

void WanDecoder::Pass::push_upsampled(std::size_t index, const at::Tensor& frame, const Sink& sink) {
  pass_.between();
  const FrameConv& conv = decoder_.levels_[index].resample;
  ConvMemory& memory = levels_[index].resample;
  const at::Tensor all = pass_.joined(frame, memory);
  const std::int64_t results = memory.step.made.count();
  push_level(index + 1,
             results == 0 ? no_rows(all, 2 * all.size(1), conv.results())
                          : conv.doubled_band(all, pass_.pool, memory.step.at_top ? 0 : 1, results),
             sink);
}

}  // namespace uwv::model
