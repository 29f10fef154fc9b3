// SPDX-License-Identifier: Apache-2.0
#include "model/layers/token_kernels.h"

#include <ATen/ATen.h>
#include <ATen/Parallel.h>

#include <atomic>
#include <cmath>
#include <vector>

#include "model/layers/row_arithmetic.h"
#include "model/layers/token_formulas.h"
#include "uwv/core/error.h"

namespace uwv::model {
namespace {

/// Rows a thread takes at once.
constexpr std::int64_t grain = 16;

/// The rows of a float32 or bfloat16 tensor, read and written as float32.
class Rows {
 public:
  explicit Rows(const at::Tensor& x)
      : n_(static_cast<std::size_t>(x.size(-1))), wide_(x.scalar_type() == at::kFloat), data_(x.mutable_data_ptr()) {
    require(x.is_contiguous() && (wide_ || x.scalar_type() == at::kBFloat16),
            "rows are of type {}, wanted contiguous float32 or bfloat16", at::toString(x.scalar_type()));
  }

  /// The row itself where it is float32, else its numbers in `room`.
  float* read(std::int64_t row, std::vector<float>& room) const {
    if (wide_) return floats() + offset(row);
    room.resize(n_);
    row::widen(halves() + offset(row), n_, room.data());
    return room.data();
  }

  /// Where to put the numbers of a row before write().
  float* place(std::int64_t row, std::vector<float>& room) const {
    if (wide_) return floats() + offset(row);
    room.resize(n_);
    return room.data();
  }

  /// Takes the numbers that read() or place() gave room for.
  void write(std::int64_t row, const float* numbers) const {
    if (!wide_) row::narrow(numbers, n_, halves() + offset(row));
  }

  std::size_t size() const { return n_; }

 private:
  std::size_t offset(std::int64_t row) const { return static_cast<std::size_t>(row) * n_; }
  float* floats() const { return static_cast<float*>(data_); }
  std::uint16_t* halves() const { return static_cast<std::uint16_t*>(data_); }

  std::size_t n_;
  bool wide_;
  void* data_;
};

/// Numbers per channel that are the same for every batch item or not, (batch or 1, dim).
class PerBatch {
 public:
  PerBatch(const at::Tensor& values, std::int64_t rows_per_item)
      : values_(values.contiguous()),
        rows_(rows_per_item),
        stride_(values.dim() < 2 || values.size(0) == 1 ? 0 : values.size(-1)) {}
  const float* of(std::int64_t row) const { return values_.const_data_ptr<float>() + row / rows_ * stride_; }

