// SPDX-License-Identifier: Apache-2.0
#include "uwv/trajectory/smoothing_spline.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "trajectory/band_triangle.h"
#include "uwv/core/error.h"

namespace uwv {
namespace {

using detail::BandTriangle;
constexpr std::size_t order = 4;  // of a cubic B-spline: coefficients per point, and knots that coincide at each end

/// The index k of the piece [knots[k], knots[k+1]) that holds x, the last piece being closed.
std::size_t piece_of(const std::vector<double>& knots, double x) {
  const auto first = knots.begin() + order;
  const auto last = knots.end() - order;
  return static_cast<std::size_t>(std::upper_bound(first, last, x) - knots.begin()) - 1;
}

/// The four B-splines that are not zero on piece k, at x: Cox and de Boor's recurrence.
std::array<double, order> basis(const std::vector<double>& knots, std::size_t k, double x) {
  std::array<double, order> value{1, 0, 0, 0};
  for (std::size_t degree = 1; degree < order; ++degree) {
    double carried = 0;
    for (std::size_t j = 0; j < degree; ++j) {
      const double right = knots[k + j + 1];
      const double left = knots[k + j + 1 - degree];
      const double share = value[j] / (right - left);
      value[j] = carried + share * (right - x);
      carried = share * (x - left);
    }
    value[degree] = carried;
  }
  return value;
}

struct Data {
  std::span<const double> x, y;
  std::size_t size() const { return x.size(); }
};

struct Fit {
  CubicSpline spline;
  BandTriangle triangle;
};

Fit least_squares(const Data& data, const std::vector<double>& knots) {
  Fit fit{{knots, {}, 0}, BandTriangle(knots.size() - order)};
  for (std::size_t i = 0; i < data.size(); ++i) {
    const std::size_t k = piece_of(knots, data.x[i]);
    const double left = fit.triangle.absorb(k - (order - 1), basis(knots, k, data.x[i]), data.y[i]);
    fit.spline.residual += left * left;
  }
  fit.spline.coefficients = fit.triangle.solve();
  return fit;
}

double squared_error(const CubicSpline& spline, const Data& data, std::size_t i) {
  const double error = spline(data.x[i]) - data.y[i];
  return error * error;
}

/// The knots while they are being placed. Every interior knot is a data point; between two neighbours lie `inside`
/// more.
class KnotPlacement {
 public:
  explicit KnotPlacement(const Data& data) : data_(data), intervals_{{data.size() - 2, 0.0}} {
    knots_.assign(order, data.x.front());
    knots_.insert(knots_.end(), order, data.x.back());
  }

  const std::vector<double>& knots() const { return knots_; }

  /// Shares the squared errors out to the intervals; a point on a knot gives half to either side.
  void measure(const CubicSpline& spline) {
    std::size_t i = 0;
    for (std::size_t k = 0; k < intervals_.size(); ++k) {
      double sum = k == 0 ? squared_error(spline, data_, 0) : 0.5 * squared_error(spline, data_, i);
      for (std::size_t inside = 0; inside < intervals_[k].inside; ++inside) sum += squared_error(spline, data_, ++i);
      ++i;
      const bool last = k + 1 == intervals_.size();
      intervals_[k].residual = sum + (last ? 1.0 : 0.5) * squared_error(spline, data_, i);
    }
  }

  /// A knot goes to the middle point of the interval with the largest residual among those that still hold a point.
  /// The two halves share the residual in proportion to their points until the next measurement. False when none is
  /// left.
  bool split_worst() {
    std::size_t worst = intervals_.size();
    std::size_t worst_begin = 0;
    double largest = 0;
    std::size_t begin = 0;
    for (std::size_t k = 0; k < intervals_.size(); ++k) {
      if (intervals_[k].inside > 0 && intervals_[k].residual > largest) {
        largest = intervals_[k].residual;
        worst = k;
        worst_begin = begin;
      }
      begin += intervals_[k].inside + 1;
    }
    if (worst == intervals_.size()) return false;

    const std::size_t inside = intervals_[worst].inside;
    const std::size_t half = inside / 2 + 1;
    const double per_point = largest / static_cast<double>(inside);
    const Interval left{half - 1, per_point * static_cast<double>(half - 1)};
    const Interval right{inside - half, per_point * static_cast<double>(inside - half)};
    const auto at = static_cast<std::ptrdiff_t>(worst);
    intervals_[worst] = left;
    intervals_.insert(intervals_.begin() + at + 1, right);
    knots_.insert(knots_.begin() + static_cast<std::ptrdiff_t>(order) + at, data_.x[worst_begin + half]);
    return true;
  }

