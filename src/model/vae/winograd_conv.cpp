// SPDX-License-Identifier: Apache-2.0
#include "model/vae/winograd_conv.h"

#include <ATen/ATen.h>
#include <ATen/Parallel.h>

#include <algorithm>

#include "model/vae/winograd_kernel.h"

namespace uwv::model::winograd {
namespace {

/// Tiles that go through matrix products together: enough rows for the products to run at full speed, few enough for
/// the caches.
constexpr std::int64_t block_tiles = 192;
/// Below so many pixels, transforming the weights takes longer than the products saved.
constexpr std::int64_t fewest_pixels = 1024;
/// Tiles a processor is bothered with at least.
constexpr std::int64_t least_share = 8;
/// Between planes: multiples of a page apart, all of a tile's numbers would fall on the same lines of the cache.
constexpr std::int64_t gap = 16;

/// One matrix a point, in memory that is theirs alone.
at::Tensor planes(std::int64_t rows, std::int64_t columns) {
  const std::int64_t plane = rows * columns + gap;
  return at::empty({points * plane}, at::kFloat).as_strided({points, rows, columns}, {plane, columns, 1});
}

/// The first `rows` rows of each plane, as close together as if there were no more.
at::Tensor first_rows(const at::Tensor& whole, std::int64_t rows) {
  const std::int64_t columns = whole.size(2);
  return whole.as_strided({points, rows, columns}, {rows * columns + gap, columns, 1});
}

Planes from_column(const at::Tensor& matrices, std::int64_t column) {
  return {matrices.data_ptr<float>() + column, matrices.stride(0), matrices.stride(1)};
}

at::Tensor transformed_weights(const std::vector<Term>& terms) {
  const std::int64_t outputs = terms[0].weight.size(0), channels = terms[0].weight.size(1);
  at::Tensor all = planes(channels * static_cast<std::int64_t>(terms.size()), outputs);
  for (std::size_t i = 0; i < terms.size(); ++i) {
    Planes to = from_column(all, 0);
    to.to += static_cast<std::int64_t>(i) * channels * outputs;
    const float* const from = terms[i].weight.data_ptr<float>();
    at::parallel_for(0, channels, 16, [&](std::int64_t begin, std::int64_t end) {
      transform_weight(from, channels, outputs, begin, end, to);
    });
  }
  return all;
}

}  // namespace

at::Tensor laid_out(const at::Tensor& weight) {
  return weight.permute({2, 3, 1, 0}).contiguous().permute({3, 2, 0, 1});
}

bool pays(std::int64_t pixels) { return pixels >= fewest_pixels; }

bool takes(const at::Tensor& weight) {
  return weight.is_cpu() && weight.scalar_type() == at::kFloat && weight.size(2) == 3 && weight.size(3) == 3 &&
         weight.size(0) % channel_step == 0 && weight.size(1) % channel_step == 0;
}

void convolve(at::Tensor& sum, const std::vector<Term>& terms, const at::Tensor& bias, bool add, bool doubled,
              std::int64_t above) {
  const std::int64_t outputs = sum.size(2), channels = terms[0].weight.size(1);
  const std::int64_t depth = channels * static_cast<std::int64_t>(terms.size());
  const TileRun whole{sum.size(0), sum.size(1), (doubled ? 2 : 1) * terms[0].frame.size(0), above};
  const at::Tensor weights = transformed_weights(terms);
  const std::vector<float> zeros(static_cast<std::size_t>(channels));
  const at::Tensor all_seen = planes(block_tiles, depth), all_products = planes(block_tiles, outputs);
  // What every processor does with its share of a block's tiles.
  const auto share = [](const TileRun& block, const auto& work) {
    at::parallel_for(0, block.count, least_share, [&](std::int64_t begin, std::int64_t end) {
      TileRun tiles = block;
      tiles.first += begin;
      tiles.count = end - begin;
      work(tiles, begin);
    });
  };
  for (TileRun block = whole; block.first < whole.all(); block.first += block_tiles) {
    block.count = std::min(block_tiles, whole.all() - block.first);
    const at::Tensor seen = first_rows(all_seen, block.count);
    share(block, [&](const TileRun& tiles, std::int64_t row) {
      for (std::size_t i = 0; i < terms.size(); ++i) {
        Planes to = from_column(seen, static_cast<std::int64_t>(i) * channels);
        to.to += row * to.row;
        transform_frame(terms[i].frame.data_ptr<float>(), doubled, channels, zeros.data(), tiles, to);
      }
    });
    at::Tensor products = first_rows(all_products, block.count);
    at::bmm_out(products, seen, weights);
    share(block, [&](const TileRun& tiles, std::int64_t row) {
      transform_sums(products.data_ptr<float>() + row * outputs, products.stride(0), outputs,
                     bias.defined() ? bias.data_ptr<float>() : nullptr, add, tiles, sum.data_ptr<float>());
    });
  }
}

}  // namespace uwv::model::winograd