 private:
  at::Tensor values_;
  std::int64_t rows_, stride_;
};

std::int64_t row_count(const at::Tensor& x) { return x.size(-1) == 0 ? 0 : x.numel() / x.size(-1); }

std::int64_t rows_per_item(const at::Tensor& x) { return std::max<std::int64_t>(1, x.size(-2)); }

}  // namespace

at::Tensor layer_norm(const at::Tensor& x, const at::Tensor& scale, const at::Tensor& shift, double eps,
                      at::ScalarType type) {
  if (!x.is_cpu()) return formula::layer_norm(x, scale, shift, eps, type);
  const at::Tensor result = at::empty(x.sizes(), x.options().dtype(type));
  const Rows from(x), to(result);
  const PerBatch scales(scale, rows_per_item(x)), shifts(shift, rows_per_item(x));
  const std::size_t n = from.size();
  at::parallel_for(0, row_count(x), grain, [&](std::int64_t begin, std::int64_t end) {
    std::vector<float> room, place;
    for (std::int64_t r = begin; r < end; ++r) {
      const float* row = from.read(r, room);
      const float centre = row::mean(row, n);
      const float factor = 1.0F / std::sqrt(row::mean_square(row, n, centre) + static_cast<float>(eps));
      float* out = to.place(r, place);
      row::modulate(row, n, centre, factor, scales.of(r), shifts.of(r), out);
      to.write(r, out);
    }
  });
  return result;
}

void add_gated(const at::Tensor& x, const at::Tensor& y, const at::Tensor& gate) {
  require(x.sizes() == y.sizes() && x.scalar_type() == at::kFloat, "a residual of {} values is added to {} values",
          y.numel(), x.numel());
  if (!x.is_cpu()) return formula::add_gated(x, y, gate);
  const Rows to(x), from(y);
  const PerBatch gates(gate.defined() ? gate : at::ones({1, 1}), rows_per_item(x));
  const std::size_t n = to.size();
  at::parallel_for(0, row_count(x), grain, [&](std::int64_t begin, std::int64_t end) {
    std::vector<float> room, none;
    for (std::int64_t r = begin; r < end; ++r) {
      const float* row = from.read(r, room);
      if (gate.defined())
        row::add_product(to.read(r, none), row, gates.of(r), n);
      else
        row::add(to.read(r, none), row, n);
    }
  });
}

void rms_norm_rotate(const at::Tensor& x, const at::Tensor& weight, double eps, const at::Tensor& cosine,
                     const at::Tensor& sine) {
  if (!x.is_cpu()) return formula::rms_norm_rotate(x, weight, eps, cosine, sine);
  const Rows rows(x);
  const std::size_t n = rows.size();
  const bool turn = cosine.defined();
  const std::int64_t pairs = turn ? cosine.size(-1) : 0, tokens = rows_per_item(x);
  require(!turn || cosine.size(0) == tokens, "{} tokens are to be turned by the angles of {}", tokens,
          turn ? cosine.size(0) : 0);
  const float* weights = weight.const_data_ptr<float>();
  const float* cosines = turn ? cosine.const_data_ptr<float>() : nullptr;
  const float* sines = turn ? sine.const_data_ptr<float>() : nullptr;
  at::parallel_for(0, row_count(x), grain, [&](std::int64_t begin, std::int64_t end) {
    std::vector<float> room;
    for (std::int64_t r = begin; r < end; ++r) {
      float* row = rows.read(r, room);
      row::scale_by(row, n, 1.0F / std::sqrt(row::mean_square(row, n, 0) + static_cast<float>(eps)), weights);
      const std::int64_t angle = r % tokens * pairs;
      for (std::size_t head = 0; turn && head < n; head += 2 * static_cast<std::size_t>(pairs))
        row::rotate(row + head, static_cast<std::size_t>(pairs), cosines + angle, sines + angle);
      rows.write(r, row);
    }
  });
}

std::pair<at::Tensor, at::Tensor> quantise_rows(const at::Tensor& x) {
  if (!x.is_cpu()) return formula::quantise_rows(x);
  const Rows rows(x);
  const std::size_t n = rows.size();
  at::Tensor numbers = at::empty(x.sizes(), x.options().dtype(at::kChar));
  at::Tensor scales = at::empty({row_count(x)}, x.options().dtype(at::kFloat));
  auto* out = numbers.mutable_data_ptr<std::int8_t>();
  auto* scale = scales.mutable_data_ptr<float>();
  at::parallel_for(0, row_count(x), grain, [&](std::int64_t begin, std::int64_t end) {
    std::vector<float> room;
    for (std::int64_t r = begin; r < end; ++r) {
      const float* row = rows.read(r, room);
      const float most = row::largest(row, n);
      scale[r] = most / 127.0F;
      row::round_to_i8(row, n, most > 0 ? 127.0F / most : 0.0F, out + static_cast<std::size_t>(r) * n);
    }
  });
  return {numbers, scales};
}

void scale_rows(const at::Tensor& y, const at::Tensor& scales, const at::Tensor& bias) {
  if (!y.is_cpu()) return formula::scale_rows(y, scales, bias);
  const Rows rows(y);
  const std::size_t n = rows.size();
  const at::Tensor added = bias.defined() ? bias : at::zeros({y.size(-1)}, y.options().dtype(at::kFloat));
  const float* biases = added.const_data_ptr<float>();
  const float* factors = scales.const_data_ptr<float>();
  at::parallel_for(0, row_count(y), grain, [&](std::int64_t begin, std::int64_t end) {
    std::vector<float> room;
    for (std::int64_t r = begin; r < end; ++r) {
      float* row = rows.read(r, room);
      row::scale_and_add(row, n, factors[r], biases);
      rows.write(r, row);
    }
  });
}

bool all_finite(const at::Tensor& x) {
  if (!x.is_cpu()) return formula::all_finite(x);
  const Rows rows(x);
  const std::size_t n = rows.size();
  std::atomic<bool> finite{true};
  at::parallel_for(0, row_count(x), grain, [&](std::int64_t begin, std::int64_t end) {
    std::vector<float> room;
    for (std::int64_t r = begin; r < end; ++r)
      if (!std::isfinite(row::mean(rows.read(r, room), n))) finite = false;
  });
  return finite;
}

}  // namespace uwv::model
