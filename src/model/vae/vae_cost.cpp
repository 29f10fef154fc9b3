// SPDX-License-Identifier: Apache-2.0
#include "model/vae/vae_cost.h"

#include <algorithm>

#include "model/vae/row_bands.h"
#include "model/vae/vae_shapes.h"

namespace uwv::model {
namespace {

/// What the process holds before it does anything: torch and its tables.
constexpr double library_bytes = 360e6;
/// The frames that exist at once beside what is remembered, in halves of frames of the level they are largest at: a
/// block's input, its inner frame and what the pool holds in other sizes. The encoder's largest frames are halved, from
/// a copy with zeros around it.
double frames_in_flight(VaeWay way) { return way == VaeWay::decode ? 6 : 10; }
/// Rows that a convolution's input keeps of a band for the next one.
constexpr double rows_kept = 2;

/// A band's share of one level: pixels it holds of a frame, the pixels of a row, how many of its frames make a latent
/// one and how many there are in the clip.
struct LevelSize {
  double pixels = 0, width = 0, frames = 1, clip_frames = 1;
};

/// Sums over the network.
struct Cost {
  double remembered = 0;     ///< Numbers kept between frames.
  double seams = 0;          ///< Numbers kept between bands, of all frames of the clip.
  double largest_frame = 0;  ///< Numbers.
  double flops = 0;          ///< For one latent frame.
  double first_flops = 0;    ///< For the first one, which sees one frame and looks at none before.

  void add_causal(const LevelSize& size, double in, double out, double taps) {
    remembered += 2 * in * size.pixels;
    if (taps > 1) seams += rows_kept * in * size.width * size.clip_frames;
    flops += 2 * 3 * taps * in * out * size.pixels * size.frames;
    first_flops += 2 * taps * in * out * size.pixels;
    largest_frame = std::max(largest_frame, std::max(in, out) * size.pixels);
  }
  void add_plain(const LevelSize& size, double in, double out, double taps) {
    flops += 2 * taps * in * out * size.pixels * size.frames;
    first_flops += 2 * taps * in * out * size.pixels;
    largest_frame = std::max(largest_frame, std::max(in, out) * size.pixels);
  }
  void add_block(const LevelSize& size, double in, double out) {
    add_causal(size, in, out, 9);
    add_causal(size, out, out, 9);
    if (in != out) add_plain(size, in, out, 1);
  }
  void add_mid(const LevelSize& size, double channels) {
    add_block(size, channels, channels);
    add_block(size, channels, channels);
    add_plain(size, channels, 4 * channels, 1);
    flops += 4 * size.pixels * size.pixels * channels;
    first_flops += 4 * size.pixels * size.pixels * channels;
  }
};

/// Of the levels' bands and of what sees whole frames.
struct Costs {
  Cost whole, levels;
};

/// What of a clip one band's costs depend on.
struct BandClip {
  double latent_pixels = 0, latent_frames = 0;
  double width = 0;  ///< Of the first level.

