// SPDX-License-Identifier: Apache-2.0
#include "model/vae/wan_decoder.h"

#include <ATen/ATen.h>
#include <fmt/format.h>

namespace uwv::model {

WanDecoder::WanDecoder(const WeightFiles& weights, const VaeConfig& config, const VaeArithmetic& how)
    : config_(config),
      how_(how),
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

WanDecoder::Pass::Pass(const WanDecoder& decoder, std::int64_t latent_height, Rows rows, std::function<void()> between,
                       VaeProbe probe)
    : decoder_(decoder),
      rows_(decoder_rows(decoder.config_, latent_height, rows)),
      pass_{FramePool(decoder.how_.type), std::move(between)},
      probe_(std::move(probe)),
      levels_(decoder.levels_.size()) {
  for (std::size_t i = 0; i < levels_.size(); ++i) levels_[i].blocks.resize(decoder.levels_[i].blocks.size());
}

void WanDecoder::Pass::push(const at::Tensor& latent, const std::function<void(const at::Tensor& frame)>& sink) {
  conv_in_.push(pass_.pool.copy_of(decoder_.post_quant_(latent.to(decoder_.how_.type))));
  at::Tensor frame = decoder_.conv_in_(conv_in_, pass_.pool);
  if (probe_) probe_("conv_in", frame);
  frame = decoder_.mid_(std::move(frame), mid_, pass_);
  if (probe_) probe_("mid_block", frame);
  const Rows rows = rows_.front().in;
  push_level(0, frame.narrow(0, rows.begin, rows.count()), sink);
}

void WanDecoder::Pass::push_level(std::size_t index, at::Tensor frame,
                                  const std::function<void(const at::Tensor&)>& sink) {
  const Level& level = decoder_.levels_[index];
  LevelMemory& memory = levels_[index];
  for (std::size_t i = 0; i < level.blocks.size(); ++i)
    frame = level.blocks[i](std::move(frame), memory.blocks[i], pass_);
  if (index + 1 == levels_.size()) {
    const Rows in = rows_[index].in, out = rows_[index].out;
    frame = decoder_.head_(frame, head_, pass_).narrow(0, out.begin - in.begin, out.count());
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
  memory.doubling.push(pass_.pool.copy_of(frame));
  const at::Tensor both = level.doubling(memory.doubling, pass_.pool);
  push_upsampled(index, both.narrow(2, 0, channels), sink);
  push_upsampled(index, both.narrow(2, channels, channels), sink);
}

void WanDecoder::Pass::push_upsampled(std::size_t index, const at::Tensor& frame,
                                      const std::function<void(const at::Tensor&)>& sink) {
  pass_.between();
  const Rows in = rows_[index].in, out = rows_[index].out, wanted = rows_[index + 1].in;
  const at::Tensor kept = frame.narrow(0, out.begin - in.begin, out.count()).contiguous();
  const at::Tensor large = decoder_.levels_[index].resample(kept);
  push_level(index + 1, large.narrow(0, wanted.begin - 2 * out.begin, wanted.count()), sink);
}

}  // namespace uwv::model
