// SPDX-License-Identifier: Apache-2.0
#include "model/vae/vae_cost.h"

#include <algorithm>

#include "model/vae/row_bands.h"
#include "model/vae/vae_shapes.h"

namespace uwv::model {
namespace {

/// What the process holds before it does anything: torch and its tables.
constexpr double library_bytes = 180e6;
/// The frames that exist at once beside what is remembered, in frames of the level they are largest at: a block's
/// input, its inner frame, the pool's spare and what the allocator has not given back yet.
constexpr double frames_in_flight = 6;

/// Sums over the network, for one latent frame after the first.
struct Cost {
  double remembered = 0;     ///< Numbers kept between frames.
  double largest_frame = 0;  ///< Numbers.
  double flops = 0;          ///< For one latent frame.
  double first_flops = 0;    ///< For the first one, which sees one frame and looks at none before.
};

/// A level's picture: pixels of the rows it is given, and how many of its frames make a latent one.
struct LevelSize {
  double pixels = 0, frames = 1;
};

void add_causal(Cost& cost, const LevelSize& size, double in, double out, double taps) {
  cost.remembered += 2 * in * size.pixels;
  cost.flops += 2 * 3 * taps * in * out * size.pixels * size.frames;
  cost.first_flops += 2 * taps * in * out * size.pixels;
  cost.largest_frame = std::max(cost.largest_frame, std::max(in, out) * size.pixels);
}

void add_plain(Cost& cost, const LevelSize& size, double in, double out, double taps) {
  cost.flops += 2 * taps * in * out * size.pixels * size.frames;
  cost.first_flops += 2 * taps * in * out * size.pixels;
  cost.largest_frame = std::max(cost.largest_frame, std::max(in, out) * size.pixels);
}

void add_block(Cost& cost, const LevelSize& size, double in, double out) {
  add_causal(cost, size, in, out, 9);
  add_causal(cost, size, out, out, 9);
  if (in != out) add_plain(cost, size, in, out, 1);
}

void add_mid(Cost& cost, const LevelSize& size, double channels) {
  add_block(cost, size, channels, channels);
  add_block(cost, size, channels, channels);
  add_plain(cost, size, channels, 4 * channels, 1);
  cost.flops += 4 * size.pixels * size.pixels * channels;
  cost.first_flops += 4 * size.pixels * size.pixels * channels;
}

/// In order from the latents on; `whole` is the size of a latent frame, `rows` what each level works on.
Cost decoder_cost(const VaeConfig& config, const LevelSize& whole, const std::vector<LevelRows>& rows, double width) {
  Cost cost;
  double channels = static_cast<double>(config.decoder_base_dim * config.dim_mult.back());
  add_causal(cost, whole, static_cast<double>(config.z_dim), channels, 9);
  add_mid(cost, whole, channels);
  double frames = 1;
  for (std::size_t i = 0; i < config.levels(); ++i, width *= 2) {
    const LevelSize size{static_cast<double>(rows[i].in.count()) * width, frames};
    const double out = static_cast<double>(config.decoder_base_dim * config.dim_mult[config.levels() - 1 - i]);
    for (std::int64_t block = 0; block <= config.num_res_blocks; ++block) {
      add_block(cost, size, channels, out);
      channels = out;
    }
    if (i + 1 == config.levels()) {
      add_causal(cost, size, channels, 3, 9);
      break;
    }
    if (config.temperal_downsample[config.levels() - 2 - i]) {
      add_causal(cost, size, channels, 2 * channels, 1);
      frames *= 2;
    }
    const LevelSize large{4 * static_cast<double>(rows[i].out.count()) * width, frames};
    add_plain(cost, large, channels, channels / 2, 9);
    channels /= 2;
  }
  return cost;
}

/// In order from the pictures on.
Cost encoder_cost(const VaeConfig& config, const LevelSize& whole, const std::vector<LevelRows>& rows, double width) {
  Cost cost;
  double channels = static_cast<double>(config.base_dim);
  double frames = static_cast<double>(config.temporal_factor());
  for (std::size_t i = 0; i < config.levels(); ++i, width /= 2) {
    const LevelSize size{static_cast<double>(rows[i].in.count()) * width, frames};
    if (i == 0) add_causal(cost, size, 3, channels, 9);
    const double out = static_cast<double>(config.base_dim * config.dim_mult[i]);
    for (std::int64_t block = 0; block < config.num_res_blocks; ++block) {
      add_block(cost, size, channels, out);
      channels = out;
    }
    if (i + 1 == config.levels()) break;
    const LevelSize small{size.pixels / 4, frames};
    add_plain(cost, small, channels, channels, 9);
    if (config.temperal_downsample[i]) {
      frames /= 2;
      add_causal(cost, {small.pixels, frames}, channels, channels, 1);
    }
  }
  add_mid(cost, whole, channels);
  add_causal(cost, whole, channels, static_cast<double>(2 * config.z_dim), 9);
  return cost;
}

double weight_numbers(const VaeConfig& config, VaeWay way) {
  const std::string half = way == VaeWay::encode ? "encoder." : "decoder.";
  double numbers = 0;
  for (const auto& [name, shape] : vae_shapes(config)) {
    if (!name.starts_with(half)) continue;
    double count = 1;
    for (const std::int64_t side : shape) count *= static_cast<double>(side);
    numbers += count;
  }
  return numbers;
}

/// The largest piece a clip is worked on in: a tile, where there are tiles.
ClipSize piece_of(const ClipSize& size, const VaeOptions& options) {
  if (options.tile == 0) return size;
  return {size.frames, std::min<std::int64_t>(size.height, options.tile),
          std::min<std::int64_t>(size.width, options.tile)};
}

/// Weights as Winograd's convolution transforms them, of the widest one.
double transformed_bytes(const VaeConfig& config, const VaeOptions& options) {
  if (!options.winograd || resolved(options.precision) == VaePrecision::bf16) return 0;
  const std::int64_t most = *std::max_element(config.dim_mult.begin(), config.dim_mult.end());
  const double channels = static_cast<double>(std::max(config.base_dim, config.decoder_base_dim) * most);
  return 4.0 * 36 * 3 * channels * channels;
}

double bytes_a_number(const VaeOptions& options) { return resolved(options.precision) == VaePrecision::bf16 ? 2 : 4; }

/// Of each band of a piece.
std::vector<Cost> band_costs(const VaeConfig& config, const ClipSize& piece, int bands, VaeWay way) {
  const std::int64_t factor = config.spatial_factor(), rows = piece.height / factor, columns = piece.width / factor;
  const LevelSize whole{static_cast<double>(rows * columns), 1};
  std::vector<Cost> costs;
  for (const Rows band : split_rows(rows, bands))
    costs.push_back(
        way == VaeWay::decode
            ? decoder_cost(config, whole, decoder_rows(config, rows, band), static_cast<double>(columns))
            : encoder_cost(config, whole, encoder_rows(config, rows, band), static_cast<double>(piece.width)));
  return costs;
}

}  // namespace

double estimated_peak_bytes(const VaeConfig& config, const ClipSize& size, const VaeOptions& options, VaeWay way) {
  const ClipSize piece = piece_of(size, options);
  double working = 0;
  const std::vector<Cost> costs = band_costs(config, piece, options.bands, way);
  for (const Cost& cost : costs)
    working = std::max(working, cost.remembered + frames_in_flight * cost.largest_frame / 2);
  // Results that wait: of bands, all but the last one's; of tiles, the whole clip's.
  const auto count = static_cast<double>(costs.size());
  const bool tiled = options.tile > 0 && (size.height > options.tile || size.width > options.tile);
  const double clip = 3.0 * static_cast<double>(size.frames * size.height * size.width);
  const double features = static_cast<double>(config.base_dim * config.dim_mult.back()) *
                          static_cast<double>(config.latent_frames(size.frames)) *
                          static_cast<double>(size.height * size.width) /
                          static_cast<double>(config.spatial_factor() * config.spatial_factor());
  const double waiting_share = tiled ? 1 : (count - 1) / count;
  const double number = bytes_a_number(options);
  const double waiting = waiting_share * (way == VaeWay::decode ? 4 * clip : number * features);
  return library_bytes + number * (weight_numbers(config, way) + working) + waiting +
         transformed_bytes(config, options);
}

double estimated_flops(const VaeConfig& config, const ClipSize& size, const VaeOptions& options, VaeWay way) {
  const ClipSize piece = piece_of(size, options);
  double flops = 0;
  for (const Cost& cost : band_costs(config, piece, options.bands, way))
    flops += cost.first_flops + cost.flops * static_cast<double>(config.latent_frames(size.frames) - 1);
  if (options.tile == 0) return flops;
  // Tiles at the edges are smaller; by their area together.
  const auto covered = [&](std::int64_t side) {
    double sum = 0;
    for (std::int64_t begin = 0; begin < side; begin += options.stride())
      sum += static_cast<double>(std::min<std::int64_t>(options.tile, side - begin));
    return sum;
  };
  return flops * covered(size.height) * covered(size.width) / static_cast<double>(piece.height * piece.width);
}

}  // namespace uwv::model
