// SPDX-License-Identifier: Apache-2.0
#include "uwv/pipeline/run_options.h"

#include <cmath>
#include <filesystem>
#include <numbers>

namespace uwv {
namespace {

constexpr double degree = std::numbers::pi / 180;

void check_input(const RunOptions& o) {
  require(!o.video.empty(), "--video is missing: name a video, a photo or a folder of pictures");
  require(o.depth.empty() || o.disparity.empty(), "--depth and --disparity exclude each other; give one");
  require(!o.depth_scale || *o.depth_scale > 0, "--depth-scale: found {}, wanted a positive number",
          o.depth_scale.value_or(0));
  require(o.disparity.empty() || o.baseline > 0, "--disparity needs --baseline: found {}, wanted a positive distance",
          o.baseline);
  require(!o.fx || *o.fx != 0, "--fx: found 0, wanted a focal length in pixels");
  require(!o.fy || (o.fx && *o.fy != 0), "--fy: wanted a focal length in pixels, together with --fx");
  require(!o.fov || !o.fx, "--fov and --fx exclude each other; give one");
  require((!o.cx && !o.cy) || o.fx || o.fov, "--cx and --cy need --fx or --fov");
  require(!o.fov || (*o.fov > 0 && *o.fov < 180), "--fov: found {}, wanted degrees between 0 and 180",
          o.fov.value_or(0));
  require(o.start >= 0, "--start: found {}, wanted 0 or more", o.start);
  require(o.stride >= 1, "--stride: found {}, wanted 1 or more", o.stride);
  require(o.max_frames >= 0, "--max-frames: found {}, wanted 0 (all) or more", o.max_frames);
}

void check_geometry(const RunOptions& o) {
  const bool nothing_given = o.depth.empty() && o.disparity.empty();
  require(o.geometry != GeometryChoice::import || !nothing_given,
          "--geometry import needs --depth, or --disparity with --baseline");
  require(o.geometry == GeometryChoice::automatic || o.geometry == GeometryChoice::import || estimates_geometry(o),
          "--geometry {} estimates depth: leave --depth and --disparity out, or use --geometry import",
          o.geometry == GeometryChoice::sfm       ? "sfm"
          : o.geometry == GeometryChoice::network ? "network"
                                                  : "prior");
  require(o.geometry != GeometryChoice::network || !o.depth_model.empty(), "--geometry network needs --depth-model");
  require(o.depth_model.empty() || o.geometry == GeometryChoice::automatic || o.geometry == GeometryChoice::network,
          "--depth-model is for --geometry auto or network; leave one of the two out");
  require(o.depth_model.empty() || nothing_given,
          "--depth-model estimates depth: leave --depth and --disparity out, or leave it out");
  require(o.depth_kind == DepthKind::depth || !o.depth.empty(), "--depth-kind says what --depth is; give --depth");
  const bool estimates = estimates_geometry(o);
  require(o.background_depth.empty() || !estimates,
          "--background-depth goes with --depth; where depth is estimated, that of --background is too");
  require(estimates || o.background.empty() == o.background_depth.empty(),
          "--background and --background-depth go together where depth is given; give both or none");
  require(!o.static_depth || !is_relative(o.depth_kind),
          "--static-depth needs depth in scene units, not a relative one");
  require(o.cameras.empty() || !nothing_given,
          "--cameras needs the depth that goes with them: give --depth, or leave --cameras out to have both estimated");
  require(o.cameras.empty() || !is_relative(o.depth_kind),
          "--depth-kind: relative depth is brought to the scale of estimated cameras; leave --cameras out");
  sfm_options(o).check();
  mvs_options(o).check();
}

void check_size_and_path(const RunOptions& o) {
  require(
      o.size == Size{} || (o.size.width > 0 && o.size.height > 0 && o.size.width <= 65535 && o.size.height <= 65535),
      "--size: found {}x{}, wanted sides of 1 to 65535 pixels", o.size.width, o.size.height);
  require(o.size == Size{} || !o.no_resize, "--size and --no-resize exclude each other; give one");
  require(o.max_side >= 16, "--max-side: found {}, wanted at least 16", o.max_side);
  require(!o.traj.empty(), "--traj is empty: name a trajectory file or a preset");
  require(!o.frames || (*o.frames >= 1 && *o.frames <= 1000000), "--frames: found {}, wanted 1 to 1000000",
          o.frames.value_or(0));
  require(!o.elevation || std::abs(*o.elevation) <= 90, "--elevation: found {}, wanted degrees from -90 to 90",
          o.elevation.value_or(0));
  require(!o.radius || *o.radius > 0, "--radius: found {}, wanted a positive distance", o.radius.value_or(0));
  require(!o.radius_scale || *o.radius_scale > 0, "--radius-scale: found {}, wanted a positive number",
          o.radius_scale.value_or(0));
}

void check_render_and_output(const RunOptions& o) {
  require(o.alpha >= 0 && o.alpha <= 180, "--alpha: found {}, wanted degrees from 0 to 180", o.alpha);
  require(!o.max_tilt || (*o.max_tilt > 0 && *o.max_tilt <= 90), "--max-tilt: found {}, wanted degrees from 0 to 90",
          o.max_tilt.value_or(0));
  require(!o.max_error || (*o.max_error >= 0 && *o.max_error <= 1000), "--max-error: found {}, wanted 0 to 1000 pixels",
          o.max_error.value_or(0));
  require(o.max_error.value_or(0) == 0 || o.kernel != Kernel::bilinear,
          "--max-error needs --kernel nearest or resample: the bilinear splat draws every point as a dot");
  require(o.max_error.value_or(0) == 0 || o.renderer != RendererChoice::gl,
          "--max-error is drawn by the CPU; use --renderer cpu or auto");
  require(o.threads >= 0 && o.threads <= 1024, "--threads: found {}, wanted 0 (all processors) to 1024", o.threads);
  occlusion_options(o).check();
  require(o.accumulation != Accumulation::foreground || !o.foreground.empty(),
          "--accumulation foreground needs --foreground, a mask clip of what moves");
  require(!o.fps || (*o.fps > 0 && *o.fps <= 1000), "--fps: found {}, wanted more than 0, at most 1000",
          o.fps.value_or(0));
  require(o.crf >= 0 && o.crf <= 51, "--crf: found {}, wanted 0 to 51", o.crf);
  require(o.contact_sheet >= 0 && o.contact_sheet <= 64, "--contact-sheet: found {}, wanted 0 to 64 columns",
          o.contact_sheet);
  for (const long frame : o.ply) require(frame >= 0, "--ply: found {}, wanted frame numbers of 0 or more", frame);
  require(o.eval_reference.empty() == o.eval_cameras.empty(),
          "--eval-reference and --eval-cameras go together; give both or none");
}

void check_completion(const RunOptions& o) {
  require(o.complete != Completion::model || !o.diffusion.model.empty(), "--complete model needs --model");
  require(o.complete != Completion::inpaint || o.diffusion.model.empty(),
          "--complete inpaint goes without a model; leave it or --model out");
  o.diffusion.check();
}

}  // namespace

void RunOptions::check() const {
  check_input(*this);
  check_geometry(*this);
  check_size_and_path(*this);
  check_render_and_output(*this);
  check_completion(*this);
}

std::string RunOptions::out_folder() const {
  if (!out.empty()) return out;
  std::filesystem::path clip = std::filesystem::path(video).lexically_normal();
  if (!clip.has_filename()) clip = clip.parent_path();
  const std::string stem = clip.stem().string();
  return (stem.empty() || stem == "." || stem == ".." ? "clip" : stem) + "_uwv";
}

Completion completion_of(const RunOptions& options) {
  return options.diffusion.model.empty() ? options.complete : Completion::model;
}

OcclusionOptions occlusion_options(const RunOptions& from) {
  OcclusionOptions options;
  options.kernel = from.kernel;
  options.visibility = from.visibility;
  options.accumulation = from.accumulation.value_or(Accumulation::product);
  options.alpha = from.alpha * degree;
  options.normal_filter = from.normal_filter;
  options.depth_tolerance = from.depth_tolerance;
  options.footprint.point_size = from.point_size;
  options.footprint.max_footprint = from.max_footprint;
  if (from.log_depth_max) options.soft_splat.log_depth_max = static_cast<float>(*from.log_depth_max);
  options.return_size = from.return_size;
  options.fringe = from.fringe;
  options.dropped_points_hide = from.dropped_points_hide;
  options.slopes = {.discontinuity = from.slope_discontinuity, .radius = from.slope_radius};
  if (from.max_tilt) options.slopes.max_tilt = *from.max_tilt * degree;
  options.reliability.enabled = from.reliability == ReliabilityChoice::on;
  options.reliability.ratio = from.reliability_ratio;
  options.reliability.window = from.reliability_window;
  options.skip_unneeded = from.skip_unneeded;
  return options;
}

Intrinsics assumed_intrinsics(Size full_size) { return Intrinsics::from_fov_x(assumed_fov_deg * degree, full_size); }

bool is_relative(DepthKind kind) { return kind == DepthKind::relative_inverse || kind == DepthKind::relative_depth; }

bool estimates_geometry(const RunOptions& options) {
  return is_relative(options.depth_kind) || (options.depth.empty() && options.disparity.empty());
}

SfmOptions sfm_options(const RunOptions& from) {
  SfmOptions options;
  options.max_features = from.max_features;
  options.min_parallax_px = from.min_parallax_px;
  return options;
}

MvsOptions mvs_options(const RunOptions& from) {
  MvsOptions options;
  options.neighbours = from.mvs_neighbours;
  options.planes = from.mvs_planes;
  options.scale = from.mvs_scale;
  options.key_stride = from.mvs_key_stride;
  return options;
}

std::optional<Intrinsics> intrinsics_by_number(const RunOptions& options, Size full_size) {
  if (!options.fx && !options.fov) return std::nullopt;
  Intrinsics intrinsics = options.fov ? Intrinsics::from_fov_x(*options.fov * degree, full_size)
                                      : Intrinsics{*options.fx, options.fy.value_or(*options.fx), 0.5 * full_size.width,
                                                   0.5 * full_size.height};
  const double shift = options.pixel_centre == PixelCentre::integer ? 0.5 : 0.0;
  if (options.cx) intrinsics.cx = *options.cx + shift;
  if (options.cy) intrinsics.cy = *options.cy + shift;
  return intrinsics;
}

}  // namespace uwv
