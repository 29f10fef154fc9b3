// SPDX-License-Identifier: Apache-2.0
#include "model/vae/winograd_conv.h"

#include <ATen/ATen.h>
#include <ATen/Parallel.h>

#include <algorithm>

#include "model/vae/winograd_kernel.h"

namespace uwv::model::winograd {
namespace {

/// Numbers the tiles that go through matrix products together are transformed to, about: enough rows for the products
/// to run at full speed, few enough for the caches.
constexpr std::int64_t block_numbers = 2'000'000;
constexpr std::int64_t fewest_tiles = 48, most_tiles = 192;
/// Below so many pixels, transforming the weights takes longer than the products saved.
constexpr std::int64_t fewest_pixels = 1024;
/// Tiles a processor is bothered with at least.
constexpr std::int64_t least_share = 8;
/// Between planes: multiples of a page apart, all of a tile's numbers would fall on the same lines of the cache.
constexpr std::int64_t gap = 16;

/// One matrix a point.
at::Tensor planes(const FramePool& pool, std::int64_t rows, std::int64_t columns) {
  const std::int64_t plane = rows * columns + gap;
  return pool.take_briefly(points * plane).as_strided({points, rows, columns}, {plane, columns, 1});
}

/// The first `rows` rows of each plane, as close together as if there were no more.
at::Tensor first_rows(const at::Tensor& whole, std::int64_t rows) {
  const std::int64_t columns = whole.size(2);
  return whole.as_strided({points, rows, columns}, {rows * columns + gap, columns, 1});
}

Planes from_column(const at::Tensor& matrices, std::int64_t column) {
  return {matrices.data_ptr<float>() + column, matrices.stride(0), matrices.stride(1)};
}

/// One call of convolve().
struct Job {
  const FramePool& pool;
  const std::vector<Term>& terms;
  bool doubled = false;
  TileRun whole;
  std::vector<float> zeros;

  std::int64_t channels() const { return terms[0].weight.size(1); }
  std::int64_t outputs() const { return terms[0].weight.size(0); }
};

/// Calls work(tiles, first of them within the block) for every processor's share of a block's tiles.
template <class Work>
void share(const TileRun& block, const Work& work) {
  at::parallel_for(0, block.count, least_share, [&](std::int64_t begin, std::int64_t end) {
    TileRun tiles = block;
    tiles.first += begin;
    tiles.count = end - begin;
    work(tiles, begin);
  });
}

/// Of terms [first, first + count), below one another.
at::Tensor transformed_weights(const Job& job, std::size_t first, std::size_t count) {
  const std::int64_t outputs = job.outputs(), channels = job.channels();
  at::Tensor all = planes(job.pool, channels * static_cast<std::int64_t>(count), outputs);
  for (std::size_t i = 0; i < count; ++i) {
    Planes to = from_column(all, 0);
    to.to += static_cast<std::int64_t>(i) * channels * outputs;
    const float* const from = job.terms[first + i].weight.data_ptr<float>();
    at::parallel_for(0, channels, 16, [&](std::int64_t begin, std::int64_t end) {
      transform_weight(from, channels, outputs, begin, end, to);
    });
  }
  return all;
}

/// What terms [first, first + count) see of a block's tiles, side by side.
void transform_block(const Job& job, const TileRun& block, std::size_t first, std::size_t count,
                     const at::Tensor& seen) {
  share(block, [&](const TileRun& tiles, std::int64_t row) {
    for (std::size_t i = 0; i < count; ++i) {
      Planes to = from_column(seen, static_cast<std::int64_t>(i) * job.channels());
      to.to += row * to.row;
      transform_frame(job.terms[first + i].frame.data_ptr<float>(), job.doubled, job.channels(), job.zeros.data(),
                      tiles, to);
    }
  });
}

/// `products` hold the block's tiles.
void finish(const TileRun& block, const at::Tensor& products, const at::Tensor& bias, bool add, at::Tensor& sum) {
  share(block, [&](const TileRun& tiles, std::int64_t row) {
    transform_sums(products.data_ptr<float>() + row * products.stride(1), products.stride(0), products.size(2),
                   bias.defined() ? bias.data_ptr<float>() : nullptr, add, tiles, sum.data_ptr<float>());
  });
}

/// Term by term, so that only one term's transformed weights are held: the products of all tiles wait instead.
void convolve_few_tiles(const Job& job, const at::Tensor& bias, bool add, at::Tensor& sum, std::int64_t block_tiles) {
  TileRun all = job.whole;
  all.count = all.all();
  at::Tensor products;
  for (std::size_t term = 0; term < job.terms.size(); ++term) {
    const at::Tensor weights = transformed_weights(job, term, 1);
    const at::Tensor all_seen = planes(job.pool, block_tiles, job.channels());
    if (term == 0) products = planes(job.pool, all.count, job.outputs());
    for (TileRun block = job.whole; block.first < all.count; block.first += block_tiles) {
      block.count = std::min(block_tiles, all.count - block.first);
      const at::Tensor seen = first_rows(all_seen, block.count);
      transform_block(job, block, term, 1, seen);
      at::Tensor made = products.narrow(1, block.first, block.count);
      if (term == 0)
        at::bmm_out(made, seen, weights);
      else
        made.baddbmm_(seen, weights);
    }
  }
  finish(all, products, bias, add, sum);
}

/// All terms at once, block by block.
void convolve_blocks(const Job& job, const at::Tensor& bias, bool add, at::Tensor& sum, std::int64_t block_tiles) {
  const std::size_t terms = job.terms.size();
  const at::Tensor weights = transformed_weights(job, 0, terms);
  const at::Tensor all_seen = planes(job.pool, block_tiles, job.channels() * static_cast<std::int64_t>(terms));
  const at::Tensor all_products = planes(job.pool, block_tiles, job.outputs());
  for (TileRun block = job.whole; block.first < block.all(); block.first += block_tiles) {
    block.count = std::min(block_tiles, block.all() - block.first);
    const at::Tensor seen = first_rows(all_seen, block.count);
    transform_block(job, block, 0, terms, seen);
    at::Tensor products = first_rows(all_products, block.count);
    at::bmm_out(products, seen, weights);
    finish(block, products, bias, add, sum);
  }
}

std::int64_t tiles_of_a_block(std::int64_t depth, std::int64_t all) {
  return std::min(all, std::clamp(block_numbers / (points * depth), fewest_tiles, most_tiles));
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

void convolve(const FramePool& pool, at::Tensor& sum, const std::vector<Term>& terms, const at::Tensor& bias, bool add,
              bool doubled, std::int64_t above) {
  const std::int64_t channels = terms[0].weight.size(1);
  const Job job{pool,
                terms,
                doubled,
                {sum.size(0), sum.size(1), (doubled ? 2 : 1) * terms[0].frame.size(0), above},
                std::vector<float>(static_cast<std::size_t>(channels))};
  const std::int64_t tiles = job.whole.all();
  if (tiles <= channels)
    convolve_few_tiles(job, bias, add, sum, tiles_of_a_block(channels, tiles));
  else
    convolve_blocks(job, bias, add, sum, tiles_of_a_block(channels * static_cast<std::int64_t>(terms.size()), tiles));
}

}  // namespace uwv::model::winograd
