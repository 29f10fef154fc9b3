// SPDX-License-Identifier: Apache-2.0
#include "uwv/geometry/planar_prior.h"

#include <algorithm>
#include <cmath>

#include "geometry/deterministic_cv.h"
#include "geometry/layers/cv_bridge.h"
#include "geometry/layers/prior_parts.h"

namespace uwv {
namespace {

using layers::Layout;
using layers::Pieces;

void check_input(std::span<const ImageRgb> frames, std::span<const ForegroundMask> foreground,
                 const Intrinsics& intrinsics) {
  require(!frames.empty() && !frames.front().empty(), "the planar prior needs at least one picture, got {} frames",
          frames.size());
  require(foreground.empty() || foreground.size() == frames.size(), "{} foreground masks for {} frames",
          foreground.size(), frames.size());
  const Size size = frames.front().size();
  for (const ImageRgb& frame : frames)
    require(frame.size() == size, "frames have {}x{} and {}x{} pixels", size.width, size.height, frame.width(),
            frame.height());
  for (const ForegroundMask& mask : foreground)
    require(mask.size() == size, "frames have {}x{} pixels, a foreground mask {}x{}", size.width, size.height,
            mask.width(), mask.height());
  const bool sane = std::isfinite(intrinsics.fx) && std::isfinite(intrinsics.fy) && std::isfinite(intrinsics.cx) &&
                    std::isfinite(intrinsics.cy) && intrinsics.fx > 0 && intrinsics.fy > 0;
  require(sane, "the planar prior needs positive, finite focal lengths, got fx {} and fy {}", intrinsics.fx,
          intrinsics.fy);
}

/// Horizon and end of the ground: what was given, else what the picture tells, else the default.
void find_rows(const ImageRgb& picture, const ForegroundMask& covered, const Image<std::uint8_t>& sky,
               const PlanarPriorOptions& options, PlanarPriorResult& out) {
  const double height = picture.height();
  if (options.horizon_row) {
    out.horizon_row = *options.horizon_row;
    out.horizon_from = LayoutCue::given;
  } else if (const auto by_lines = layers::horizon_from_lines(picture)) {
    out.horizon_row = *by_lines;
    out.horizon_from = LayoutCue::vanishing_lines;
  } else if (const auto by_sky = layers::horizon_from_sky(sky)) {
    out.horizon_row = *by_sky;
    out.horizon_from = LayoutCue::sky;
  } else {
    out.horizon_row = 0.5 * height;
  }
  if (options.backdrop_row) {
    out.backdrop_row = *options.backdrop_row;
    out.backdrop_from = LayoutCue::given;
  } else if (const auto by_colour = layers::ground_end(picture, covered, out.horizon_row)) {
    out.backdrop_row = *by_colour;
    out.backdrop_from = LayoutCue::colour;
  } else {
    const double visible = std::max(0.0, height - std::max(0.0, out.horizon_row));
    out.backdrop_row = std::max(0.0, out.horizon_row) + options.default_ground * visible;
  }
}

/// Level distance at which the ground's tilt against the line of sight reaches the limit in the picture's corner.
double farthest_ground(const Intrinsics& intrinsics, const PlanarPriorOptions& options, int width) {
  const double aside = std::max(std::fabs(intrinsics.cx), std::fabs(width - intrinsics.cx)) / intrinsics.fx;
  const double tilt = options.steepest_ground * 3.14159265358979323846 / 180;
  return options.camera_height * std::max(1.0, std::tan(tilt) / std::hypot(1.0, aside));
}

Layout build_layout(const PlanarPriorResult& rows, const Intrinsics& intrinsics, const PlanarPriorOptions& options,
                    Size size) {
  Layout layout;
  layout.intrinsics = intrinsics;
  layout.camera_height = options.camera_height;
  layout.pitch = std::atan((intrinsics.cy - rows.horizon_row) / intrinsics.fy);
  double distance = layout.ground_distance(rows.backdrop_row);
  // Without ground in sight nothing ties the backdrop to the camera's height; a room's length is as good as any.
  const bool has_ground = rows.backdrop_row < size.height && distance > 0 && std::isfinite(distance);
  if (!has_ground) distance = 4 * options.camera_height;
  layout.backdrop_distance = std::min(distance, farthest_ground(intrinsics, options, size.width));
  return layout;
}

/// The contour that was given or found, and the layout that its farthest part asks for.
void find_contour(const ImageRgb& picture, const ForegroundMask& covered, const Image<std::uint8_t>& sky,
                  const PlanarPriorOptions& options, Layout& layout, PlanarPriorResult& out) {
  if (!options.contour.empty()) {
    out.contour = options.contour;
  } else if (options.find_contour && options.locked_off && !options.backdrop_row) {
    const double limit = farthest_ground(layout.intrinsics, options, picture.width());
    out.contour = layers::find_contour(picture, covered, sky, out.horizon_row, out.backdrop_row,
                                       std::max(0.0, layout.ground_row(limit)));
    if (out.contour.empty()) return;
    std::vector<double> rows = out.contour;
    const auto far = rows.begin() + static_cast<std::ptrdiff_t>(rows.size() / 10);
    std::nth_element(rows.begin(), far, rows.end());
    out.backdrop_row = *far;
    out.backdrop_from = LayoutCue::colour;
    layout.backdrop_distance = std::min(limit, layout.ground_distance(out.backdrop_row));
  }
}

double median_of(const DepthMap& depth) {
  std::vector<float> values(depth.pixels().begin(), depth.pixels().end());
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>((values.size() - 1) / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

void scale_all(double factor, PlanarPriorResult& result) {
  for (FrameGeometry& frame : result.geometry.frames)
    for (float& z : frame.depth.pixels()) z = static_cast<float>(z * factor);
  result.camera_height *= factor;
  result.backdrop_distance *= factor;
}

void write_notes(const PlanarPriorOptions& options, PlanarPriorResult& result) {
  auto& notes = result.geometry.notes;
  notes.emplace_back(
      "depth is a prior, not a measurement: give --depth or --depth-model for the real one; layers stand on a ground "
      "plane seen from eye height");
  notes.push_back(fmt::format("horizon at row {:.0f} ({}), the ground ends at row {:.0f} ({}), backdrop {:.3g} away",
                              result.horizon_row, to_string(result.horizon_from), result.backdrop_row,
                              to_string(result.backdrop_from), result.backdrop_distance));
  const SkyEvidence& sky = result.sky;
  if (sky.share > 0)
    notes.push_back(fmt::format(
        "{}: {:.0f} % of the picture and {:.0f} % of its upper edge look like one, {:.2f} times as bright as the rest",
        sky.believed ? "there is a sky" : "no sky", 100 * sky.share, 100 * sky.of_edge, sky.contrast));
  if (result.foreground_share == 0)
    notes.emplace_back("there is no foreground, so nothing but ground and backdrop has parallax");
  if (!options.locked_off && result.geometry.frames.size() > 1)
    notes.emplace_back("the camera moves, yet all cameras of a prior are the same: give --cameras to follow it");
}

}  // namespace

std::string_view to_string(LayoutCue cue) {
  switch (cue) {
    case LayoutCue::given: return "given";
    case LayoutCue::vanishing_lines: return "from vanishing lines";
    case LayoutCue::sky: return "from the sky's lower end";
    case LayoutCue::colour: return "from a change of colour";
    case LayoutCue::assumed: return "assumed";
  }
  return "assumed";
}

void PlanarPriorOptions::check() const {
  const auto finite = [](const std::optional<double>& v) { return !v || std::isfinite(*v); };
  require(finite(horizon_row) && finite(backdrop_row), "planar prior: rows must be finite, got {} and {}",
          horizon_row.value_or(0), backdrop_row.value_or(0));
  require(steepest_ground > 0 && steepest_ground < 90, "planar prior: steepest_ground must be in (0, 90), got {}",
          steepest_ground);
  require(camera_height > 0 && std::isfinite(camera_height), "planar prior: camera_height must be positive, got {}",
          camera_height);
  require(median_depth >= 0 && std::isfinite(median_depth), "planar prior: median_depth must not be negative, got {}",
          median_depth);
  require(default_ground > 0 && default_ground < 1, "planar prior: default_ground must be in (0, 1), got {}",
          default_ground);
  require(sky_distance >= 1 && std::isfinite(sky_distance), "planar prior: sky_distance must be at least 1, got {}",
          sky_distance);
  require(nearest > 0 && nearest <= farthest && farthest < 1,
          "planar prior: 0 < nearest <= farthest < 1 must hold, got {} and {}", nearest, farthest);
  require(relief >= 0 && relief <= 2, "planar prior: relief must be in [0, 2], got {}", relief);
  require(contact_window >= 0, "planar prior: contact_window must not be negative, got {}", contact_window);
  require(min_piece >= 0 && min_piece < 1, "planar prior: min_piece must be in [0, 1), got {}", min_piece);
  require(backdrop_samples >= 1, "planar prior: backdrop_samples must be positive, got {}", backdrop_samples);
}

std::string PlanarPriorResult::brief() const {
  return fmt::format(
      "depth assumed: ground from row {:.0f} ({}), horizon {:.0f} ({}), backdrop at {:.3g}, foreground {:.1f} %, sky "
      "{:.1f} %",
      backdrop_row, to_string(backdrop_from), horizon_row, to_string(horizon_from), backdrop_distance,
      100 * foreground_share, 100 * sky_share);
}

PlanarPriorResult planar_prior(std::span<const ImageRgb> frames, std::span<const ForegroundMask> foreground,
                               const Intrinsics& intrinsics, const PlanarPriorOptions& options, ThreadPool& pool,
                               Monitor& monitor) {
  options.check();
  check_input(frames, foreground, intrinsics);
  const auto width = static_cast<std::size_t>(frames.front().width());
  require(options.contour.empty() || options.contour.size() == width,
          "planar prior: the contour has {} rows for {} columns", options.contour.size(), width);
  for (double row : options.contour) require(std::isfinite(row), "planar prior: the contour has a row {}", row);
  const DeterministicCv deterministic;
  const Size size = frames.front().size();
  const auto count = static_cast<int>(frames.size());
  const auto min_pixels = static_cast<std::size_t>(options.min_piece * static_cast<double>(size.pixels()));
  PlanarPriorResult result;

  ForegroundMask covered;
  const std::size_t shown = options.locked_off ? frames.size() : 1;
  const ImageRgb backdrop =
      layers::backdrop_picture(frames.first(shown), foreground.empty() ? foreground : foreground.first(shown),
                               options.backdrop_samples, covered);
  const auto sky_of = [&](const ImageRgb& picture, const ForegroundMask& mask, SkyEvidence& evidence) {
    return options.find_sky ? layers::find_sky(picture, mask, evidence) : Image<std::uint8_t>(size);
  };
  const Image<std::uint8_t> sky = sky_of(backdrop, covered, result.sky);
  find_rows(backdrop, covered, sky, options, result);
  Layout layout = build_layout(result, intrinsics, options, size);
  find_contour(backdrop, covered, sky, options, layout, result);
  result.pitch = layout.pitch;
  result.camera_height = layout.camera_height;
  result.backdrop_distance = layout.backdrop_distance;
  const FrameGeometry behind = layers::backdrop_geometry(layout, result.contour, sky, options.sky_distance);
  result.sky_share =
      static_cast<double>(std::count(sky.pixels().begin(), sky.pixels().end(), 1)) / static_cast<double>(size.pixels());
  monitor.step("prior: backdrop", 1, 1);

  std::vector<Pieces> pieces(foreground.size());
  pool.for_ranges(0, static_cast<int>(foreground.size()), 1, [&](int from, int to) {
    for (int i = from; i < to; ++i)
      pieces[static_cast<std::size_t>(i)] = layers::find_pieces(foreground[static_cast<std::size_t>(i)], min_pixels);
  });
  layers::track_contacts(pieces, options.contact_window);
  monitor.step("prior: foreground", 1, 1);

  result.geometry.frames.resize(frames.size());
  result.geometry.cameras.assign(frames.size(), Camera{intrinsics, Rigid3{}, size});
  pool.for_ranges(0, count, 1, [&](int from, int to) {
    for (int i = from; i < to; ++i) {
      const auto f = static_cast<std::size_t>(i);
      FrameGeometry& frame = result.geometry.frames[f];
      SkyEvidence evidence;
      frame = options.locked_off || i == 0
                  ? behind
                  : layers::backdrop_geometry(
                        layout, result.contour,
                        sky_of(frames[f], foreground.empty() ? ForegroundMask() : foreground[f], evidence),
                        options.sky_distance);
      if (!foreground.empty()) layers::place_pieces(pieces[f], layout, options, frame);
    }
  });
  monitor.step("prior: frames", count, count);

  for (const ForegroundMask& mask : foreground)
    result.foreground_share += static_cast<double>(mask.count()) / static_cast<double>(size.pixels() * frames.size());
  if (options.median_depth > 0)
    scale_all(options.median_depth / median_of(result.geometry.frames.front().depth), result);
  write_notes(options, result);
  return result;
}

}  // namespace uwv