  LevelSize level(const LevelRows& rows, double level_width, double frames) const {
    const bool whole = rows.in.count() == rows.height;
    const auto held = static_cast<double>(rows.in.count()) + (whole ? 0 : rows_kept);
    return {held * level_width, level_width, frames, 1 + (latent_frames - 1) * frames};
  }
  LevelSize latents() const { return {latent_pixels, 0, 1, latent_frames}; }
};

/// In order from the latents on.
Costs decoder_cost(const VaeConfig& config, const BandClip& clip, const std::vector<LevelRows>& rows) {
  Costs costs;
  double channels = static_cast<double>(config.decoder_base_dim * config.dim_mult.back());
  costs.whole.add_causal(clip.latents(), static_cast<double>(config.z_dim), channels, 9);
  costs.whole.add_mid(clip.latents(), channels);
  double frames = 1, width = clip.width;
  Cost& cost = costs.levels;
  for (std::size_t i = 0; i < config.levels(); ++i, width *= 2) {
    const LevelSize size = clip.level(rows[i], width, frames);
    const double out = static_cast<double>(config.decoder_base_dim * config.dim_mult[config.levels() - 1 - i]);
    for (std::int64_t block = 0; block <= config.num_res_blocks; ++block) {
      cost.add_block(size, channels, out);
      channels = out;
    }
    if (i + 1 == config.levels()) {
      cost.add_causal(size, channels, 3, 9);
      break;
    }
    if (config.temperal_downsample[config.levels() - 2 - i]) {
      cost.add_causal(size, channels, 2 * channels, 1);
      frames *= 2;
    }
    cost.add_plain({4 * size.pixels, 2 * width, frames, 0}, channels, channels / 2, 9);
    channels /= 2;
  }
  return costs;
}

/// In order from the pictures on.
Costs encoder_cost(const VaeConfig& config, const BandClip& clip, const std::vector<LevelRows>& rows) {
  Costs costs;
  double channels = static_cast<double>(config.base_dim);
  double frames = static_cast<double>(config.temporal_factor()), width = clip.width;
  Cost& cost = costs.levels;
  for (std::size_t i = 0; i < config.levels(); ++i, width /= 2) {
    const LevelSize size = clip.level(rows[i], width, frames);
    if (i == 0) cost.add_causal(size, 3, channels, 9);
    const double out = static_cast<double>(config.base_dim * config.dim_mult[i]);
    for (std::int64_t block = 0; block < config.num_res_blocks; ++block) {
      cost.add_block(size, channels, out);
      channels = out;
    }
    if (i + 1 == config.levels()) break;
    const LevelSize small{size.pixels / 4, width / 2, frames, 0};
    cost.add_plain(small, channels, channels, 9);
    if (config.temperal_downsample[i]) {
      frames /= 2;
      cost.add_causal({small.pixels, width / 2, frames, 0}, channels, channels, 1);
    }
  }
  costs.whole.add_mid(clip.latents(), channels);
  costs.whole.add_causal(clip.latents(), channels, static_cast<double>(2 * config.z_dim), 9);
  return costs;
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

std::vector<BandRows> bands_of(const VaeConfig& config, const ClipSize& piece, int bands, VaeWay way) {
  const std::int64_t rows = piece.height / config.spatial_factor();
  return way == VaeWay::decode ? decoder_bands(config, rows, bands) : encoder_bands(config, rows, bands);
}

Costs band_cost(const VaeConfig& config, const ClipSize& piece, const std::vector<LevelRows>& rows, VaeWay way) {
  const std::int64_t factor = config.spatial_factor(), columns = piece.width / factor;
  const std::int64_t rows_of_latents = piece.height / factor;
  const auto latents = static_cast<double>(rows_of_latents * columns);
  const auto frames = static_cast<double>(config.latent_frames(piece.frames));
  if (way == VaeWay::decode) return decoder_cost(config, {latents, frames, static_cast<double>(columns)}, rows);
  return encoder_cost(config, {latents, frames, static_cast<double>(piece.width)}, rows);
}

/// Numbers of features next to the latents, of so many of their rows, in the whole clip.
double features(const VaeConfig& config, const ClipSize& size, std::int64_t rows, VaeWay way) {
  const std::int64_t base = way == VaeWay::decode ? config.decoder_base_dim : config.base_dim;
  const std::int64_t columns = size.width / config.spatial_factor();
  return static_cast<double>(base * config.dim_mult.back() * config.latent_frames(size.frames) * rows * columns);
}

/// Numbers a piece needs at the most, beside the weights and the results that wait.
double working_numbers(const VaeConfig& config, const ClipSize& piece, int most, VaeWay way) {
  const std::vector<BandRows> bands = bands_of(config, piece, most, way);
  const auto in_flight = [way](const Cost& cost) { return frames_in_flight(way) * cost.largest_frame / 2; };
  double most_numbers = 0;
  for (std::size_t i = 0; i < bands.size(); ++i) {
    const Costs costs = band_cost(config, piece, bands[i].levels, way);
    double numbers = costs.levels.remembered + in_flight(costs.levels);
    if (bands.size() > 1) numbers += costs.levels.seams;
    // What sees whole frames is at work in the decoder's first band and in the encoder's last one.
    const bool beside = way == VaeWay::decode ? i == 0 : i + 1 == bands.size();
    if (beside) numbers += costs.whole.remembered + (bands.size() == 1 ? 0 : in_flight(costs.whole));
    most_numbers = std::max(most_numbers, numbers);
  }
  if (bands.size() == 1) return most_numbers;
  const std::int64_t rows = piece.height / config.spatial_factor();
  const std::int64_t waiting = way == VaeWay::decode ? rows - bands.front().levels.front().in.count()
                                                     : rows - bands.back().levels.back().out.count();
  return most_numbers + features(config, piece, waiting, way);
}

}  // namespace

double estimated_peak_bytes(const VaeConfig& config, const ClipSize& size, const VaeOptions& options, VaeWay way) {
  const ClipSize piece = piece_of(size, options);
  const double number = bytes_a_number(options);
  // Frames that wait, in float32: of bands, all but the last one's rows; of tiles, the whole clip.
  double waiting_share = 0;
  if (way == VaeWay::decode) {
    const Rows last = bands_of(config, piece, options.bands, way).back().levels.back().out;
    waiting_share = 1 - static_cast<double>(last.count()) / static_cast<double>(piece.height);
    if (options.tile > 0 && (size.height > options.tile || size.width > options.tile)) waiting_share = 1;
  }
  const double clip = 4.0 * 3.0 * static_cast<double>(size.frames * size.height * size.width);
  return library_bytes + number * (weight_numbers(config, way) + working_numbers(config, piece, options.bands, way)) +
         waiting_share * clip + transformed_bytes(config, options);
}

double estimated_flops(const VaeConfig& config, const ClipSize& size, const VaeOptions& options, VaeWay way) {
  const ClipSize piece = piece_of(size, options);
  const Costs costs = band_cost(config, piece, bands_of(config, piece, 1, way).front().levels, way);
  const double later = static_cast<double>(config.latent_frames(size.frames) - 1);
  const double flops =
      costs.whole.first_flops + costs.levels.first_flops + later * (costs.whole.flops + costs.levels.flops);
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
