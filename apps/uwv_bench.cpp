// SPDX-License-Identifier: Apache-2.0
// Measures what docs/performance.md claims, and saves the scenes it measures with.
#include <CLI/CLI.hpp>

#include <fstream>
#include <functional>
#include <sstream>

#include "bench/benchmarks.h"
#ifdef UWV_BENCH_MODEL
#include "bench/model_commands.h"
#endif
#include "uwv/core/error.h"

namespace uwv::bench {
namespace {

/// The command line: which benchmark, with which options.
class CommandLine {
 public:
  explicit CommandLine(CLI::App& app) {
    app.require_subcommand(1);
    CLI::App& render = subcommand(
        app, "render", "Milliseconds of each pass and of Algorithm 1; example: uwv_bench render --json r.json",
        render_speed);
    runs_flag(render);
    render.add_option("--sizes", sizes_, "Picture sizes as WxH,..")->delimiter(',')->capture_default_str();
    render.add_flag("--gl,!--no-gl", options_.gl, "Also measure OpenGL where a backend works");

    CLI::App& accuracy =
        subcommand(app, "accuracy",
                   "Options against the truth of a synthetic scene; example: uwv_bench accuracy --scene boxes_room",
                   render_accuracy);
    runs_flag(accuracy);
    size_flags(accuracy);
    accuracy.add_option("--scene", options_.scene, "Stock scene of the accuracy table")->capture_default_str();
    accuracy.add_option("--steps", options_.steps, "Frames of the path to each angle")->capture_default_str();
    accuracy.add_option("--plot", options_.plot, "Also show the options' speed and accuracy in this SVG file");

    CLI::App& real = subcommand(
        app, "real", "Methods and options against what a second real camera saw; example: uwv_bench real --rgbd DIR",
        real_views);
    runs_flag(real);
    real.add_option("--motorcycle", options_.motorcycle, "Folder with the stereo pair scripts/setup fetches")
        ->capture_default_str();
    real.add_option("--rgbd", options_.rgbd, "Folder with image/, depth/ and test_scene/trajectory.log");
    real.add_option("--pairs", pairs_, "Frames of --rgbd as SOURCE:TARGET,..")->delimiter(',')->capture_default_str();
    real.add_flag("--no-resize", options_.no_resize, "Pictures at their own size, not at the one uwv_app works at");

    CLI::App& alignment = subcommand(
        app, "alignment", "Aligning relative depth: losses, samples, smoothing; example: uwv_bench alignment --runs 3",
        alignment_accuracy);
    runs_flag(alignment);
    size_flags(alignment);
    alignment.add_option("--scene", options_.scene, "Stock scene whose depth is aligned")->capture_default_str();
    alignment.add_option("--recording", options_.recording, "Also the flicker of this recording; as for geometry");
    range_flags(alignment);

    CLI::App& scene = subcommand(
        app, "scene",
        "Saves a stock scene as input for uwv_app; example: uwv_bench scene --scene boxes_room --out room", save_scene);
    size_flags(scene);
    scene.add_option("--scene", options_.scene, "Which stock scene")->capture_default_str();
    scene.add_option("--out", options_.out, "Folder to save into")->required();

    CLI::App& found = subcommand(
        app, "geometry",
        "Cameras and depth found from pictures, against the truth; example: uwv_bench geometry --recording hall",
        geometry);
    range_flags(found);
    found.add_option("--recording", options_.recording, "Folder of a clip with known cameras and depth")->required();
    found.add_option("--tables", options_.tables, "Which of cameras,depth,stages,views; or camera_options, choices")
        ->delimiter(',')
        ->capture_default_str();
    found.add_option("--pairs", pairs_, "Frames of the views as SOURCE:TARGET,.., of those taken")
        ->delimiter(',')
        ->capture_default_str();
    found.add_flag("--no-resize", options_.no_resize, "Pictures at their own size, not at the one uwv_app works at");
    mvs_runs_flag(found);
    found.add_option("--plot", options_.plot, "Also show speed and accuracy of the depth table in this SVG file");
    colmap_flags(found);

    CLI::App& stereo = subcommand(
        app, "stereo", "Depth of stereo pairs by clips' matcher; example: uwv_bench stereo --stereo .cache/demo",
        stereo_depth);
    mvs_runs_flag(stereo);
    stereo.add_option("--stereo", options_.stereo, "Folders of pairs: Middlebury's, or the one scripts/setup fetches")
        ->delimiter(',')
        ->required();

    CLI::App& moves = subcommand(
        app, "moving",
        "What moves before a moving camera and what it hides, against a synthetic scene; example: uwv_bench moving",
        moving);
    size_flags(moves);

    CLI::App& rendered = subcommand(
        app, "rendered", "Cameras and depth of easy and hard rendered clips; example: uwv_bench rendered --models DIR",
        rendered_clips);
    size_flags(rendered);
    frames_flag(rendered);
    models_flag(rendered);
    rendered.add_option("--cases", options_.cases, "Which clips; all unless given")->delimiter(',');
    mvs_runs_flag(rendered);
    colmap_flags(rendered);

    CLI::App& clip = subcommand(
        app, "clip", "Saves a clip of a hall with exact truth; example: uwv_bench clip --models DIR --out hall",
        save_clip);
    size_flags(clip);
    frames_flag(clip);
    models_flag(clip);
    clip.add_flag("--figure,!--no-figure", options_.figure, "A figure walks through the picture");
    clip.add_option("--figure-distance", options_.figure_distance, "Units from camera to figure; 2 fills a third")
        ->capture_default_str();
    clip.add_option("--texture", options_.texture, "How much texture the models have, 0 to 1")->capture_default_str();
    clip.add_option("--travel", options_.travel, "How far the camera goes; 1 = three units")->capture_default_str();
    clip.add_option("--out", options_.out, "Folder to save into")->required();
#ifdef UWV_BENCH_MODEL
    add_model_commands(app, model_benchmark_, json_path_);
#endif
  }

