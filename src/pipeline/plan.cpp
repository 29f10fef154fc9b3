// SPDX-License-Identifier: Apache-2.0
#include "pipeline/plan.h"

#include <algorithm>
#include <filesystem>

#include "uwv/io/cameras_file.h"

namespace uwv::pipeline {
namespace {

constexpr double reference_fps = 16;  // what the model was trained on, and the fallback where nothing says more

/// The orbit's radius where nobody gives one (geometry sheet, section 1): what the subject is, is the foreground.
double subject_depth(const SourceData& first) {
  if (first.foreground && first.foreground->count() > 0) {
    DepthMap subject = first.depth;
    for (std::size_t i = 0; i < subject.pixels().size(); ++i)
      if (first.foreground->pixels()[i] == 0) subject.pixels()[i] = 0;
    if (const float median = median_depth(subject); median > 0) return median;
  }
  return median_depth(first.depth);
}

/// Cameras of a file named inside the trajectory, as the trajectory module wants them.
void read_listed_cameras(TrajectorySpec& spec, const SourceClip& source, Monitor& monitor) {
  auto* motion = std::get_if<CameraMotion>(&spec.motion);
  if (motion == nullptr || motion->cameras_file.empty()) return;
  const CameraTrack track =
      read_cameras(motion->cameras_file, {.size = source.size(), .intrinsics = source.intrinsics(0)}, monitor);
  for (const Camera& camera : track.cameras)
    motion->cameras.push_back(
        {.world_from_cam = camera.world_from_cam, .intrinsics = camera.intrinsics, .fov = {}, .size = camera.size});
  motion->cameras_file.clear();
}

TrajectorySpec named_spec(const RunOptions& options) {
  const std::filesystem::path path(options.traj);
  const bool is_file = std::filesystem::exists(path) || path.has_extension() || path.has_parent_path();
  return is_file ? read_trajectory(path) : trajectory_from_preset(options.traj);
}

TrajectorySpec read_spec(const RunOptions& options, const SourceClip& source, Monitor& monitor) {
  TrajectorySpec spec = named_spec(options);
  if (options.follow_source) spec.follow_source = true;
  if (options.frames) spec.frames = *options.frames;
  if (options.elevation) spec.elevation = *options.elevation;
  if (options.radius) spec.radius = *options.radius;
  if (options.radius_scale) spec.radius_scale = *options.radius_scale;
  read_listed_cameras(spec, source, monitor);
  return spec;
}

double output_fps(const RunOptions& options, const TrajectorySpec& spec, const ClipInfo& clip) {
  if (options.fps) return *options.fps;
  if (spec.fps > 0) return spec.fps;
  return clip.fps > 0 && !clip.is_photo ? clip.fps / static_cast<double>(options.stride) : reference_fps;
}

bool source_moves(const SourceClip& source) {
  const std::vector<Rigid3>& poses = source.world_from_cam();
  return std::any_of(poses.begin(), poses.end(), [&](const Rigid3& pose) { return !(pose == poses.front()); });
}

/// How far the source camera gets from where it began, scene units.
double source_travel(const SourceClip& source) {
  double farthest = 0;
  for (const Rigid3& pose : source.world_from_cam())
    farthest = std::max(farthest, (pose.translation - source.world_from_cam().front().translation).norm());
  return farthest;
}

void warn_of_the_path(const Plan& plan, Monitor& monitor) {
  constexpr double far_in_radii = 0.5;  // about where half the picture is another one
  const double travel = source_travel(*plan.source) / plan.context.world.radius();
  if (travel > far_in_radii && !plan.trajectory.follow_source && plan.frames() > 1)
    monitor.warn(
        fmt::format("the source camera itself moves {:.2g} radii, while the path starts from its first pose: "
                    "--follow-source applies the path to the moving camera",
                    travel));
  if (plan.look.first_return >= 0 && plan.look.has_parallax && plan.accumulation() == Accumulation::product)
    monitor.warn(
        fmt::format("the path comes back from frame {}: what was hidden in between stays masked; "
                    "--accumulation product_in_view keeps what only left the picture",
                    plan.look.first_return));
  if (plan.look.far_depth == 0) monitor.warn("the first frame has no valid depth: nothing of it can be drawn");
}

}  // namespace

OcclusionOptions Plan::occlusion() const {
  OcclusionOptions decided = occlusion_options(options);
  decided.accumulation = accumulation();
  if (options.reliability == ReliabilityChoice::automatic) decided.reliability.enabled = look.edges.smears();
  return decided;
}

Accumulation Plan::accumulation() const {
  if (options.accumulation) return *options.accumulation;
  if (source_moves(*source)) return Accumulation::none;
  return source->has_foreground() ? Accumulation::foreground : Accumulation::product;
}

std::string Plan::accumulation_reason() const {
  const std::string chosen(to_string(accumulation()));
  if (options.accumulation) return chosen + ": asked for";
  if (source_moves(*source)) return chosen + ": the source camera moves";
  return chosen + (source->has_foreground() ? ": a foreground moves before a standing camera"
                                            : ": nothing is known to move, and the camera stands");
}

std::string Plan::reliability() const {
  const char* state = occlusion().reliability.enabled ? "on" : "off";
  if (options.reliability != ReliabilityChoice::automatic) return fmt::format("{}: asked for", state);
  if (look.edges.edges == 0) return fmt::format("{}: the first frame's depth has no edges", state);
  return fmt::format("{}: {:.0f} % of the {} depth edges in the first frame are smeared", state,
                     100 * look.edges.smeared_share(), look.edges.edges);
}

Camera Plan::source_camera(long index) const {
  const auto pose = context.subject_from_source.size() == 1 ? 0 : static_cast<std::size_t>(index);
  return {source->intrinsics(index), context.subject_from_source[pose], size()};
}

Camera Plan::in_source_world(const Camera& target) const {
  return {target.intrinsics, context.world.world_from_cam(target.world_from_cam), target.size};
}

void check_trajectory(const RunOptions& options) { named_spec(options); }

Plan make_plan(const RunOptions& options, const std::optional<GeometryFolder>& geometry, Monitor& monitor) {
  Plan plan;
  plan.options = options;
  plan.source = std::make_unique<SourceClip>(options, geometry, monitor);
  SourceClip& source = *plan.source;
  plan.trajectory = read_spec(options, source, monitor);
  const auto first = source.read(0);
  if (!first) fail(ErrorCode::file_damaged, "{}: not one frame of it can be read", options.video);
  const double radius = plan.trajectory.radius > 0 ? plan.trajectory.radius : subject_depth(*first);
  plan.context = make_context(plan.trajectory, source.intrinsics(0), source.size(), source.world_from_cam(),
                              source.frames(), radius, source.info().is_photo);
  plan.path = build_path(plan.trajectory, plan.context);
  plan.fps = output_fps(options, plan.trajectory, source.info());
  ThreadPool pool(options.threads);
  plan.look = look_at_scene(first->depth, plan.path, plan.context, pool);
  plan.choices = choose(source, plan.look, geometry, options);
  if (!plan.choices.plan.layers.choice) source.leave_out_background();
  for (const long frame : options.ply)
    if (frame >= source.frames())
      fail(ErrorCode::value_invalid, "--ply: found frame {}, wanted one of the {} source frames (0 to {})", frame,
           source.frames(), source.frames() - 1);
  warn_of_the_path(plan, monitor);
  return plan;
}

bool is_model_input(std::string_view name) {
  return name == "model" || name == "transformer" || name == "prompt_embeds" || name == "vae_fast";
}

std::vector<std::pair<std::string, std::string>> named_inputs(const RunOptions& o) {
  std::vector<std::pair<std::string, std::string>> inputs;
  for (const auto& [name, path] :
       std::initializer_list<std::pair<const char*, const std::string&>>{{"video", o.video},
                                                                         {"depth", o.depth},
                                                                         {"disparity", o.disparity},
                                                                         {"cameras", o.cameras},
                                                                         {"background", o.background},
                                                                         {"background_depth", o.background_depth},
                                                                         {"foreground", o.foreground},
                                                                         {"normals", o.normals},
                                                                         {"saliency_model", o.saliency_model},
                                                                         {"depth_model", o.depth_model},
                                                                         {"segmenter", o.segmenter},
                                                                         {"model", o.diffusion.model},
                                                                         {"transformer", o.diffusion.transformer},
                                                                         {"prompt_embeds", o.diffusion.prompt_embeds},
                                                                         {"vae_fast", o.diffusion.vae_fast},
                                                                         {"eval_reference", o.eval_reference},
                                                                         {"eval_cameras", o.eval_cameras}})
    if (!path.empty()) inputs.emplace_back(name, path);
  if (std::filesystem::exists(o.traj)) inputs.emplace_back("traj", o.traj);
  return inputs;
}

}  // namespace uwv::pipeline
