// SPDX-License-Identifier: Apache-2.0
#include "uwv/pipeline/run.h"

#include <algorithm>
#include <filesystem>
#include <functional>
#include <optional>

#include "pipeline/fingerprint.h"
#include "pipeline/geometry_stage.h"
#include "pipeline/recording_monitor.h"
#include "pipeline/resources.h"
#include "pipeline/stage.h"
#include "uwv/pipeline/environment.h"
#include "uwv/pipeline/option_table.h"
#include "uwv/render/gl_rasterizer.h"

namespace uwv {
namespace {

using namespace pipeline;
using nlohmann::ordered_json;

/// A stage as the run sees it.
struct Stage {
  std::string name;
  OptionScope scope;
  std::vector<std::string> files;  ///< It may write these; empty = not asked for.
  std::string reason;              ///< Why it is not asked for.
  std::function<ordered_json(const Workshop&, const OutputFolder&, const PartialFolder&)> make;
};

std::vector<Stage> stages_of(const RunOptions& o) {
  const bool completes = completion_of(o) != Completion::none, evaluates = !o.eval_reference.empty();
  const auto without_folder = [](auto make) {
    return [make](const Workshop& shop, const OutputFolder&, const PartialFolder& into) { return make(shop, into); };
  };
  std::vector<Stage> stages;
  stages.push_back(
      {"conditioning", OptionScope::conditioning, conditioning_files(o), "", without_folder(make_conditioning)});
  stages.push_back({"completion", OptionScope::completion, completes ? completion_files(o) : std::vector<std::string>{},
                    "--complete none", make_completion});
  stages.push_back({"presentation", OptionScope::presentation, presentation_files(o), "", make_presentation});
  stages.push_back({"evaluation", OptionScope::evaluation, evaluates ? evaluation_files(o) : std::vector<std::string>{},
                    "no --eval-reference", without_folder(make_evaluation)});
  return stages;
}

std::unique_ptr<Rasterizer> make_rasterizer(const RunOptions& options, ThreadPool& pool) {
  if (options.renderer == RendererChoice::cpu) return make_cpu_rasterizer(pool);
  if (options.renderer == RendererChoice::gl) return make_gl_rasterizer(make_gl_context(options.gl));
  try {
    std::unique_ptr<GlContext> context = make_gl_context(options.gl);
    if (!context->is_software()) return make_gl_rasterizer(std::move(context));
  } catch (const Error& without_gl) {
    if (without_gl.code() != ErrorCode::backend_missing) throw;
  }
  return make_cpu_rasterizer(pool);
}

ordered_json identities(const RunOptions& options) {
  ordered_json all = ordered_json::object();
  for (const auto& [name, path] : named_inputs(options)) {
    all[name] = is_model_input(name) ? checkpoint_identity(path) : input_identity(path);
    if (all[name].is_null()) fail(ErrorCode::file_not_found, "{}: no such file or folder", path);
    all[name]["path"] = path;
  }
  return all;
}

/// Keys of the stages that others build on; empty = that stage is not part of the run.
struct EarlierKeys {
  std::string geometry, conditioning;
};

/// The key of a stage: everything that decides its bytes, and the keys of what it builds on. Where a file lies does not
/// matter.
std::string stage_key(const Stage& stage, const Plan& plan, const Rasterizer& rasterizer, const ordered_json& inputs,
                      const EarlierKeys& earlier) {
  ordered_json options = to_json(plan.options, stage.scope);
  options.update(to_json(plan.options, OptionScope::clip));
  ordered_json files = ordered_json::object();
  for (const auto& [name, identity] : inputs.items()) {
    options.erase(name);
    if (name.starts_with("eval_") != (stage.scope == OptionScope::evaluation)) continue;
    if (is_model_input(name) && stage.scope != OptionScope::completion) continue;
    files[name] = identity;
    files[name].erase("path");
  }
  const ordered_json all = {{"stage", stage.name},
                            {"versions", component_versions()},
                            {"build", build_id()},
                            {"options", options},
                            {"inputs", files},
                            {"trajectory", to_json(plan.trajectory)},
                            {"renderer", rasterizer.name()},
                            {"geometry", earlier.geometry},
                            {"conditioning", earlier.conditioning}};
  return sha256(all.dump());
}

ordered_json to_json(const SceneLook& look) {
  return {{"near_depth", look.near_depth},
          {"far_depth", look.far_depth},
          {"has_parallax", look.has_parallax},
          {"parallax_px", look.parallax_px},
          {"disocclusion_px", look.disocclusion_px},
          {"uncovered_share", look.uncovered_share},
          {"max_rotation_deg", look.max_rotation_deg},
          {"max_translation_radii", look.max_translation},
          {"depth_edges", look.edges.edges},
          {"smeared_edges_share", look.edges.smeared_share()},
          {"first_return", look.first_return < 0 ? ordered_json() : ordered_json(look.first_return)}};
}

std::string_view to_string(StageSummary::Status status) {
  switch (status) {
    case StageSummary::Status::done: return "done";
    case StageSummary::Status::resumed: return "resumed";
    default: return "skipped";
  }
}

ordered_json to_json(const StageSummary& stage) {
  ordered_json json = {{"name", stage.name}, {"status", to_string(stage.status)}};
  if (stage.status == StageSummary::Status::skipped) {
    json["reason"] = stage.reason;
    return json;
  }
  json["seconds"] = stage.seconds;
  json["peak_bytes"] = stage.peak_bytes;
  json.update(stage.facts);
  json["files"] = stage.files;
  return json;
}

ordered_json clip_record(const Plan& plan) {
  const ClipInfo& clip = plan.source->info();
  return {{"format", clip.format},
          {"source_size", fmt::format("{}x{}", clip.source_size.width, clip.source_size.height)},
          {"size", fmt::format("{}x{}", clip.size.width, clip.size.height)},
          {"frames", plan.source->frames()},
          {"fps", clip.fps},
          {"is_photo", clip.is_photo},
          {"source_cameras",
           plan.source->has_cameras() ? "given or estimated" : "none given: taken as a camera that never moves"}};
}

ordered_json path_record(const Plan& plan) {
  return {{"frames", plan.frames()},
          {"fps", plan.fps},
          {"radius", plan.context.world.radius()},
          {"trajectory", ordered_json::parse(to_json(plan.trajectory))}};
}

/// run.json so far.
ordered_json run_record(const Plan& plan, const ordered_json& inputs, const RunSummary& summary,
                        const std::string& status) {
  ordered_json versions = ordered_json::object(), stages = ordered_json::array();
  for (const auto& [name, text] : component_versions()) versions[name] = text;
  for (const StageSummary& stage : summary.stages) stages.push_back(to_json(stage));
  return {{"program", "uwv_app"},
          {"status", status},
          {"versions", versions},
          {"options", uwv::to_json(plan.options)},
          {"inputs", inputs},
          {"clip", clip_record(plan)},
          {"path", path_record(plan)},
          {"look", to_json(summary.look)},
          {"scene_profile", pipeline::to_json(plan.choices.profile)},
          {"choices", plan.choices.to_json()},
          {"stages", stages},
          {"warnings", summary.warnings}};
}

/// What a marker keeps of a stage, and back.
ordered_json to_marker(const StageSummary& stage) {
  return {{"seconds", stage.seconds}, {"peak_bytes", stage.peak_bytes}, {"facts", stage.facts}, {"files", stage.files}};
}

StageSummary resumed_stage(const std::string& name, const ordered_json& record) {
  StageSummary stage;
  stage.name = name;
  stage.status = StageSummary::Status::resumed;
  stage.seconds = record.value("seconds", 0.0);
  stage.peak_bytes = record.value("peak_bytes", std::uint64_t{0});
  stage.facts = record.value("facts", ordered_json::object());
  stage.files = record.value("files", std::vector<std::string>{});
  return stage;
}

/// Writes and publishes a stage; `make` fills the folder it is given and answers with the stage's facts.
StageSummary make_stage(const std::string& name, const std::vector<std::string>& files, const std::string& key,
                        OutputFolder& folder, const std::function<ordered_json(const PartialFolder&)>& make) {
  StageSummary summary;
  summary.name = name;
  const StageClock clock;
  const PartialFolder partial = folder.begin(name);
  summary.facts = make(partial);
  summary.seconds = clock.seconds();
  summary.peak_bytes = clock.peak_bytes();
  if (summary.facts.contains("frames"))
    summary.facts["frames_per_second"] = summary.facts["frames"].get<double>() / std::max(summary.seconds, 1e-9);
  summary.files = files;
  folder.publish(name, key, partial, to_marker(summary));
  return summary;
}

StageSummary skipped_stage(const std::string& name, const std::string& reason) {
  return {.name = name, .status = StageSummary::Status::skipped, .reason = reason, .facts = {}, .files = {}};
}

/// The stage as it was finished before, or made now.
StageSummary found_or_made(const std::string& name, const std::vector<std::string>& files, const std::string& key,
                           bool overwrite, OutputFolder& folder, Monitor& monitor,
                           const std::function<ordered_json(const PartialFolder&)>& make) {
  if (const auto finished = overwrite ? std::nullopt : folder.finished(name, key))
    return resumed_stage(name, *finished);
  if (folder.has_marker(name) && !overwrite)
    monitor.warn(
        fmt::format("{}: holds the {} of other options or inputs; it is made anew", folder.path().string(), name));
  return make_stage(name, files, key, folder, make);
}

/// The geometry that all else builds on, estimated where the options give none.
struct GeometryOfRun {
  std::optional<GeometryFolder> folder;  ///< Empty: depth files are read directly.
  std::string key;                       ///< Empty: nothing was estimated.
  StageSummary summary;
};

GeometryOfRun given_geometry(const RunOptions& options) {
  const std::string flag = options.depth.empty() ? "--disparity" : "--depth";
  return {open_geometry_folder(options.depth), "", skipped_stage(geometry_folder_name, flag + " is given")};
}

/// Before anything is read: a run that cannot end well should not begin.
void check_components(const RunOptions& options, const RunComponents& components) {
  const auto need = [](const std::string& folder, bool is_there, const char* flag) {
    if (!folder.empty() && !is_there)
      fail(ErrorCode::backend_missing,
           "{}: this program was built without TorchScript networks; run scripts/setup without --no-torch and build "
           "again, or leave {} out",
           folder, flag);
  };
  need(options.depth_model, static_cast<bool>(components.open_depth_network), "--depth-model");
  need(options.segmenter, static_cast<bool>(components.open_foreground_tracker), "--segmenter");
  if (!options.diffusion.model.empty() && !components.complete_views)
    fail(ErrorCode::backend_missing,
         "{}: this program was built without libtorch; run scripts/setup without --no-torch and build again, or take "
         "--complete inpaint for a draft without a model",
         options.diffusion.model);
  if (!options.diffusion.model.empty() && components.check_checkpoint) components.check_checkpoint(options.diffusion);
  need(std::filesystem::is_directory(options.saliency_model) ? options.saliency_model : "",
       static_cast<bool>(components.open_foreground_network), "--saliency-model");
}

/// What the estimation reads.
constexpr std::string_view geometry_inputs[] = {"video",          "depth",       "foreground", "background",
                                                "saliency_model", "depth_model", "segmenter"};

GeometryOfRun estimated_geometry(const RunOptions& options, const RunComponents& components, OutputFolder& folder,
                                 Monitor& monitor) {
  ordered_json inputs = identities(options);
  for (const auto& [name, path] : named_inputs(options))
    if (std::find(std::begin(geometry_inputs), std::end(geometry_inputs), name) == std::end(geometry_inputs))
      inputs.erase(name);
  GeometryOfRun geometry;
  geometry.key = geometry_key(options, inputs);
  geometry.summary = found_or_made(geometry_folder_name, {geometry_folder_name}, geometry.key, options.overwrite,
                                   folder, monitor, [&](const PartialFolder& into) {
                                     ThreadPool pool(options.threads);
                                     return make_geometry(options, components, pool, monitor, into);
                                   });
  geometry.folder = open_geometry_folder(folder.file(geometry_folder_name));
  return geometry;
}

/// Runs the stages one after another, each only if its result is not there yet.
class Runner {
 public:
  Runner(const Plan& plan, const GeometryOfRun& geometry, const RunComponents& components, OutputFolder& folder,
         RecordingMonitor& monitor)
      : plan_(plan),
        components_(components),
        folder_(folder),
        monitor_(monitor),
        pool_(plan.options.threads),
        rasterizer_(make_rasterizer(plan.options, pool_)),
        inputs_(identities(plan.options)) {
    summary_.out = folder.path().string();
    summary_.look = plan.look;
    summary_.stages.push_back(geometry.summary);
    keys_.geometry = geometry.key;
  }