  std::vector<Table> run() {
    if (model_benchmark_) return model_benchmark_();
    options_.pairs.clear();
    for (const std::string& pair : pairs_) options_.pairs.push_back(frames_of(pair));
    options_.sizes.clear();
    for (const std::string& size : sizes_) options_.sizes.push_back(size_of(size));
    return benchmark_(options_);
  }

  void write_json(const std::vector<Table>& tables) const {
    if (json_path_.empty()) return;
    nlohmann::ordered_json json;
    for (const Table& table : tables) json[table.name()] = table.json();
    std::ofstream file(json_path_);
    file << json.dump(2) << '\n';
    if (!file.flush()) fail(ErrorCode::output_failed, "{}: cannot be written", json_path_);
  }

 private:
  using Benchmark = std::function<std::vector<Table>(const BenchOptions&)>;

  /// With the flags all of them have.
  CLI::App& subcommand(CLI::App& app, const char* name, const char* help, Benchmark function) {
    CLI::App& sub = *app.add_subcommand(name, help);
    sub.add_option("--threads", options_.threads, "0 = all processors")->capture_default_str();
    sub.add_option("--json", json_path_, "Also write the figures to this file");
    sub.callback([this, function = std::move(function)] { benchmark_ = function; });
    return sub;
  }

  void runs_flag(CLI::App& sub) {
    sub.add_option("--runs", options_.runs, "Measured runs a figure; the median is reported")->capture_default_str();
  }

  void models_flag(CLI::App& sub) {
    sub.add_option("--models", options_.models, "Folder with kaykit_dungeon_CC0 and kaykit_adventurers_CC0")
        ->required();
  }

  void colmap_flags(CLI::App& sub) {
    sub.add_option("--colmap", options_.colmap_folder, "Also run COLMAP, in this folder");
    sub.add_option("--colmap-patience", options_.colmap_patience, "Seconds for a run of COLMAP")->capture_default_str();
  }

  void mvs_runs_flag(CLI::App& sub) {
    sub.add_option("--mvs-runs", options_.mvs_runs, "Runs of each option of stereo; the median time is reported")
        ->capture_default_str();
  }

  void frames_flag(CLI::App& sub) {
    sub.add_option("--frames", options_.frames, "Frames of the clip, at most")->capture_default_str();
  }

  void range_flags(CLI::App& sub) {
    frames_flag(sub);
    sub.add_option("--start", options_.start, "First frame of the recording to take")->capture_default_str();
    sub.add_option("--stride", options_.stride, "Take every so many-th frame")->capture_default_str();
  }

  void size_flags(CLI::App& sub) {
    sub.add_option("--width", options_.size.width, "Picture width")->capture_default_str();
    sub.add_option("--height", options_.size.height, "Picture height")->capture_default_str();
  }

  static Size size_of(const std::string& text) {
    Size size;
    char by = 0, rest = 0;
    std::istringstream words(text);
    if (!(words >> size.width >> by >> size.height) || by != 'x' || words >> rest)
      fail(ErrorCode::value_invalid, "--sizes: found '{}', wanted sizes such as 832x480", text);
    return size;
  }

  static std::pair<long, long> frames_of(const std::string& text) {
    long from = 0, to = 0;
    char colon = 0, rest = 0;
    std::istringstream words(text);
    if (!(words >> from >> colon >> to) || colon != ':' || words >> rest)
      fail(ErrorCode::value_invalid, "--pairs: found '{}', wanted two frames such as 0:10", text);
    return {from, to};
  }

  BenchOptions options_;
  std::vector<std::string> pairs_{"0:10", "20:40", "60:90"};
  std::vector<std::string> sizes_{"416x240", "832x480", "1664x960"};
  std::string json_path_;
  Benchmark benchmark_;
  std::function<std::vector<Table>()> model_benchmark_;  ///< When one of "model" was chosen.
};

}  // namespace
}  // namespace uwv::bench

int main(int argc, char** argv) {
  CLI::App app("Measures speed and accuracy of libuwv on this machine.");
  uwv::bench::CommandLine command(app);
  CLI11_PARSE(app, argc, argv);
  try {
    const std::vector<uwv::bench::Table> tables = command.run();
    for (const uwv::bench::Table& table : tables) table.print();
    command.write_json(tables);
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "uwv_bench: {}\n", error.what());
    return 2;
  }
}
