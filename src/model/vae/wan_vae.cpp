// SPDX-License-Identifier: Apache-2.0
#include "model/vae/wan_vae.h"

#include <ATen/ATen.h>

#include <algorithm>
#include <filesystem>
#include <optional>

#include "model/vae/vae_shapes.h"
#include "model/weights/freed_memory.h"
#include "model/weights/wan_names.h"
#include "uwv/core/error.h"

namespace uwv::model {
namespace {

constexpr const char* encode_stage = "vae encode";
constexpr const char* decode_stage = "vae decode";

/// Called between blocks, with how far the pass is.
std::function<void()> stopper(Monitor& monitor, const char* stage, const long& done, const long& total) {
  return [&monitor, stage, &done, &total] { monitor.step(stage, done, total); };
}

/// (1, 3, n, H, W) on the CPU of frames (rows, W, 3).
at::Tensor as_clip(const std::vector<at::Tensor>& frames) {
  return at::stack(frames).permute({3, 0, 1, 2}).unsqueeze(0).to(at::kCPU, at::kFloat).contiguous();
}

/// One frame (H, W, 3) of a clip (1, 3, n, H, W), some of its rows.
at::Tensor frame_rows(const at::Tensor& clip, std::int64_t number, Rows rows) {
  return clip[0].select(1, number).narrow(1, rows.begin, rows.count()).permute({1, 2, 0});
}

void check_finite(const at::Tensor& values, const char* what) {
  if (!at::isfinite(values).all().item<bool>())
    fail(ErrorCode::value_invalid, "{} hold NaN or infinite numbers; what made them went wrong", what);
}

/// Tells the progress of one part of several as that of the whole.
class PartMonitor : public Monitor {
 public:
  PartMonitor(Monitor& whole, std::int64_t parts) : whole_(whole), parts_(parts) {}
  bool progress(std::string_view stage, long done, long total) override {
    return whole_.progress(stage, finished_ * total + done, parts_ * total);
  }
  void warn(const std::string& sentence) override { whole_.warn(sentence); }
  void next() { ++finished_; }