  RunSummary run(const std::vector<Stage>& stages) {
    try {
      for (const Stage& stage : stages) run_stage(stage);
    } catch (const std::exception& stopped) {
      const bool something_is_there = summary_.stages.size() > 1 || !keys_.geometry.empty();
      if (something_is_there) write_record(fmt::format("stopped: {}", stopped.what()));
      throw;
    }
    write_record("finished");
    return summary_;
  }

 private:
  void run_stage(const Stage& stage) {
    if (stage.files.empty()) {
      folder_.retract(stage.name);
      summary_.stages.push_back(skipped_stage(stage.name, stage.reason));
      return;
    }
    const std::string key = stage_key(stage, plan_, *rasterizer_, inputs_, keys_);
    if (stage.scope == OptionScope::conditioning) keys_.conditioning = key;
    const Workshop shop{components_, plan_, *rasterizer_, pool_, monitor_};
    summary_.stages.push_back(
        found_or_made(stage.name, stage.files, key, plan_.options.overwrite, folder_, monitor_,
                      [&](const PartialFolder& into) { return stage.make(shop, folder_, into); }));
  }

  void write_record(const std::string& status) {
    summary_.warnings = monitor_.warnings();
    folder_.write_record(run_record(plan_, inputs_, summary_, status));
  }

