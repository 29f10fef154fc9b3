// SPDX-License-Identifier: Apache-2.0
// Least squares with a banded matrix, one equation at a time: an upper triangular band kept up to date by Givens
// rotations (Golub & Van Loan, "Matrix Computations", sec. 5.1 and 5.2).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <vector>

namespace uwv::detail {

class BandTriangle {
 public:
  /// The widest equation: a jump of the third derivative involves five cubic B-splines.
  static constexpr std::size_t width = 5;

  explicit BandTriangle(std::size_t unknowns) : rows_(unknowns), right_(unknowns, 0.0) {}

  /// Takes in  sum_j row[j] * unknown[first + j] = right.  Returns what is left of the right side after elimination;
  /// its square is this equation's share of the sum of squared residuals.
  double absorb(std::size_t first, std::span<const double> row, double right) {
    Row incoming{};
    for (std::size_t j = 0; j < row.size(); ++j) incoming[j] = row[j];
    const auto is_zero = [](double value) { return value == 0; };
    for (std::size_t i = first; i < rows_.size() && !std::all_of(incoming.begin(), incoming.end(), is_zero); ++i) {
      if (incoming[0] != 0) right = rotate(i, incoming, right);
      for (std::size_t j = 1; j < width; ++j) incoming[j - 1] = incoming[j];
      incoming[width - 1] = 0;
    }
    return right;
  }

  /// The solution; an unknown that no equation determines is 0.
  std::vector<double> solve() const {
    const std::size_t n = rows_.size();
    std::vector<double> unknowns(n, 0.0);
    for (std::size_t i = n; i-- > 0;) {
      double value = right_[i];
      for (std::size_t j = 1; j < width && i + j < n; ++j) value -= rows_[i][j] * unknowns[i + j];
      unknowns[i] = rows_[i][0] != 0 ? value / rows_[i][0] : 0.0;
    }
    return unknowns;
  }

  /// The sum of the triangle's diagonal, which the rotations keep non-negative.
  double trace() const {
    double sum = 0;
    for (const Row& row : rows_) sum += row[0];
    return sum;
  }

 private:
  using Row = std::array<double, width>;

  /// Zeroes incoming[0] against row i and returns the rotated right side.
  double rotate(std::size_t i, Row& incoming, double right) {
    Row& row = rows_[i];
    const double length = std::hypot(row[0], incoming[0]);
    const double c = row[0] / length;
    const double s = incoming[0] / length;
    for (std::size_t j = 0; j < width; ++j) {
      const double kept = row[j];
      row[j] = c * kept + s * incoming[j];
      incoming[j] = c * incoming[j] - s * kept;
    }
    const double kept = right_[i];
    right_[i] = c * kept + s * right;
    return c * right - s * kept;
  }

  std::vector<Row> rows_;
  std::vector<double> right_;
};

}  // namespace uwv::detail
