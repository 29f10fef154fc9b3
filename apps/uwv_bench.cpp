// SPDX-License-Identifier: Apache-2.0
// Measures what docs/performance.md claims.
#include <CLI/CLI.hpp>

#include <fstream>
#include <functional>

#include "bench/benchmarks.h"
#include "uwv/core/error.h"

int main(int argc, char** argv) {
  using namespace uwv::bench;
  CLI::App app("Measures speed and accuracy of libuwv on this machine.");
  app.require_subcommand(1);
  BenchOptions options;
  std::string json_path;
  std::function<std::vector<Table>(const BenchOptions&)> benchmark;

  const auto subcommand = [&](const char* name, const char* help, auto function) {
    CLI::App* sub = app.add_subcommand(name, help);
    sub->add_option("--width", options.size.width, "Picture width")->capture_default_str();
    sub->add_option("--height", options.size.height, "Picture height")->capture_default_str();
    sub->add_option("--runs", options.runs, "Measured runs a figure; the median is reported")->capture_default_str();
    sub->add_option("--threads", options.threads, "0 = all processors")->capture_default_str();
    sub->add_flag("--gl,!--no-gl", options.gl, "Also measure OpenGL where a backend works");
    sub->add_option("--scene", options.scene, "Stock scene of the accuracy table")->capture_default_str();
    sub->add_option("--steps", options.steps, "Frames of the path to each angle")->capture_default_str();
    sub->add_option("--json", json_path, "Also write the figures to this file");
    sub->callback([&benchmark, function] { benchmark = function; });
  };
  subcommand("render", "Milliseconds of each pass and of Algorithm 1; example: uwv_bench render --json render.json",
             render_speed);
  subcommand("accuracy",
             "Options against the truth of a synthetic scene; example: uwv_bench accuracy --scene boxes_room",
             render_accuracy);
  CLI11_PARSE(app, argc, argv);

  try {
    nlohmann::ordered_json json;
    for (const Table& table : benchmark(options)) {
      table.print();
      json[table.name()] = table.json();
    }
    if (json_path.empty()) return 0;
    std::ofstream file(json_path);
    file << json.dump(2) << '\n';
    if (!file.flush()) uwv::fail(uwv::ErrorCode::output_failed, "{}: cannot be written", json_path);
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "uwv_bench: {}\n", error.what());
    return 2;
  }
}