  const Plan& plan_;
  const RunComponents& components_;
  OutputFolder& folder_;
  RecordingMonitor& monitor_;
  ThreadPool pool_;
  std::unique_ptr<Rasterizer> rasterizer_;
  ordered_json inputs_;
  EarlierKeys keys_;
  RunSummary summary_;
};

RunSummary run_in(OutputFolder& folder, const Plan& plan, const GeometryOfRun& geometry,
                  const RunComponents& components, const std::vector<Stage>& stages,
                  const std::vector<std::string>& files, RecordingMonitor& monitor, const LookListener& on_look) {
  if (on_look) on_look(plan.look);
  folder.refuse_foreign(files, plan.options.overwrite);
  return Runner(plan, geometry, components, folder, monitor).run(stages);
}

}  // namespace

RunSummary run(const RunOptions& options, Monitor& caller, const LookListener& on_look,
               const RunComponents& components) {
  options.check();
  check_components(options, components);
  RecordingMonitor monitor(caller);
  const std::vector<Stage> stages = stages_of(options);
  std::vector<std::string> files = {"run.json"}, inputs;
  for (const Stage& stage : stages) files.insert(files.end(), stage.files.begin(), stage.files.end());
  if (estimates_geometry(options)) files.emplace_back(geometry_folder_name);
  for (const auto& [name, path] : named_inputs(options)) inputs.push_back(path);
  refuse_overwriting_inputs(options.out_folder(), files, inputs);

  // With depth given, everything wrong with the inputs is found before the folder exists.
  if (!estimates_geometry(options)) {
    const GeometryOfRun geometry = given_geometry(options);
    const Plan plan = make_plan(options, geometry.folder, monitor);
    OutputFolder folder(options.out_folder());
    return run_in(folder, plan, geometry, components, stages, files, monitor, on_look);
  }
  check_trajectory(options);
  OutputFolder folder(options.out_folder());
  folder.refuse_foreign(files, options.overwrite);
  const GeometryOfRun geometry = estimated_geometry(options, components, folder, monitor);
  const Plan plan = make_plan(options, geometry.folder, monitor);
  return run_in(folder, plan, geometry, components, stages, files, monitor, on_look);
}

SceneLook look(const RunOptions& options, Monitor& monitor) {
  options.check();
  if (estimates_geometry(options))
    fail(
        ErrorCode::value_invalid,
        "{}: a look needs depth: pass --depth, which may be the folder 'geometry' that a run without --depth leaves in "
        "its --out",
        options.video);
  return make_plan(options, given_geometry(options).folder, monitor).look;
}

std::string RunSummary::report() const {
  std::string text;
  for (const StageSummary& stage : stages) {
    if (stage.status == StageSummary::Status::skipped) {
      text += fmt::format("{:<13} skipped ({})\n", stage.name, stage.reason);
      continue;
    }
    text += fmt::format("{:<13} {} in {:.2f} s", stage.name,
                        stage.status == StageSummary::Status::done ? "made" : "was there already, made", stage.seconds);
    if (stage.facts.contains("frames_per_second"))
      text += fmt::format(", {} frames, {:.1f} frames/s", stage.facts["frames"].get<long>(),
                          stage.facts["frames_per_second"].get<double>());
    text += fmt::format(", peak {:.0f} MiB\n", static_cast<double>(stage.peak_bytes) / (1024.0 * 1024.0));
    if (stage.facts.contains("brief")) text += fmt::format("  {}\n", stage.facts["brief"].get<std::string>());
    for (const auto& method : stage.facts.value("methods", ordered_json::array()))
      text += fmt::format("  {:<20} PSNR {} dB, SSIM {}, valid {:.4f}, PSNR where all are valid {} dB\n",
                          method["method"].get<std::string>(), method["psnr"].dump().substr(0, 6),
                          method["ssim"].dump().substr(0, 6), method["valid_share"].get<double>(),
                          method["psnr_where_all_valid"].dump().substr(0, 6));
  }
  return text + fmt::format("results in {}/\n", out);
}

}  // namespace uwv
