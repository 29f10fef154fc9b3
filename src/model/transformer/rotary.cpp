// SPDX-License-Identifier: Apache-2.0
#include "model/transformer/rotary.h"

#include <ATen/ATen.h>

#include <cmath>

namespace uwv::model {
namespace {

constexpr double base = 10000;

/// Angles of positions 0..count-1 along one axis, (count, channels / 2).
at::Tensor angles(std::int64_t count, int channels) {
  const auto doubles = at::TensorOptions(at::kDouble);
  const at::Tensor exponents = at::arange(0, channels, 2, doubles).div(channels);
  const at::Tensor frequencies = at::reciprocal(at::pow(at::scalar_tensor(base, doubles), exponents));
  return at::outer(at::arange(count, doubles), frequencies);
}

}  // namespace

RotaryTables rotary_tables(const TokenGrid& grid, int head_dim, c10::Device device) {
  const int side = 2 * (head_dim / 6), time = head_dim - 2 * side;
  const auto over_grid = [&](const at::Tensor& axis, at::IntArrayRef where) {
    std::vector<std::int64_t> shape(where.begin(), where.end());
    shape.push_back(axis.size(1));
    return axis.view(shape).expand({grid.frames, grid.rows, grid.columns, axis.size(1)});
  };
  const at::Tensor all = at::cat({over_grid(angles(grid.frames, time), {grid.frames, 1, 1}),
                                  over_grid(angles(grid.rows, side), {1, grid.rows, 1}),
                                  over_grid(angles(grid.columns, side), {1, 1, grid.columns})},
                                 -1)
                             .reshape({grid.tokens(), head_dim / 2});
  return {at::cos(all).to(at::kFloat).to(device), at::sin(all).to(at::kFloat).to(device)};
}

}  // namespace uwv::model
