// SPDX-License-Identifier: Apache-2.0
// Scatter plots as SVG files: named dots over a logarithmic x axis, one or more panels one above the other.
//
// The picture has its own light background, so it reads the same on white and on dark pages.
#pragma once

#include <string>
#include <vector>

namespace uwv::bench {

enum class AxisScale {
  linear,
  nines,  ///< Shares close to 1: 0.9, 0.99 and 0.999 are equally far apart. Values above 0.9999 count as that.
};

/// Which values are the good ones, if any. Less x is always better.
enum class Better { neither, low, high };

struct Dot {
  std::string label;
  double x = 0, y = 0;  ///< x > 0; both finite, y of a nines axis in [0, 1].
  bool accent = false;  ///< Drawn to stand out.
};

struct Panel {
  std::string title;
  std::string y_title;
  AxisScale y_scale = AxisScale::linear;
  std::vector<Dot> dots;  ///< At least one.
  /// Unless `neither`, a line joins the dots that no other beats in x and y.
  Better better = Better::neither;
};

/// The dots of a panel that no other is at least as good as in both x and y, by x. Of equal dots the first. Empty where
/// neither is better.
std::vector<Dot> front(const Panel& panel);

/// The picture as SVG text. All panels share the x axis. Throws std::invalid_argument without panels or dots, or for
/// coordinates that cannot be drawn.
std::string plot_svg(const std::string& x_title, const std::vector<Panel>& panels);
/// The same into a file. Throws Error(output_failed).
void write_plot(const std::string& path, const std::string& x_title, const std::vector<Panel>& panels);

}  // namespace uwv::bench
