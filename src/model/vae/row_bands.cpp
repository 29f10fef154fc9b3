// SPDX-License-Identifier: Apache-2.0
#include "model/vae/row_bands.h"

#include <algorithm>

namespace uwv::model {
namespace {

Rows widened(Rows rows, std::int64_t by, std::int64_t height) {
  return {std::max<std::int64_t>(0, rows.begin - by), std::min(height, rows.end + by)};
}

}  // namespace

std::vector<Rows> split_rows(std::int64_t height, int bands) {
  const std::int64_t count = std::min<std::int64_t>(height, bands);
  std::vector<Rows> parts;
  for (std::int64_t i = 0; i < count; ++i) parts.push_back({height * i / count, height * (i + 1) / count});
  return parts;
}

std::vector<LevelRows> decoder_rows(const VaeConfig& config, std::int64_t latent_height, Rows band) {
  const std::int64_t convolutions = 2 * (config.num_res_blocks + 1);
  std::vector<LevelRows> levels(config.levels());
  Rows wanted{};
  for (std::size_t i = levels.size(); i-- > 0;) {
    LevelRows& level = levels[i];
    level.height = latent_height << i;
    if (i + 1 == levels.size()) {
      level.out = {band.begin << i, band.end << i};
      level.in = widened(level.out, convolutions + 1, level.height);  // One more for conv_out.
    } else {
      // The convolution after doubling looks one doubled row further.
      const Rows doubled = widened(wanted, 1, 2 * level.height);
      level.out = {doubled.begin / 2, (doubled.end + 1) / 2};
      level.in = widened(level.out, convolutions, level.height);
    }
    wanted = level.in;
  }
  return levels;
}

std::vector<LevelRows> encoder_rows(const VaeConfig& config, std::int64_t latent_height, Rows band) {
  const std::int64_t convolutions = 2 * config.num_res_blocks;
  std::vector<LevelRows> levels(config.levels());
  Rows wanted = band;
  for (std::size_t i = levels.size(); i-- > 0;) {
    LevelRows& level = levels[i];
    level.height = latent_height << (levels.size() - 1 - i);
    // A halved row r is made of rows 2r to 2r + 2, the last of which is beyond the picture for its last row.
    level.out = i + 1 == levels.size() ? band : Rows{2 * wanted.begin, std::min(level.height, 2 * wanted.end + 1)};
    level.in = widened(level.out, convolutions + (i == 0 ? 1 : 0), level.height);  // One more for conv_in.
    wanted = level.in;
  }
  return levels;
}

}  // namespace uwv::model
