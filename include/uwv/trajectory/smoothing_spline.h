// SPDX-License-Identifier: Apache-2.0
// A cubic spline that smooths its data just enough: the least bending whose squared residuals sum to a given bound.
//
// The official trajectories smooth lists of angles with FITPACK's curve fitting (P. Dierckx, "An algorithm for
// smoothing, differentiation and integration of experimental data using spline functions", J. Comp. Appl. Math. 1,
// 1975; "Curve and Surface Fitting with Splines", Oxford 1993, ch. 5), called through scipy's UnivariateSpline. To give
// the same cameras, this follows the same published strategy: where knots go, how many at once, and when the search for
// the smoothing parameter stops. Results agree with scipy to about 1e-12 on lists in degrees.
#pragma once

#include <span>
#include <vector>

namespace uwv {

/// A cubic spline in B-spline form on [knots.front(), knots.back()].
struct CubicSpline {
  std::vector<double> knots;         ///< Non-decreasing; both ends occur four times. Holds coefficients.size() + 4.
  std::vector<double> coefficients;  ///< One per B-spline.
  double residual = 0;               ///< Sum of squared distances from the data it was fitted to.

  /// The value at x. Outside the knots' range the end pieces are continued.
  double operator()(double x) const;
  /// The distinct knots inside the range, without its ends.
  std::span<const double> interior_knots() const { return {knots.data() + 4, knots.size() - 8}; }
};

struct SmoothingOptions {
  double smoothing = -1;    ///< Bound on the sum of squared residuals, > 0; negative = the number of points (scipy).
  double tolerance = 1e-3;  ///< The residual may miss `smoothing` by this share; FITPACK's value. In (0, 1).
  int max_iterations = 20;  ///< Of the search for the smoothing parameter; FITPACK's value. At least 1.

  void check() const;
};

/// Fits y over x. `x` has at least 4 strictly increasing values, `y` as many; all finite. Throws std::invalid_argument
/// otherwise. Takes O(points * knots) time per round, and at most about log2(points) rounds.
CubicSpline smoothing_spline(std::span<const double> x, std::span<const double> y,
                             const SmoothingOptions& options = {});

}  // namespace uwv
