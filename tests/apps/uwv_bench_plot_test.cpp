// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <regex>

#include "bench/plot.h"
#include "uwv/core/error.h"

namespace uwv::bench {
namespace {

using testing::HasSubstr;
using testing::Not;

Panel panel(std::vector<Dot> dots, AxisScale scale = AxisScale::linear) {
  return {"title", "height", scale, std::move(dots)};
}

TEST(Plot, NamesEveryDotAndAxis) {
  const std::string svg = plot_svg("width", {panel({{"one", 10, 1}, {"two", 100, 2}})});
  for (const char* word : {">one<", ">two<", ">title<", ">height<", ">width<", ">10<", ">100<"})
    EXPECT_THAT(svg, HasSubstr(word));
}

TEST(Plot, EscapesWhatXmlReserves) {
  const std::string svg = plot_svg("x", {panel({{"a<b & c>d", 1, 1}})});
  EXPECT_THAT(svg, HasSubstr("a&lt;b &amp; c&gt;d"));
  EXPECT_THAT(svg, Not(HasSubstr("a<b")));
}

TEST(Plot, TheFrontIsWhatNothingBeatsInBoth) {
  const std::vector<Dot> dots{
      {"slow, good", 9, 1}, {"fast, poor", 1, 5}, {"beaten", 5, 4}, {"middle", 3, 3}, {"twin", 3, 3}};
  const auto names = [](const Panel& from) {
    std::vector<std::string> out;
    for (const Dot& dot : front(from)) out.push_back(dot.label);
    return out;
  };
  Panel low = panel(dots);
  EXPECT_THAT(names(low), testing::IsEmpty());
  EXPECT_THAT(plot_svg("x", {low}), Not(HasSubstr("polyline")));
  low.better = Better::low;
  EXPECT_THAT(names(low), testing::ElementsAre("fast, poor", "middle", "slow, good"));
  EXPECT_THAT(plot_svg("x", {low}), HasSubstr("polyline"));
  Panel high = panel(dots);
  high.better = Better::high;
  EXPECT_THAT(names(high), testing::ElementsAre("fast, poor"));
}

TEST(Plot, LabelsOfCrowdedDotsKeepApart) {
  std::vector<Dot> dots;
  dots.reserve(13);
  for (int i = 0; i < 12; ++i) dots.push_back({"crowded", 40 + 0.01 * i, 1 + 0.001 * i});
  dots.push_back({"far", 400, 9});
  const std::string svg = plot_svg("x", {panel(dots)});
  const std::regex label("<text x='([0-9.]+)' y='([0-9.]+)' text-anchor='([a-z]+)'[^>]*>crowded<");
  struct Place {
    double left, baseline;
  };
  constexpr double letters = 40;  // a little less than the word takes
  std::vector<Place> places;
  for (auto it = std::sregex_iterator(svg.begin(), svg.end(), label); it != std::sregex_iterator(); ++it) {
    const double anchored = (*it)[3] == "start" ? 0 : (*it)[3] == "middle" ? letters / 2 : letters;
    places.push_back({std::stod((*it)[1]) - anchored, std::stod((*it)[2])});
  }
  ASSERT_EQ(places.size(), 12U);
  for (std::size_t i = 0; i < places.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      EXPECT_TRUE(std::abs(places[i].left - places[j].left) > letters ||
                  std::abs(places[i].baseline - places[j].baseline) > 10)
          << i << " and " << j;
}

TEST(Plot, NinesSpreadSharesCloseToOne) {
  const std::string svg = plot_svg("x", {panel({{"a", 1, 0.5}, {"b", 2, 0.999}, {"c", 3, 1.0}}, AxisScale::nines)});
  for (const char* tick : {">0.9<", ">0.99<", ">0.999<"}) EXPECT_THAT(svg, HasSubstr(tick));
}

TEST(Plot, RefusesWhatItCannotDraw) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(plot_svg("x", {}), std::invalid_argument);
  EXPECT_THROW(plot_svg("x", {panel({})}), std::invalid_argument);
  EXPECT_THROW(plot_svg("x", {panel({{"zero", 0, 1}})}), std::invalid_argument);
  EXPECT_THROW(plot_svg("x", {panel({{"nan", 1, nan}})}), std::invalid_argument);
  EXPECT_THROW(write_plot("/nonexistent/folder/plot.svg", "x", {panel({{"a", 1, 1}})}), Error);
}

}  // namespace
}  // namespace uwv::bench
