// SPDX-License-Identifier: Apache-2.0
// Which rows each level of the autoencoder must compute so that a band of the result comes out as it would in one
// piece. Only convolutions look sideways, each by one row; what lies beyond a band's rows is computed wrongly and cut
// off before it can spread into them.
#pragma once

#include <cstdint>
#include <vector>

#include "model/vae/vae_config.h"

namespace uwv::model {

/// Rows [begin, end) of a picture.
struct Rows {
  std::int64_t begin = 0, end = 0;
  std::int64_t count() const { return end - begin; }
  bool operator==(const Rows&) const = default;
};

/// [0, height) in `bands` parts as equal as can be; fewer when there are fewer rows.
std::vector<Rows> split_rows(std::int64_t height, int bands);

/// A level's rows: what it is given, and what it hands on (of its own resolution, before that changes).
struct LevelRows {
  Rows in, out;
  std::int64_t height = 0;  ///< Of the whole picture at this level.
};

/// For rows [band) of latents: decoder levels, coarsest first. The first level's `in` is of the latents' size.
std::vector<LevelRows> decoder_rows(const VaeConfig& config, std::int64_t latent_height, Rows band);
/// For rows [band) of latents: encoder levels, finest first. The first level's `in` is of the pictures' size.
std::vector<LevelRows> encoder_rows(const VaeConfig& config, std::int64_t latent_height, Rows band);

}  // namespace uwv::model
