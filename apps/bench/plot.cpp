// SPDX-License-Identifier: Apache-2.0
#include "bench/plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>

#include "uwv/core/error.h"

namespace uwv::bench {
namespace {

// Pixels.
constexpr double width = 900, panel_height = 400, margin_left = 76, margin_right = 24, margin_top = 44;
constexpr double panel_gap = 64, margin_bottom = 56;
constexpr double font = 12.5, letter = 0.56 * font;  // mean advance of the usual sans-serif faces
constexpr double radius = 5;

constexpr const char* ink = "#1f2933";
constexpr const char* faint = "#d9dee4";
constexpr const char* dot_colour = "#2f6fb2";
constexpr const char* accent_colour = "#d1495b";

struct Rect {
  double x0, y0, x1, y1;
  bool overlaps(const Rect& o) const { return x0 < o.x1 && o.x0 < x1 && y0 < o.y1 && o.y0 < y1; }
};

/// From values to pixels along one axis, with the ticks to draw.
struct Axis {
  double least, greatest;                             // of the transformed values
  double from, to;                                    // pixels
  std::vector<std::pair<double, std::string>> ticks;  // transformed value, label
  double place(double transformed) const { return from + (transformed - least) / (greatest - least) * (to - from); }
};

double nines(double share) { return -std::log10(std::max(1e-4, 1 - share)); }

double transformed(AxisScale scale, double value) { return scale == AxisScale::nines ? nines(value) : value; }

/// Range of values with a margin, so that no dot sits on the frame.
std::pair<double, double> padded(double least, double greatest, double margin) {
  const double space = std::max(margin * (greatest - least), 1e-3);
  return {least - space, greatest + space};
}

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text)
    if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else if (c == '&')
      out += "&amp;";
    else
      out += c;
  return out;
}

Axis x_axis(const std::vector<Panel>& panels) {
  double least = std::numeric_limits<double>::infinity(), greatest = -least;
  for (const Panel& panel : panels)
    for (const Dot& dot : panel.dots) {
      require(dot.x > 0 && std::isfinite(dot.x), "dot '{}' at x = {} cannot be drawn on a logarithmic axis", dot.label,
              dot.x);
      least = std::min(least, std::log10(dot.x));
      greatest = std::max(greatest, std::log10(dot.x));
    }
  const auto [from, to] = padded(least, greatest, 0.08);
  Axis axis{from, to, margin_left, width - margin_right, {}};
  const std::vector<double> steps =
      to - from > 1.2 ? std::vector<double>{1, 2, 5} : std::vector<double>{1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 8};
  for (const double decade : {0.01, 0.1, 1.0, 10.0, 100.0, 1000.0, 10000.0})
    for (const double step : steps) {
      const double value = step * decade;
      if (std::log10(value) >= from && std::log10(value) <= to)
        axis.ticks.emplace_back(std::log10(value), fmt::format("{:g}", value));
    }
  return axis;
}

/// Round numbers about a fifth of the range apart.
void linear_ticks(Axis& axis) {
  const double rough = (axis.greatest - axis.least) / 5, power = std::pow(10, std::floor(std::log10(rough)));
  const double step = power * (rough < 1.5 * power ? 1 : rough < 3.5 * power ? 2 : rough < 7.5 * power ? 5 : 10);
  for (double tick = std::ceil(axis.least / step) * step; tick <= axis.greatest; tick += step)
    axis.ticks.emplace_back(tick, fmt::format("{:g}", std::round(tick / step) * step));
}

Axis y_axis(const Panel& panel, double top) {
  double least = std::numeric_limits<double>::infinity(), greatest = -least;
  for (const Dot& dot : panel.dots) {
    require(std::isfinite(dot.y), "dot '{}' at y = {} cannot be drawn", dot.label, dot.y);
    least = std::min(least, transformed(panel.y_scale, dot.y));
    greatest = std::max(greatest, transformed(panel.y_scale, dot.y));
  }
  const auto [from, to] = padded(least, greatest, 0.09);
  Axis axis{from, to, top + panel_height, top, {}};
  if (panel.y_scale == AxisScale::linear) {
    linear_ticks(axis);
    return axis;
  }
  for (const double share : {0.0, 0.5, 0.8, 0.9, 0.95, 0.98, 0.99, 0.995, 0.998, 0.999, 0.9995, 0.9998})
    if (nines(share) >= from && nines(share) <= to) axis.ticks.emplace_back(nines(share), fmt::format("{:g}", share));
  return axis;
}

