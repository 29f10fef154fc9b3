// SPDX-License-Identifier: Apache-2.0
#include "uwv/trajectory/smoothing_spline.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "uwv/trajectory/orbit.h"

namespace uwv {
namespace {

std::vector<double> linspace(std::size_t n) {
  std::vector<double> x(n);
  for (std::size_t i = 0; i < n; ++i) x[i] = static_cast<double>(i) / static_cast<double>(n - 1);
  return x;
}

double squared_residuals(const CubicSpline& spline, const std::vector<double>& x, const std::vector<double>& y) {
  double sum = 0;
  for (std::size_t i = 0; i < x.size(); ++i) sum += (spline(x[i]) - y[i]) * (spline(x[i]) - y[i]);
  return sum;
}

TEST(SmoothingSpline, meets_the_bound_on_the_residual) {
  for (std::size_t n = 5; n <= 200; ++n) {
    const std::vector<double> x = linspace(n);
    std::vector<double> y;
    for (const double t : x) y.push_back(30 * std::sin(8 * t) + 20 * std::cos(19 * t * t));
    const CubicSpline spline = smoothing_spline(x, y);
    const double bound = static_cast<double>(n);
    EXPECT_NEAR(spline.residual, squared_residuals(spline, x, y), 1e-8 * bound) << n << " points";
    EXPECT_LE(spline.residual, 1.001 * bound) << n << " points";
    EXPECT_EQ(spline.knots.size(), spline.coefficients.size() + 4);
  }
}

TEST(SmoothingSpline, leaves_a_cubic_as_it_is) {
  const std::vector<double> x = linspace(25);
  std::vector<double> y;
  for (const double t : x) y.push_back(40 * t * t * t - 30 * t * t + 7 * t - 2);
  const CubicSpline spline = smoothing_spline(x, y);
  EXPECT_TRUE(spline.interior_knots().empty());
  for (std::size_t i = 0; i < x.size(); ++i) EXPECT_NEAR(spline(x[i]), y[i], 1e-10) << "x = " << x[i];
}

TEST(SmoothingSpline, interpolates_when_the_bound_is_tiny) {
  const std::vector<double> x = linspace(15);
  std::vector<double> y;
  for (const double t : x) y.push_back(20 * std::sin(9 * t));
  const CubicSpline spline = smoothing_spline(x, y, {.smoothing = 1e-9});
  for (std::size_t i = 0; i < x.size(); ++i) EXPECT_NEAR(spline(x[i]), y[i], 1e-4) << "x = " << x[i];
}

TEST(SmoothingSpline, is_twice_continuously_differentiable_at_its_knots) {
  const std::vector<double> x = linspace(13);
  const std::vector<double> y{0, -8, -12, -20, -17, -12, -5, -2, 1, 5, 3, 1, 0};
  const CubicSpline spline = smoothing_spline(x, y);
  ASSERT_FALSE(spline.interior_knots().empty());
  constexpr double h = 1e-5;
  for (const double knot : spline.interior_knots()) {
    const auto second = [&](double at) { return (spline(at - h) - 2 * spline(at) + spline(at + h)) / (h * h); };
    EXPECT_NEAR(second(knot - 2 * h), second(knot + 2 * h), 1.0) << "knot " << knot << ", curvature " << second(knot);
  }
}

// The reference sheet's coefficients of the second swing's tables: an independent record of scipy's result.
TEST(SmoothingSpline, reproduces_the_tabulated_swing) {
  const std::vector<double> keys{0, 5, 25, 30, 20, 10, 0};
  const CubicSpline spline = smoothing_spline(linspace(keys.size()), keys);
  const std::vector<double> wanted{-0.271506241645, -6.42412686405, 25.1257283541,
                                   35.4208735975,   3.39899369496,  0.288657498066};
  ASSERT_EQ(spline.coefficients.size(), wanted.size());
  for (std::size_t i = 0; i < wanted.size(); ++i) EXPECT_NEAR(spline.coefficients[i], wanted[i], 1e-9) << i;
}

// With 18 points and more, knots depend on how scipy grows its storage; values from scipy 1.17.1's UnivariateSpline.
TEST(SmoothingSpline, places_the_knots_of_long_lists_as_scipy_does) {
  struct Case {
    int points;
    double rate;
    std::size_t interior_knots;
    std::array<double, 4> values;  // at 0.1, 0.37, 0.5, 0.81
  };
  const std::vector<Case> cases{
      {18, 0.013, 2, {0.334035039777, 15.92821697996, 24.68071768507, 18.80089904508}},
      {19, 0.05, 9, {4.635875064471, 24.66766299327, -24.4530132745, -25.9385847396}},
      {24, 0.11, 19, {16.84092009993, 27.20092671703, 14.3424487911, 6.894341303087}},
      {25, 0.02, 6, {2.784423095708, 29.23213999754, 9.064989494219, 26.93556120853}},
      {30, 0.07, 22, {16.90190955134, 26.86871486193, 16.48769290048, -1.349055719907}},  // stops at max_iterations
      {40, 0.017, 14, {6.871060967672, -10.56931701745, 6.714174106577, -29.11821353345}},
      {61, 0.009, 17, {9.546985917831, -29.05491986298, 30.99571624627, 19.82792144199}},
      {120, 0.003, 22, {13.08050584939, -14.07639036294, -27.65471341016, 10.44015985911}},
      {200, 0.0007, 17, {7.659869504094, -16.40895759879, 19.11908349062, -17.76582785092}},
      {21, 1.3, 16, {-26.97253504566, 30.68883464165, -27.66004244471, -11.76325010018}},
      {50, 0.9, 45, {-13.34758646792, 8.678742823725, 3.995728915982, 19.56255897362}},
  };
  constexpr std::array<double, 4> places{0.1, 0.37, 0.5, 0.81};
  for (const Case& c : cases) {
    SCOPED_TRACE(c.points);
    std::vector<double> y;
    for (int i = 0; i < c.points; ++i) y.push_back(std::round(30 * std::sin(i * i * c.rate)));
    const CubicSpline spline = smoothing_spline(linspace(y.size()), y);
    EXPECT_EQ(spline.interior_knots().size(), c.interior_knots);
    for (std::size_t i = 0; i < places.size(); ++i) EXPECT_NEAR(spline(places[i]), c.values[i], 1e-7) << places[i];
  }
}

TEST(SmoothingSpline, refuses_what_it_cannot_fit) {
  const std::vector<double> x{0, 1, 2, 3};
  const std::vector<double> y{0, 1, 0, 1};
  EXPECT_THROW(smoothing_spline(std::vector<double>{0, 1, 2}, std::vector<double>{0, 1, 2}), std::invalid_argument);
  EXPECT_THROW(smoothing_spline(std::vector<double>{0, 1, 1, 3}, y), std::invalid_argument);
  EXPECT_THROW(smoothing_spline(x, std::vector<double>{0, 1, NAN, 1}), std::invalid_argument);
  EXPECT_THROW(smoothing_spline(x, y, {.tolerance = 0}), std::invalid_argument);
  EXPECT_THROW(smoothing_spline(x, y, {.max_iterations = 0}), std::invalid_argument);
}

TEST(SpreadKeys, joins_up_to_three_keys_by_lines_and_keeps_ends) {
  EXPECT_EQ(spread_keys(std::vector<double>{7}, 3), (std::vector<double>{7, 7, 7}));
  EXPECT_EQ(spread_keys(std::vector<double>{0, 4}, 5), (std::vector<double>{0, 1, 2, 3, 4}));
  EXPECT_EQ(spread_keys(std::vector<double>{0, 4, 0}, 5), (std::vector<double>{0, 2, 4, 2, 0}));
  EXPECT_EQ(spread_keys(std::vector<double>{3, 9, 1, 5, 8}, 1), (std::vector<double>{3}));
  const auto two = spread_keys(std::vector<double>{3, 9, 1, 5, 8}, 2);
  EXPECT_EQ(two, (std::vector<double>{3, 8}));
}

}  // namespace
}  // namespace uwv
