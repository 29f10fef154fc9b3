// SPDX-License-Identifier: Apache-2.0
#include "model/vae/row_bands.h"

#include <algorithm>

namespace uwv::model {
namespace {

/// Tall enough for a band that meets neither edge.
constexpr std::int64_t many = 1 << 20;
/// Of the rows the last layers are behind the first, the share that bands are evened out by: levels at full size, which
/// hold most, lie on one side of it, the coarse ones on the other.
constexpr std::int64_t evened = 3;
/// Below every picture.
constexpr std::int64_t lowest = std::int64_t{1} << 40;

/// The line a layer's result ends at when its input ends at `end`.
std::int64_t made_end(RowLayer layer, std::int64_t end) {
  if (end <= 0) return 0;
  switch (layer) {
    case RowLayer::convolution: return end - 1;
    case RowLayer::doubling: return 2 * end - 1;
    case RowLayer::halving: return (end - 1) / 2;
  }
  return 0;
}

std::int64_t made_height(RowLayer layer, std::int64_t height) {
  return layer == RowLayer::convolution ? height : layer == RowLayer::doubling ? 2 * height : height / 2;
}

/// The first input row that result rows from `made` on depend on.
std::int64_t needed_from(RowLayer layer, std::int64_t height, std::int64_t made) {
  if (made == made_height(layer, height)) return height;
  switch (layer) {
    case RowLayer::convolution: return std::max<std::int64_t>(0, made - 1);
    case RowLayer::doubling: return std::max<std::int64_t>(0, made - 1) / 2;
    case RowLayer::halving: return 2 * made;
  }
  return 0;
}

void pass_convolutions(std::int64_t count, std::int64_t height, BandLines& lines) {
  for (std::int64_t i = 0; i < count; ++i) band_step(RowLayer::convolution, height, lines);
}

BandRows decoder_band(const VaeConfig& config, std::int64_t latent_height, Rows lines) {
  const std::int64_t convolutions = 2 * (config.num_res_blocks + 1);
  BandRows band{{lines}, {}};
  BandLines at{lines};
  std::int64_t height = latent_height;
  for (std::size_t i = 0; i < config.levels(); ++i, height *= 2) {
    const bool last = i + 1 == config.levels();
    const Rows in = at.real(height);
    pass_convolutions(convolutions + (last ? 1 : 0), height, at);
    band.levels.push_back({in, at.real(height), height});
    if (!last) band_step(RowLayer::doubling, height, at);
  }
  return band;
}

BandRows encoder_band(const VaeConfig& config, std::int64_t latent_height, Rows lines) {
  BandRows band{{lines}, {}};
  BandLines at{lines};
  std::int64_t height = latent_height * config.spatial_factor();
  for (std::size_t i = 0; i < config.levels(); ++i, height /= 2) {
    const Rows in = at.real(height);
    pass_convolutions(2 * config.num_res_blocks + (i == 0 ? 1 : 0), height, at);
    band.levels.push_back({in, at.real(height), height});
    if (i + 1 < config.levels()) band_step(RowLayer::halving, height, at);
  }
  return band;
}

template <class Band>
std::vector<BandRows> bands_of(const VaeConfig& config, std::int64_t latent_height, const Band& band,
                               std::vector<std::int64_t> cuts) {
  cuts.push_back(lowest);
  std::vector<BandRows> bands;
  std::int64_t begin = 0;
  for (const std::int64_t cut : cuts) {
    if (cut <= begin) continue;
    bands.push_back(band(config, latent_height, Rows{begin, cut}));
    begin = cut;
  }
  return bands;
}

}  // namespace

Rows BandLines::real(std::int64_t height) const { return {std::min(line.begin, height), std::min(line.end, height)}; }

BandStep band_step(RowLayer layer, std::int64_t height, BandLines& fresh) {
  const std::int64_t results = made_height(layer, height), given = std::min(fresh.line.end, height);
  BandStep step;
  fresh.line = {made_end(layer, fresh.line.begin), made_end(layer, fresh.line.end)};
  step.made = fresh.real(results);
  step.all = {needed_from(layer, height, step.made.begin), given};
  step.keep_from = std::min(given, needed_from(layer, height, step.made.end));
  // Of a convolution, the last row at hand is the one after the last it can make.
  step.read = step.made.count() > 0 ? step.all : Rows{step.all.begin, step.all.begin};
  step.at_top = layer != RowLayer::halving && step.made.count() > 0 && step.made.begin == 0;
  step.at_bottom = step.made.count() > 0 && step.made.end == results;
  return step;
}

BlockStep block_step(std::int64_t height, BandLines& fresh) {
  BlockStep block;
  block.first = band_step(RowLayer::convolution, height, fresh);
  block.second = band_step(RowLayer::convolution, height, fresh);
  // The sum needs rows as far up as the second convolution makes them.
  block.first.all.begin = block.second.made.begin;
  block.first.keep_from = std::min(block.first.all.end, block.second.made.end);
  return block;
}

std::vector<BandRows> decoder_bands(const VaeConfig& config, std::int64_t latent_height, int most) {
  const std::int64_t scale = config.spatial_factor(), result = scale * latent_height;
  // How far the pictures' rows are behind those of the latents.
  const std::int64_t behind = scale * many - decoder_band(config, 2 * many, {0, many}).levels.back().out.end;
  std::vector<std::int64_t> cuts;
  for (int i = 1; i < most; ++i) {
    const std::int64_t fewer = behind / evened * (most - i) / most;
    const std::int64_t cut = (result * i / most + behind - fewer + scale - 1) / scale;
    if (const std::int64_t end = scale * cut - behind; end > 0 && end < result) cuts.push_back(cut);
  }
  return bands_of(config, latent_height, decoder_band, std::move(cuts));
}

std::vector<BandRows> encoder_bands(const VaeConfig& config, std::int64_t latent_height, int most) {
  const std::int64_t scale = config.spatial_factor(), pictures = scale * latent_height;
  // How far the latents' rows are behind those of the pictures.
  const std::int64_t behind = scale * (many - encoder_band(config, 2 * many, {0, scale * many}).levels.back().out.end);
  std::vector<std::int64_t> cuts;
  for (int i = 1; i < most; ++i)
    if (const std::int64_t cut = (pictures + behind / evened) * i / most / scale * scale; cut < pictures)
      cuts.push_back(cut);
  return bands_of(config, latent_height, encoder_band, std::move(cuts));
}

}  // namespace uwv::model