  /// As many knots as an interpolating spline has: every point but the second and the last but one ("not a knot").
  void interpolate() {
    knots_.assign(order, data_.x.front());
    knots_.insert(knots_.end(), data_.x.begin() + 2, data_.x.end() - 2);
    knots_.insert(knots_.end(), order, data_.x.back());
  }

 private:
  struct Interval {
    std::size_t inside;  ///< Data points strictly between its two knots.
    double residual;
  };

  Data data_;
  std::vector<double> knots_;
  std::vector<Interval> intervals_;
};

/// How many knots to add after a fit that was too loose: as many as the last ones' success suggests, at least half and
/// at most twice as many as last time.
std::size_t next_step(std::size_t step, double excess, double gained, double accepted) {
  std::size_t suggested = step * 2;
  if (gained > accepted) suggested = static_cast<std::size_t>(static_cast<double>(step) * excess / gained);
  return std::min(step * 2, std::max({suggested, step / 2, std::size_t{1}}));
}

/// Adds knots until the least-squares spline's residual is at most the bound. `polynomial` becomes the residual of the
/// first fit, which has no interior knot.
Fit place_knots(const Data& data, double bound, double accepted, double& polynomial) {
  KnotPlacement placement(data);
  const std::size_t all = data.size() + order;
  // scipy first gives the algorithm room for half as many knots as points, and when that is full goes on with room for
  // all, one knot at a time again. From 18 points on this changes which knots are chosen.
  std::size_t room = std::max(data.size() / 2, 2 * order);
  std::size_t step = 0;
  double previous = 0;
  while (true) {
    Fit fit = least_squares(data, placement.knots());
    const double residual = fit.spline.residual;
    const double excess = residual - bound;
    if (step == 0) polynomial = residual;
    if (std::abs(excess) < accepted || excess < 0 || placement.knots().size() == all) return fit;

    const bool room_was_full = placement.knots().size() == room;
    if (room_was_full) room = all;
    step = step == 0 || room_was_full ? 1 : next_step(step, excess, previous - residual, accepted);
    previous = residual;
    placement.measure(fit.spline);
    const std::size_t before = placement.knots().size();
    for (std::size_t added = 0; added < step && placement.knots().size() < room; ++added)
      if (!placement.split_worst()) break;
    if (placement.knots().size() == before) return fit;
    if (placement.knots().size() == all) placement.interpolate();
  }
}

/// The equation that says "the third derivative does not jump at interior knot l": its five coefficients, scaled by
/// the mean knot distance so that the smoothing parameter has no unit.
std::array<double, BandTriangle::width> jump(const std::vector<double>& knots, std::size_t l) {
  const std::size_t intervals = knots.size() - 2 * order + 1;
  const double scale = static_cast<double>(intervals) / (knots.back() - knots.front());
  std::array<double, BandTriangle::width> row{};
  for (std::size_t j = 0; j < row.size(); ++j) {
    const std::size_t from = l - order + j;
    const std::size_t to = from + order;
    double product = 1;
    for (std::size_t i = from; i <= to; ++i)
      if (i != l) product *= knots[l] - knots[i];
    row[j] = (knots[to] - knots[from]) / (product * scale * scale * scale);
  }
  return row;
}

/// The spline that minimises  residual + sum of squared jumps / parameter^2.
CubicSpline penalised(const Fit& fit, const Data& data, double parameter) {
  BandTriangle triangle = fit.triangle;
  const std::vector<double>& knots = fit.spline.knots;
  for (std::size_t l = order; l + order < knots.size(); ++l) {
    auto row = jump(knots, l);
    for (double& value : row) value /= parameter;
    triangle.absorb(l - order, row, 0);
  }
  CubicSpline spline{knots, triangle.solve(), 0};
  for (std::size_t i = 0; i < data.size(); ++i) spline.residual += squared_error(spline, data, i);
  return spline;
}

/// A smoothing parameter and the residual's distance from the bound that it gives.
struct Trial {
  double parameter, excess;
};

/// The zero of the rational function (u p + v) / (p + w) through three trials; high.parameter < 0 means infinity.
double rational_zero(const Trial& low, const Trial& mid, const Trial& high) {
  const double p1 = low.parameter, p2 = mid.parameter, p3 = high.parameter;
  const double f1 = low.excess, f2 = mid.excess, f3 = high.excess;
  if (p3 < 0) return (p1 * (f1 - f3) * f2 - p2 * (f2 - f3) * f1) / ((f1 - f2) * f3);
  const double h1 = f1 * (f2 - f3);
  const double h2 = f2 * (f3 - f1);
  const double h3 = f3 * (f1 - f2);
  return -(p1 * p2 * h3 + p2 * p3 * h1 + p3 * p1 * h2) / (p1 * h1 + p2 * h2 + p3 * h3);
}

/// Finds the parameter whose residual meets the bound. The residual falls from `polynomial` at 0 to the fit's at
/// infinity.
CubicSpline meet_bound(const Fit& fit, const Data& data, double bound, double accepted, double polynomial,
                       int max_iterations) {
  constexpr double far = 0.04;  // the factor by which a trial on the wrong side of everything is moved
  constexpr double near = 0.1;  // the share of the way back when that leaves the known range
  Trial low{0, polynomial - bound};
  Trial high{-1, fit.spline.residual - bound};
  const auto unknowns = static_cast<double>(fit.spline.coefficients.size());
  double parameter = unknowns / fit.triangle.trace();
  bool bounded_above = false;
  bool bounded_below = false;
  for (int iteration = 1;; ++iteration) {
    CubicSpline spline = penalised(fit, data, parameter);
    const Trial mid{parameter, spline.residual - bound};
    if (std::abs(mid.excess) < accepted || iteration == max_iterations) return spline;
    if (!bounded_above && mid.excess - high.excess <= accepted) {
      high = mid;
      parameter *= far;
      if (parameter <= low.parameter) parameter = (1 - near) * low.parameter + near * mid.parameter;
      continue;
    }
    if (mid.excess < 0) bounded_above = true;
    if (!bounded_below && low.excess - mid.excess <= accepted) {
      low = mid;
      parameter /= far;
      if (high.parameter >= 0 && parameter >= high.parameter)
        parameter = near * mid.parameter + (1 - near) * high.parameter;
      continue;
    }
    if (mid.excess > 0) bounded_below = true;
    if (mid.excess >= low.excess || mid.excess <= high.excess) return spline;  // rounding has the last word
    parameter = rational_zero(low, mid, high);
    (mid.excess < 0 ? high : low) = mid;
  }
}

}  // namespace

double CubicSpline::operator()(double x) const {
  const std::size_t k = piece_of(knots, x);
  const auto weights = basis(knots, k, x);
  double sum = 0;
  for (std::size_t j = 0; j < order; ++j) sum += weights[j] * coefficients[k - (order - 1) + j];
  return sum;
}

void SmoothingOptions::check() const {
  require(smoothing != 0 && std::isfinite(smoothing), "smoothing is {}; a positive number is wanted", smoothing);
  require(tolerance > 0 && tolerance < 1, "tolerance is {}; a value in (0, 1) is wanted", tolerance);
  require(max_iterations >= 1, "max_iterations is {}; at least 1 is wanted", max_iterations);
}

CubicSpline smoothing_spline(std::span<const double> x, std::span<const double> y, const SmoothingOptions& options) {
  options.check();
  require(x.size() == y.size(), "a spline over {} positions was given {} values", x.size(), y.size());
  require(x.size() >= order, "a smoothing spline needs at least {} points, {} were given", order, x.size());
  for (std::size_t i = 0; i < x.size(); ++i) {
    require(std::isfinite(x[i]) && std::isfinite(y[i]), "point {} of a spline is ({}, {})", i, x[i], y[i]);
    require(i == 0 || x[i - 1] < x[i], "positions of a spline must increase; {} is followed by {}", i ? x[i - 1] : 0.0,
            x[i]);
  }
  const Data data{x, y};
  const double bound = options.smoothing > 0 ? options.smoothing : static_cast<double>(x.size());
  const double accepted = options.tolerance * bound;
  double polynomial = 0;
  Fit fit = place_knots(data, bound, accepted, polynomial);
  const bool has_knots = !fit.spline.interior_knots().empty();
  if (!has_knots || fit.spline.residual - bound >= -accepted) return std::move(fit.spline);
  return meet_bound(fit, data, bound, accepted, polynomial, options.max_iterations);
}

}  // namespace uwv
