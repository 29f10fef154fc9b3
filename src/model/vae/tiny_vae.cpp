// SPDX-License-Identifier: Apache-2.0
#include "model/vae/tiny_vae.h"

#include <ATen/ATen.h>
#include <fmt/format.h>

#include "model/vae/frame_doubling.h"
#include "uwv/core/error.h"

namespace uwv::model {
namespace {

constexpr std::int64_t frames_a_latent = 4;
constexpr const char* stage = "tiny vae decode";

/// One level of the network by the numbers in its keys.
struct LevelNumbers {
  int first_block, grow, resample;
  std::int64_t frames;
};
constexpr LevelNumbers level_numbers[] = {{3, 7, 8, 1}, {9, 13, 14, 2}, {15, 19, 20, 2}};

std::string key(int number, const char* rest) { return fmt::format("decoder.{}.{}", number, rest); }

TensorShapes wanted_shapes(const WeightFiles& weights) {
  TensorShapes shapes;
  const auto conv = [&](const std::string& prefix, std::int64_t in, std::int64_t out, bool bias) {
    shapes[prefix + "weight"] = {out, in, 3, 3};
    if (bias) shapes[prefix + "bias"] = {out};
  };
  const std::vector<std::int64_t> first = weights.shape("decoder.1.weight");
  std::int64_t channels = first[0];
  conv("decoder.1.", first[1], channels, true);
  for (const LevelNumbers& numbers : level_numbers) {
    for (int block = numbers.first_block; block < numbers.first_block + 3; ++block) {
      conv(key(block, "conv.0."), 2 * channels, channels, true);
      conv(key(block, "conv.2."), channels, channels, true);
      conv(key(block, "conv.4."), channels, channels, true);
    }
    const std::int64_t next = weights.shape(key(numbers.resample, "weight")).front();
    conv(key(numbers.resample, ""), channels, next, false);
    channels = next;
  }
  conv("decoder.22.", channels, 3, true);
  return shapes;
}

void check_grow(const WeightFiles& weights, const std::string& name, std::int64_t rows, std::int64_t channels) {
  const std::vector<std::int64_t> shape = weights.has(name) ? weights.shape(name) : std::vector<std::int64_t>{};
  if (shape.size() != 4 || shape[0] < rows || shape[1] != channels || shape[2] != 1 || shape[3] != 1)
    fail(ErrorCode::value_invalid, "{}: {} is not {} rows or more of {} channels, as a TAEHV for Wan 2.1 has them",
         weights.path(), name, rows, channels);
}

/// All that can be known to be wrong from the headers is told here.
WeightFiles checked_weights(const std::string& path) {
  WeightFiles weights = WeightFiles::open(path);
  for (const char* name : {"decoder.1.weight", "decoder.8.weight", "decoder.14.weight", "decoder.20.weight"})
    if (!weights.has(name) || weights.shape(name).size() != 4)
      fail(ErrorCode::value_invalid, "{}: has no convolution '{}': it is no TAEHV for Wan 2.1 (taew2_1.safetensors)",
           weights.path(), name);
  weights.check(wanted_shapes(weights));
  for (const LevelNumbers& numbers : level_numbers) {
    const std::int64_t channels = weights.shape(key(numbers.first_block, "conv.4.weight")).front();
    check_grow(weights, key(numbers.grow, "conv.weight"), numbers.frames * channels, channels);
  }
  return weights;
}

FrameConv conv_of(const WeightFiles& weights, const std::string& prefix, at::ScalarType type) {
  const std::string bias = prefix + "bias";
  return {weights.load(prefix + "weight", type), weights.has(bias) ? weights.load(bias, type) : at::Tensor(),
          FrameConv::Edge::same};
}

/// Checkpoints may hold rows for more frames than are wanted; the last frames' rows count.
at::Tensor grow_of(const WeightFiles& weights, const std::string& name, std::int64_t rows, at::ScalarType type) {
  return weights.load(name, type).flatten(1).narrow(0, weights.shape(name)[0] - rows, rows).contiguous();
}

}  // namespace

/// What one pass through a clip remembers: of each block, the frame it saw before.
struct TinyVae::Pass {
  std::vector<std::vector<at::Tensor>> before;
  std::vector<at::Tensor> shown;
  FramePool pool;
  Monitor& monitor;
  long done, total;
};

void TinyVae::check(const std::string& path, std::int64_t z_dim) {
  const std::int64_t channels = checked_weights(path).shape("decoder.1.weight")[1];
  if (channels != z_dim)
    fail(ErrorCode::value_invalid, "--vae-fast {}: decodes latents of {} channels, those of --model have {}", path,
         channels, z_dim);
}

TinyVae TinyVae::open(const std::string& path, const VaeOptions& options) {
  WeightFiles weights = checked_weights(path);
  weights.put_on(options.device);
  TinyVae vae;
  vae.device_ = options.device;
  vae.type_ = resolved(options.precision) == VaePrecision::bf16 ? at::kBFloat16 : at::kFloat;
  vae.conv_in_ = conv_of(weights, "decoder.1.", vae.type_);
  for (const LevelNumbers& numbers : level_numbers) {
    Level& level = vae.levels_.emplace_back();
    std::int64_t channels = 0;
    for (int number = numbers.first_block; number < numbers.first_block + 3; ++number) {
      const at::Tensor both = weights.load(key(number, "conv.0.weight"), vae.type_);
      channels = both.size(0);
      level.blocks.push_back({FrameConv(both.narrow(1, 0, channels),
                                        weights.load(key(number, "conv.0.bias"), vae.type_), FrameConv::Edge::same),
                              FrameConv(both.narrow(1, channels, channels), {}, FrameConv::Edge::same),
                              conv_of(weights, key(number, "conv.2."), vae.type_),
                              conv_of(weights, key(number, "conv.4."), vae.type_)});
    }
    level.frames = numbers.frames;
    level.grow = grow_of(weights, key(numbers.grow, "conv.weight"), numbers.frames * channels, vae.type_);
    level.resample = conv_of(weights, key(numbers.resample, ""), vae.type_);
  }
  vae.conv_out_ = conv_of(weights, "decoder.22.", vae.type_);
  return vae;
}

void TinyVae::decode(const at::Tensor& latents, const ClipSink& sink, Monitor& monitor) const {
  if (latents.dim() != 5 || latents.size(0) != 1 || latents.size(1) != z_dim() || latents.numel() == 0)
    fail(ErrorCode::size_mismatch, "latents of shape (1, {}, frames, height, width) are wanted for decoding", z_dim());
  if (!at::isfinite(latents).all().item<bool>())
    fail(ErrorCode::value_invalid, "the latents to decode hold NaN or infinite numbers; what made them went wrong");
  const std::int64_t count = latents.size(2);
  Pass pass{std::vector<std::vector<at::Tensor>>(levels_.size()),
            {},
            FramePool(type_, device_),
            monitor,
            0,
            frames_a_latent * count};
  for (std::size_t i = 0; i < levels_.size(); ++i) pass.before[i].resize(levels_[i].blocks.size());
  std::int64_t first = 0;
  for (std::int64_t k = 0; k < count; ++k) {
    const at::Tensor latent = latents[0].select(1, k).permute({1, 2, 0}).to(device_, at::kFloat);
    // The network's first step: large latents are bent to +-3.
    push(0, conv_in_(at::tanh(latent / 3).mul_(3).to(type_).contiguous(), pass.pool).relu_(), pass);
    if (k == 0) pass.shown.erase(pass.shown.begin(), pass.shown.end() - 1);
    const at::Tensor frames =
        at::stack(pass.shown).permute({3, 0, 1, 2}).unsqueeze(0).to(at::kCPU, at::kFloat).contiguous();
    pass.shown.clear();
    sink(first, frames.clamp(0, 1).mul_(2).sub_(1));
    first += frames.size(2);
  }
}

void TinyVae::push(std::size_t index, at::Tensor frame, Pass& pass) const {
  if (index == levels_.size()) {
    pass.shown.push_back(conv_out_(frame.relu_(), pass.pool));
    pass.monitor.step(stage, ++pass.done, pass.total);
    return;
  }
  const Level& level = levels_[index];
  for (std::size_t i = 0; i < level.blocks.size(); ++i) {
    const Block& block = level.blocks[i];
    at::Tensor& before = pass.before[index][i];
    at::Tensor inner = block.current(frame, pass.pool);
    if (before.defined()) block.before.add_to(inner, before);
    inner = block.second(inner.relu_(), pass.pool);
    inner = block.third(inner.relu_(), pass.pool);
    before = std::move(frame);
    frame = inner.add_(before).relu_();
  }
  // One pixel at a time: the same before the picture doubles as after, at a quarter of the work.
  const at::Tensor grown = at::linear(frame, level.grow);
  const std::int64_t channels = frame.size(2);
  for (std::int64_t i = 0; i < level.frames; ++i)
    push(index + 1, level.resample(doubled(grown.narrow(2, i * channels, channels)), pass.pool), pass);
}

at::Tensor TinyVae::decode(const at::Tensor& latents, Monitor& monitor) const {
  std::vector<at::Tensor> parts;
  decode(
      latents, [&](std::int64_t, const at::Tensor& frames) { parts.push_back(frames); }, monitor);
  return at::cat(parts, 2);
}

}  // namespace uwv::model
