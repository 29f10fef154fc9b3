// SPDX-License-Identifier: Apache-2.0
#include "model/vae/winograd_conv.h"

#include <ATen/ATen.h>
#include <ATen/Parallel.h>

#include <algorithm>

#include "model/vae/winograd_kernel.h"

namespace uwv::model::winograd {
namespace {

/// Tiles that go through matrix products together: enough rows for the products to run at full speed, few enough for
/// the second-level cache. Blocks do not depend on the number of threads, nor does then any bit of the result.
constexpr std::int64_t block_tiles = 96;
/// Below so many pixels, transforming the weights takes longer than the products saved.
constexpr std::int64_t fewest_pixels = 1024;
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
  const std::int64_t blocks = (whole.all() + block_tiles - 1) / block_tiles;
  at::parallel_for(0, blocks, 1, [&](std::int64_t begin, std::int64_t end) {
    const c10::InferenceMode inference;
    const at::Tensor all_seen = planes(block_tiles, depth), all_products = planes(block_tiles, outputs);
    for (std::int64_t block = begin; block < end; ++block) {
      TileRun tiles = whole;
      tiles.first = block * block_tiles;
      tiles.count = std::min(block_tiles, whole.all() - tiles.first);
      const at::Tensor seen = first_rows(all_seen, tiles.count);
      for (std::size_t i = 0; i < terms.size(); ++i)
        transform_frame(terms[i].frame.data_ptr<float>(), doubled, channels, zeros.data(), tiles,
                        from_column(seen, static_cast<std::int64_t>(i) * channels));
      at::Tensor products = first_rows(all_products, tiles.count);
      at::bmm_out(products, seen, weights);
      transform_sums(products.data_ptr<float>(), products.stride(0), outputs,
                     bias.defined() ? bias.data_ptr<float>() : nullptr, add, tiles, sum.data_ptr<float>());
    }
  });
}

double scratch_bytes(std::int64_t terms, std::int64_t channels, std::int64_t outputs, int threads) {
  const double depth = static_cast<double>(terms * channels), wide = static_cast<double>(outputs);
  return 4.0 * points * (depth * wide + threads * static_cast<double>(block_tiles) * (depth + wide));
}

}  // namespace uwv::model::winograd
