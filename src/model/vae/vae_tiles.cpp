// SPDX-License-Identifier: Apache-2.0
#include "model/vae/vae_tiles.h"

#include <ATen/ATen.h>

#include <algorithm>
#include <vector>

namespace uwv::model {
namespace {

constexpr std::int64_t row_axis = 3, column_axis = 4;

Rows part(std::int64_t number, std::int64_t size, const TileGrid& grid) {
  return {number * grid.stride, std::min(size, number * grid.stride + grid.tile)};
}

/// The last values along `axis`, at most `most` of them, without the tile they belong to.
at::Tensor end_of(const at::Tensor& tile, std::int64_t axis, std::int64_t most) {
  const std::int64_t count = std::min(most, tile.size(axis));
  return tile.narrow(axis, tile.size(axis) - count, count).clone();
}

/// Blends the end of the tile before into the beginning of this one.
void blend(const at::Tensor& end, at::Tensor& tile, std::int64_t axis) {
  const std::int64_t count = std::min(end.size(axis), tile.size(axis));
  if (count == 0) return;
  std::vector<std::int64_t> shape(5, 1);
  shape[static_cast<std::size_t>(axis)] = count;
  const at::Tensor weight = at::arange(count, at::TensorOptions(at::kFloat)).div_(count).view(shape);
  at::Tensor beginning = tile.narrow(axis, 0, count);
  beginning.copy_(at::lerp(end.narrow(axis, end.size(axis) - count, count), beginning, weight));
}

}  // namespace

at::Tensor blended_tiles(const TileGrid& grid, const std::function<at::Tensor(Rows rows, Rows columns)>& make) {
  const std::int64_t overlap = (grid.tile - grid.stride) * grid.scale, step = grid.stride * grid.scale;
  at::Tensor whole;
  std::vector<at::Tensor> above(static_cast<std::size_t>(grid.columns()));
  for (std::int64_t i = 0; i < grid.rows(); ++i) {
    at::Tensor left;
    for (std::int64_t j = 0; j < grid.columns(); ++j) {
      at::Tensor tile = make(part(i, grid.height, grid), part(j, grid.width, grid));
      at::Tensor& upper = above[static_cast<std::size_t>(j)];
      if (i > 0) blend(upper, tile, row_axis);
      if (j > 0) blend(left, tile, column_axis);
      upper = end_of(tile, row_axis, overlap);
      left = end_of(tile, column_axis, overlap);
      if (!whole.defined())
        whole = at::empty({1, tile.size(1), tile.size(2), grid.height * grid.scale, grid.width * grid.scale},
                          tile.options());
      const std::int64_t rows = std::min(step, tile.size(row_axis)), columns = std::min(step, tile.size(column_axis));
      whole.narrow(row_axis, i * step, rows)
          .narrow(column_axis, j * step, columns)
          .copy_(tile.narrow(row_axis, 0, rows).narrow(column_axis, 0, columns));
    }
  }
  return whole;
}

}  // namespace uwv::model