/// Finds room for labels: beside the dot if possible, else a little away with a line that leads back.
class Labels {
 public:
  explicit Labels(const Rect& frame) : frame_(frame) {}
  void occupy(const Rect& rect) { taken_.push_back(rect); }

  struct Place {
    Rect box;
    const char* anchor;  ///< The side of the box that is certain: how wide letters are depends on the reader's fonts.
    bool needs_line;
  };

  Place put(double x, double y, const std::string& text) {
    const double w = letter * static_cast<double>(text.size()), h = font + 2;
    for (double distance = radius + 3; distance < 160; distance += 6)
      for (const auto& [dx, dy] : directions) {
        const double cx = x + dx * (distance + (dx != 0 ? w / 2 : 0)), cy = y + dy * (distance + h / 2);
        const Rect box{cx - w / 2, cy - h / 2, cx + w / 2, cy + h / 2};
        if (!free(box)) continue;
        taken_.push_back(box);
        return {box, box.x0 > x ? "start" : box.x1 < x ? "end" : "middle", distance > radius + 4};
      }
    return {{x + radius + 3, y - h / 2, x + radius + 3 + w, y + h / 2}, "start", false};  // overlapping, not missing
  }

 private:
  static constexpr std::pair<double, double> directions[] = {{1, 0},     {-1, 0},   {1, -0.7},  {1, 0.7},
                                                             {-1, -0.7}, {-1, 0.7}, {0, -1},    {0, 1},
                                                             {0.5, -1},  {0.5, 1},  {-0.5, -1}, {-0.5, 1}};
  bool free(const Rect& box) const {
    if (box.x0 < frame_.x0 + 2 || box.x1 > frame_.x1 - 2 || box.y0 < frame_.y0 + 2 || box.y1 > frame_.y1 - 2)
      return false;
    return std::none_of(taken_.begin(), taken_.end(), [&](const Rect& other) { return box.overlaps(other); });
  }
  Rect frame_;
  std::vector<Rect> taken_;
};

std::string line(double x0, double y0, double x1, double y1, const char* colour) {
  return fmt::format("<line x1='{:.1f}' y1='{:.1f}' x2='{:.1f}' y2='{:.1f}' stroke='{}'/>\n", x0, y0, x1, y1, colour);
}

std::string text(double x, double y, const char* anchor, const std::string& words, const std::string& more = "") {
  return fmt::format("<text x='{:.1f}' y='{:.1f}' text-anchor='{}' {}>{}</text>\n", x, y, anchor, more, escaped(words));
}

std::string draw_axes(const Panel& panel, const Axis& x, const Axis& y) {
  std::string out;
  for (const auto& [value, label] : x.ticks) {
    out += line(x.place(value), y.to, x.place(value), y.from, faint);
    out += text(x.place(value), y.from + 18, "middle", label);
  }
  for (const auto& [value, label] : y.ticks) {
    out += line(x.from, y.place(value), x.to, y.place(value), faint);
    out += text(x.from - 8, y.place(value) + 4, "end", label);
  }
  out += line(x.from, y.from, x.to, y.from, ink) + line(x.from, y.from, x.from, y.to, ink);
  out += text(x.from, y.to - 14, "start", panel.title, "font-weight='bold' font-size='15'");
  const double middle = (y.from + y.to) / 2;
  out += text(20, middle, "middle", panel.y_title, fmt::format("transform='rotate(-90 20 {:.1f})'", middle));
  return out;
}