 private:
  Monitor& whole_;
  long parts_, finished_ = 0;
};

}  // namespace

WanVae::WanVae(VaeConfig config, WeightFiles weights, const VaeOptions& options)
    : config_(std::move(config)), weights_(std::move(weights)), options_(options) {
  options_.check();
  options_.precision = resolved(options.precision);
  weights_.check(vae_shapes(config_));
  weights_.put_on(options_.device);
  mean_ = at::tensor(config_.latents_mean);
  std_ = at::tensor(config_.latents_std);
}

WanVae WanVae::open(const std::string& folder, const VaeOptions& options) {
  VaeConfig config = VaeConfig::read((std::filesystem::path(folder) / "config.json").string());
  WeightFiles weights = WeightFiles::open(folder);
  weights.rename(vae_diffusers_name);
  return {std::move(config), std::move(weights), options};
}

TileGrid WanVae::tiles(std::int64_t latent_height, std::int64_t latent_width, std::int64_t scale) const {
  const std::int64_t factor = config_.spatial_factor();
  if (options_.tile == 0) return {latent_height, latent_width, std::max(latent_height, latent_width), 1, scale};
  return {latent_height, latent_width, options_.tile / factor, options_.stride() / factor, scale};
}

VaeArithmetic WanVae::arithmetic() const {
  return {options_.precision == VaePrecision::bf16 ? at::kBFloat16 : at::kFloat, options_.winograd};
}

at::Tensor WanVae::encode(const at::Tensor& video, Monitor& monitor, const VaeProbe& probe) const {
  if (video.dim() != 5 || video.size(0) != 1 || video.size(1) != 3)
    fail(ErrorCode::size_mismatch, "the autoencoder takes one clip of shape (1, 3, frames, height, width)");
  const auto source = [&](std::int64_t first, std::int64_t count) { return video.narrow(2, first, count); };
  return encode(source, video.size(2), video.size(3), video.size(4), monitor, probe);
}

at::Tensor WanVae::encode(const ClipSource& source, std::int64_t frames, std::int64_t height, std::int64_t width,
                          Monitor& monitor, const VaeProbe& probe) const {
  const std::int64_t factor = config_.spatial_factor();
  if (frames < 1 || height < 1 || width < 1 || height % factor != 0 || width % factor != 0)
    fail(ErrorCode::size_mismatch,
         "a clip of {} frames of {}x{} cannot be encoded: at least one frame is wanted, sides that are multiples of {}",
         frames, width, height, factor);
  const TileGrid grid = tiles(height / factor, width / factor, 1);
  if (!grid.is_cut()) return encode_piece(source, frames, height, monitor, probe);
  PartMonitor parts(monitor, grid.rows() * grid.columns());
  return blended_tiles(grid, [&](Rows rows, Rows columns) {
    const auto cut = [&](std::int64_t first, std::int64_t count) {
      return source(first, count)
          .narrow(3, rows.begin * factor, rows.count() * factor)
          .narrow(4, columns.begin * factor, columns.count() * factor);
    };
    at::Tensor tile = encode_piece(cut, frames, rows.count() * factor, parts, {});
    parts.next();
    return tile;
  });
}

at::Tensor WanVae::encode_piece(const ClipSource& source, std::int64_t frames, std::int64_t height, Monitor& monitor,
                                const VaeProbe& probe) const {
  const std::int64_t latent_height = height / config_.spatial_factor();
  const std::int64_t used = config_.frames_of(config_.latent_frames(frames));
  long done = 0, total = 0;
  const auto between = stopper(monitor, encode_stage, done, total);

  const WanEncoder encoder(weights_, config_, arithmetic());
  WanEncoder::Pass pass(encoder, latent_height, options_.bands, between, probe);
  total = static_cast<long>(pass.bands()) * used;
  std::optional<WanEncoder::Ending> ending;
  std::vector<at::Tensor> latents;
  std::vector<std::vector<at::Tensor>> waiting(static_cast<std::size_t>(config_.latent_frames(frames)));
  for (std::size_t band = 0; band < pass.bands(); ++band) {
    pass.enter(band);
    if (band + 1 == pass.bands()) ending.emplace(encoder, pass.pool(), latent_height, between, probe);
    std::size_t complete = 0;
    for (std::int64_t first = 0; first < used;) {
      const std::int64_t count = first == 0 ? 1 : config_.temporal_factor();
      const at::Tensor clip = source(first, count);
      check_finite(clip, "the pictures to encode");
      for (std::int64_t i = 0; i < count; ++i) {
        std::optional<at::Tensor> features = pass.push(frame_rows(clip, i, pass.picture_rows()));
        monitor.step(encode_stage, ++done, total);
        if (!features) continue;
        give_back_freed_memory();
        std::vector<at::Tensor>& parts = waiting[complete++];
        parts.push_back(std::move(*features));
        if (parts.size() < pass.bands()) continue;
        at::Tensor whole = parts.size() == 1 ? std::move(parts[0]) : at::cat(parts);
        parts.clear();
        const at::Tensor mean = ending->push(std::move(whole)).narrow(2, 0, config_.z_dim).to(at::kCPU, at::kFloat);
        latents.push_back((mean - mean_) / std_);
      }
      first += count;
    }
  }
  return at::stack(latents).permute({3, 0, 1, 2}).unsqueeze(0).contiguous();
}

void WanVae::decode(const at::Tensor& latents, const ClipSink& sink, Monitor& monitor, const VaeProbe& probe) const {
  if (latents.dim() != 5 || latents.size(0) != 1 || latents.size(1) != config_.z_dim || latents.numel() == 0)
    fail(ErrorCode::size_mismatch, "latents of shape (1, {}, frames, height, width) are wanted for decoding",
         config_.z_dim);
  check_finite(latents, "the latents to decode");
  const TileGrid grid = tiles(latents.size(3), latents.size(4), config_.spatial_factor());
  if (grid.is_cut()) return decode_tiles(grid, latents, sink, monitor);
  const auto clamped = [&](std::int64_t first, const at::Tensor& frames) { sink(first, frames.clamp(-1, 1)); };
  decode_piece(latents, clamped, monitor, probe);
}

void WanVae::decode_tiles(const TileGrid& grid, const at::Tensor& latents, const ClipSink& sink,
                          Monitor& monitor) const {
  PartMonitor parts(monitor, grid.rows() * grid.columns());
  const at::Tensor whole = blended_tiles(grid, [&](Rows rows, Rows columns) {
    std::vector<at::Tensor> chunks;
    decode_piece(latents.narrow(3, rows.begin, rows.count()).narrow(4, columns.begin, columns.count()),
                 [&](std::int64_t, const at::Tensor& frames) { chunks.push_back(frames); }, parts, {});
    parts.next();
    return at::cat(chunks, 2);
  });
  for (std::int64_t first = 0; first < whole.size(2);) {
    const std::int64_t count = first == 0 ? 1 : config_.temporal_factor();
    sink(first, whole.narrow(2, first, count).clamp(-1, 1).contiguous());
    first += count;
  }
}

void WanVae::decode_piece(const at::Tensor& latents, const ClipSink& sink, Monitor& monitor,
                          const VaeProbe& probe) const {
  const std::int64_t latent_frames = latents.size(2);
  long done = 0, total = 0;

  const WanDecoder decoder(weights_, config_, arithmetic());
  WanDecoder::Pass pass(decoder, latents.size(3), options_.bands, stopper(monitor, decode_stage, done, total), probe);
  total = static_cast<long>(pass.bands()) * config_.frames_of(latent_frames);
  std::vector<std::vector<at::Tensor>> waiting(static_cast<std::size_t>(latent_frames));
  for (std::size_t band = 0; band < pass.bands(); ++band) {
    pass.enter(band);
    std::int64_t first = 0;
    for (std::int64_t k = 0; k < latent_frames; ++k) {
      const at::Tensor normalised = latents[0].select(1, k).permute({1, 2, 0}).to(at::kCPU, at::kFloat);
      std::vector<at::Tensor> frames;
      pass.push(normalised * std_ + mean_, [&](const at::Tensor& frame) {
        frames.push_back(frame);
        monitor.step(decode_stage, ++done, total);
      });
      std::vector<at::Tensor>& parts = waiting[static_cast<std::size_t>(k)];
      parts.push_back(as_clip(frames));
      give_back_freed_memory();
      if (parts.size() < pass.bands()) continue;
      sink(first, parts.size() == 1 ? parts[0] : at::cat(parts, 3));
      parts.clear();
      first += static_cast<std::int64_t>(frames.size());
    }
  }
}

at::Tensor WanVae::decode(const at::Tensor& latents, Monitor& monitor, const VaeProbe& probe) const {
  std::vector<at::Tensor> parts;
  decode(
      latents, [&](std::int64_t, const at::Tensor& frames) { parts.push_back(frames); }, monitor, probe);
  return at::cat(parts, 2);
}

}  // namespace uwv::model
