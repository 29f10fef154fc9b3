// SPDX-License-Identifier: Apache-2.0
// Pictures in overlapping tiles that are blended into one another: memory and the attention's cost no longer grow with
// the picture, but tiles do not see one another, so the result is near that of one piece, not equal to it. (Bands of
// rows are exact; see row_bands.h.) Sheet model.md, 7 ("Tiling"): the same tiles and the same blend.
#pragma once

#include <ATen/core/Tensor.h>

#include <functional>

#include "model/vae/row_bands.h"

namespace uwv::model {

/// All but `scale` in latents.
struct TileGrid {
  std::int64_t height = 0, width = 0;
  std::int64_t tile = 0, stride = 0;  ///< 0 < stride <= tile.
  std::int64_t scale = 1;             ///< Values of the result per latent, each way: 1 or 8.

  /// A picture that fits into one tile is not cut.
  bool is_cut() const { return height > tile || width > tile; }
  std::int64_t rows() const { return (height + stride - 1) / stride; }
  std::int64_t columns() const { return (width + stride - 1) / stride; }
};

/// `make` gives a tile (1, C, T, scale * rows, scale * columns); the answer is (1, C, T, scale * height, ...). Where
/// tiles overlap, the weight of the later one rises in a line.
at::Tensor blended_tiles(const TileGrid& grid, const std::function<at::Tensor(Rows rows, Rows columns)>& make);

}  // namespace uwv::model
