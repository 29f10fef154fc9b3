// SPDX-License-Identifier: Apache-2.0
// Which rows each layer of the autoencoder makes in each band, when a picture is worked on from top to bottom in bands
// that make no row twice.
//
// A convolution looks one row up and one down. Given rows down to some row, it makes its own down to the one before:
// the band below makes that one, from the last rows it was given, which are kept for it. So the bands of each further
// layer end a row earlier than those of the layer before. At the picture's lower edge this goes on, as if there were
// rows below it: the first layers are through some bands before the last ones are, and rest.
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

/// Which of the bands is at hand.
struct BandPlace {
  bool first = true, last = true;
  bool whole() const { return first && last; }
};

/// Layers that look at neighbouring rows.
enum class RowLayer {
  convolution,  ///< 3x3.
  doubling,     ///< Each row twice, then 3x3.
  halving,      ///< 3x3 of every second row: row r of rows 2r to 2r + 2.
};

/// One layer in one band. Rows of its input but for `made`.
struct BandStep {
  Rows all;                    ///< What is at hand: kept from the band above, and fresh.
  Rows read;                   ///< What `made` is made of.
  Rows made;                   ///< Rows of the result; may be none.
  std::int64_t keep_from = 0;  ///< From here on, `all` is kept for the band below.
  bool at_top = false;         ///< Reads a row of zeros above the picture;
  bool at_bottom = false;      ///< below it.
};

/// Rows new to a layer, of a picture of `height`. `line` counts on below the picture: a layer ends its bands so far
/// behind the layer before as it would without a lower edge.
struct BandLines {
  Rows line;
  Rows real(std::int64_t height) const;
};

/// What a layer does with `fresh` lines of its input's `height`; these become the lines it hands on.
BandStep band_step(RowLayer layer, std::int64_t height, BandLines& fresh);
/// Two convolutions with what they were given added to their result.
struct BlockStep {
  BandStep first, second;
};
BlockStep block_step(std::int64_t height, BandLines& fresh);

/// A level in one band: the rows it is given, and those it hands on (of its own resolution, before that changes).
struct LevelRows {
  Rows in, out;
  std::int64_t height = 0;  ///< Of the whole picture at this level.
};
struct BandRows {
  BandLines lines;  ///< Of the first level's input: latents for the decoder, pictures for the encoder.
  std::vector<LevelRows> levels;
};

/// Bands of the decoder, at most `most`, from the top; levels coarsest first. The first band has more of the coarse
/// rows and fewer of the pictures'. Low pictures have fewer bands: each makes a row of pictures.
std::vector<BandRows> decoder_bands(const VaeConfig& config, std::int64_t latent_height, int most);
/// Bands of the encoder, each of 8 rows of pictures at least; levels finest first. The last band has more of the coarse
/// rows.
std::vector<BandRows> encoder_bands(const VaeConfig& config, std::int64_t latent_height, int most);

}  // namespace uwv::model
