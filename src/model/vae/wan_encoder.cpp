// SPDX-License-Identifier: Apache-2.0
#include "model/vae/wan_encoder.h"

#include <ATen/ATen.h>
#include <fmt/format.h>

namespace uwv::model {

WanEncoder::WanEncoder(const WeightFiles& weights, const VaeConfig& config, const VaeArithmetic& how)
    : config_(config),
      how_(how),
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

WanEncoder::Pass::Pass(const WanEncoder& encoder, std::int64_t latent_height, Rows rows, std::function<void()> between,
                       VaeProbe probe)
    : encoder_(encoder),
      rows_(encoder_rows(encoder.config_, latent_height, rows)),
      pass_{FramePool(encoder.how_.type), std::move(between)},
      probe_(std::move(probe)),
      levels_(encoder.levels_.size()) {
  for (std::size_t i = 0; i < levels_.size(); ++i) levels_[i].blocks.resize(encoder.levels_[i].blocks.size());
}

std::optional<at::Tensor> WanEncoder::Pass::push(const at::Tensor& picture) {
  conv_in_.push(pass_.pool.copy_of(picture));
  at::Tensor frame = encoder_.conv_in_(conv_in_, pass_.pool);
  if (probe_) probe_("conv_in", frame);
  for (std::size_t i = 0;; ++i) {
    frame = run_blocks(i, std::move(frame));
    if (i + 1 == levels_.size()) return frame;
    // Zeros to the right, and below where the picture ends, for the last of the windows of three.
    const bool at_end = rows_[i].out.end == rows_[i].height;
    frame = encoder_.levels_[i].resample(at::constant_pad_nd(frame, {0, 0, 0, 1, 0, at_end ? 1 : 0}));
    if (!encoder_.levels_[i].halves_frames) continue;
    std::optional<at::Tensor> halved = halve_frames(i, frame);
    if (!halved) return std::nullopt;
    frame = std::move(*halved);
  }
}

at::Tensor WanEncoder::Pass::run_blocks(std::size_t index, at::Tensor frame) {
  const Level& level = encoder_.levels_[index];
  for (std::size_t i = 0; i < level.blocks.size(); ++i)
    frame = level.blocks[i](std::move(frame), levels_[index].blocks[i], pass_);
  const Rows in = rows_[index].in, out = rows_[index].out;
  return frame.narrow(0, out.begin - in.begin, out.count());
}

std::optional<at::Tensor> WanEncoder::Pass::halve_frames(std::size_t index, const at::Tensor& frame) {
  LevelMemory& memory = levels_[index];
  const std::int64_t number = memory.seen++;
  if (number == 0) {
    // The first frame stays as it is; the frames after it look back at it.
    memory.halving.push(pass_.pool.copy_of(frame));
    return frame;
  }
  memory.halving.push(pass_.pool.copy_of(frame));
  if (number % 2 != 0) {
    memory.halving.keep(2, pass_.pool);
    return std::nullopt;
  }
  return encoder_.levels_[index].halving(memory.halving, pass_.pool);
}

WanEncoder::Ending::Ending(const WanEncoder& encoder, std::function<void()> between, VaeProbe probe)
    : encoder_(encoder), pass_{FramePool(encoder.how_.type), std::move(between)}, probe_(std::move(probe)) {}

at::Tensor WanEncoder::Ending::push(at::Tensor features) {
  const at::Tensor frame = encoder_.mid_(std::move(features), mid_, pass_);
  if (probe_) probe_("mid_block", frame);
  return encoder_.quant_(encoder_.head_(frame, head_, pass_));
}

}  // namespace uwv::model
