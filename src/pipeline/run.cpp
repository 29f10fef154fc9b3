// SPDX-License-Identifier: Apache-2.0
#include "uwv/pipeline/run.h"

#include <functional>
#include <optional>

#include "pipeline/fingerprint.h"
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
  const bool completes = o.complete != Completion::none, evaluates = !o.eval_reference.empty();
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
    all[name] = input_identity(path);
    if (all[name].is_null()) fail(ErrorCode::file_not_found, "{}: no such file or folder", path);
    all[name]["path"] = path;
  }
  return all;
}

/// The key of a stage: everything that decides its bytes, and the key of the conditioning it builds on. Where a file
/// lies does not matter.
std::string stage_key(const Stage& stage, const Plan& plan, const Rasterizer& rasterizer, const ordered_json& inputs,
                      const std::string& conditioning_key) {
  ordered_json options = to_json(plan.options, stage.scope);
  ordered_json files = ordered_json::object();
  for (const auto& [name, identity] : inputs.items()) {
    options.erase(name);
    if (name.starts_with("eval_") != (stage.scope == OptionScope::evaluation)) continue;
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
                            {"conditioning", conditioning_key}};
  return sha256(all.dump());
}

ordered_json to_json(const SceneLook& look) {
  return {{"near_depth", look.near_depth},
          {"far_depth", look.far_depth},
          {"has_parallax", look.has_parallax},
          {"parallax_px", look.parallax_px},
          {"disocclusion_px", look.disocclusion_px},
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
          {"source_cameras", plan.source->has_cameras() ? "given" : "none given: taken as a camera that never moves"}};
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
  return {{"program", "uwv_app"},      {"status", status},
          {"versions", versions},      {"options", uwv::to_json(plan.options)},
          {"inputs", inputs},          {"clip", clip_record(plan)},
          {"path", path_record(plan)}, {"look", to_json(summary.look)},
          {"stages", stages},          {"warnings", summary.warnings}};
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

StageSummary make_stage(const Stage& stage, const std::string& key, const Workshop& shop, OutputFolder& folder) {
  StageSummary summary;
  summary.name = stage.name;
  const StageClock clock;
  const PartialFolder partial = folder.begin(stage.name);
  summary.facts = stage.make(shop, folder, partial);
  summary.seconds = clock.seconds();
  summary.peak_bytes = clock.peak_bytes();
  if (summary.facts.contains("frames"))
    summary.facts["frames_per_second"] = summary.facts["frames"].get<double>() / std::max(summary.seconds, 1e-9);
  summary.files = stage.files;
  folder.publish(stage.name, key, partial, to_marker(summary));
  return summary;
}

/// Runs the stages one after another, each only if its result is not there yet.
class Runner {
 public:
  Runner(const Plan& plan, OutputFolder& folder, RecordingMonitor& monitor)
      : plan_(plan),
        folder_(folder),
        monitor_(monitor),
        pool_(plan.options.threads),
        rasterizer_(make_rasterizer(plan.options, pool_)),
        inputs_(identities(plan.options)) {
    summary_.out = folder.path().string();
    summary_.look = plan.look;
  }

  RunSummary run(const std::vector<Stage>& stages) {
    try {
      std::string conditioning_key;
      for (const Stage& stage : stages) run_stage(stage, conditioning_key);
    } catch (const std::exception& stopped) {
      if (!summary_.stages.empty()) write_record(fmt::format("stopped: {}", stopped.what()));
      throw;
    }
    write_record("finished");
    return summary_;
  }

 private:
  void run_stage(const Stage& stage, std::string& conditioning_key) {
    if (stage.files.empty()) {
      folder_.retract(stage.name);
      summary_.stages.push_back({.name = stage.name,
                                 .status = StageSummary::Status::skipped,
                                 .reason = stage.reason,
                                 .facts = {},
                                 .files = {}});
      return;
    }
    const std::string key = stage_key(stage, plan_, *rasterizer_, inputs_, conditioning_key);
    if (stage.scope == OptionScope::conditioning) conditioning_key = key;
    const auto finished = plan_.options.overwrite ? std::nullopt : folder_.finished(stage.name, key);
    if (finished) {
      summary_.stages.push_back(resumed_stage(stage.name, *finished));
      return;
    }
    if (folder_.has_marker(stage.name) && !plan_.options.overwrite)
      monitor_.warn(
          fmt::format("{}: holds the {} of other options or inputs; it is made anew", summary_.out, stage.name));
    summary_.stages.push_back(make_stage(stage, key, {plan_, *rasterizer_, pool_, monitor_}, folder_));
  }

  void write_record(const std::string& status) {
    summary_.warnings = monitor_.warnings();
    folder_.write_record(run_record(plan_, inputs_, summary_, status));
  }

  const Plan& plan_;
  OutputFolder& folder_;
  RecordingMonitor& monitor_;
  ThreadPool pool_;
  std::unique_ptr<Rasterizer> rasterizer_;
  ordered_json inputs_;
  RunSummary summary_;
};

}  // namespace

RunSummary run(const RunOptions& options, Monitor& caller, const LookListener& on_look) {
  options.check();
  RecordingMonitor monitor(caller);
  const std::vector<Stage> stages = stages_of(options);
  std::vector<std::string> files = {"run.json"}, inputs;
  for (const Stage& stage : stages) files.insert(files.end(), stage.files.begin(), stage.files.end());
  for (const auto& [name, path] : named_inputs(options)) inputs.push_back(path);
  refuse_overwriting_inputs(options.out_folder(), files, inputs);

  const Plan plan = make_plan(options, monitor);
  if (on_look) on_look(plan.look);
  OutputFolder folder(options.out_folder());
  folder.refuse_foreign(files, options.overwrite);
  return Runner(plan, folder, monitor).run(stages);
}

SceneLook look(const RunOptions& options, Monitor& monitor) {
  options.check();
  return make_plan(options, monitor).look;
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
    for (const auto& method : stage.facts.value("methods", ordered_json::array()))
      text += fmt::format("  {:<20} PSNR {} dB, SSIM {}, valid {:.4f}, PSNR where all are valid {} dB\n",
                          method["method"].get<std::string>(), method["psnr"].dump().substr(0, 6),
                          method["ssim"].dump().substr(0, 6), method["valid_share"].get<double>(),
                          method["psnr_where_all_valid"].dump().substr(0, 6));
  }
  return text + fmt::format("results in {}/\n", out);
}

}  // namespace uwv