std::string draw_front(const Panel& panel, const Axis& x, const Axis& y) {
  std::string points;
  for (const Dot& dot : front(panel))
    points += fmt::format("{:.1f},{:.1f} ", x.place(std::log10(dot.x)), y.place(transformed(panel.y_scale, dot.y)));
  if (points.empty()) return points;
  return fmt::format("<polyline points='{}' fill='none' stroke='{}' stroke-width='1.5' stroke-dasharray='5 4'/>\n",
                     points, dot_colour);
}

std::string draw_dots(const Panel& panel, const Axis& x, const Axis& y) {
  Labels labels({x.from, y.to, x.to, y.from});
  const auto at = [&](const Dot& dot) {
    return std::pair{x.place(std::log10(dot.x)), y.place(transformed(panel.y_scale, dot.y))};
  };
  std::vector<const Dot*> order;
  for (const Dot& dot : panel.dots) {
    const auto [u, v] = at(dot);
    labels.occupy({u - radius, v - radius, u + radius, v + radius});
    order.push_back(&dot);
  }
  // The one that matters gets the best place; the rest from the right, where labels run into the margin.
  std::stable_sort(order.begin(), order.end(),
                   [](const Dot* a, const Dot* b) { return a->accent != b->accent ? a->accent : a->x > b->x; });
  std::string lines, dots, words, top;  // nothing hides the one that matters
  for (const Dot* dot : order) {
    const auto [u, v] = at(*dot);
    const char* colour = dot->accent ? accent_colour : dot_colour;
    const auto [box, anchor, needs_line] = labels.put(u, v, dot->label);
    if (needs_line) lines += line(u, v, std::clamp(u, box.x0, box.x1), std::clamp(v, box.y0, box.y1), "#9aa5b1");
    (dot->accent ? top : dots) += fmt::format("<circle cx='{:.1f}' cy='{:.1f}' r='{}' fill='{}' stroke='#ffffff'/>\n",
                                              u, v, dot->accent ? radius + 1.5 : radius, colour);
    const double at_anchor = *anchor == 's' ? box.x0 : *anchor == 'e' ? box.x1 : (box.x0 + box.x1) / 2;
    words += text(at_anchor, box.y1 - 4, anchor, dot->label,
                  dot->accent ? fmt::format("fill='{}' font-weight='bold'", accent_colour) : "");
  }
  return lines + dots + top + words;
}

}  // namespace

std::vector<Dot> front(const Panel& panel) {
  if (panel.better == Better::neither) return {};
  const double sign = panel.better == Better::low ? 1 : -1;
  std::vector<Dot> dots = panel.dots;
  std::stable_sort(dots.begin(), dots.end(),
                   [&](const Dot& a, const Dot& b) { return a.x != b.x ? a.x < b.x : sign * a.y < sign * b.y; });
  std::vector<Dot> out;
  for (const Dot& dot : dots)
    if (out.empty() || sign * dot.y < sign * out.back().y) out.push_back(dot);
  return out;
}

std::string plot_svg(const std::string& x_title, const std::vector<Panel>& panels) {
  require(!panels.empty(), "a plot needs a panel");
  for (const Panel& panel : panels) require(!panel.dots.empty(), "the panel '{}' has no dots", panel.title);
  const Axis x = x_axis(panels);
  std::string body;
  double top = margin_top;
  for (const Panel& panel : panels) {
    const Axis y = y_axis(panel, top);
    body += draw_axes(panel, x, y) + draw_front(panel, x, y) + draw_dots(panel, x, y);
    top += panel_height + panel_gap;
  }
  const double height = top - panel_gap + margin_bottom;
  body += text((x.from + x.to) / 2, height - 14, "middle", x_title);
  return fmt::format(
      "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 {0} {1}' width='{0}' height='{1}' fill='{2}' "
      "font-family='Helvetica, Arial, sans-serif' font-size='{3}'>\n<rect width='100%' height='100%' rx='8' "
      "fill='#ffffff'/>\n{4}</svg>\n",
      width, height, ink, font, body);
}

void write_plot(const std::string& path, const std::string& x_title, const std::vector<Panel>& panels) {
  std::ofstream file(path);
  file << plot_svg(x_title, panels);
  if (!file.flush()) fail(ErrorCode::output_failed, "{}: cannot be written", path);
}

}  // namespace uwv::bench
