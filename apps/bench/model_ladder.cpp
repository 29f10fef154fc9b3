// SPDX-License-Identifier: Apache-2.0
// What each rung of the model's ladder costs in accuracy: clips completed with the same noise, against many exact
// steps.
#include <filesystem>

#include "bench/completed_clip.h"
#include "bench/model_commands.h"
#include "bench/plot.h"

namespace uwv::bench {
namespace {

struct Rung {
  std::string name;
  ModelOptions options;
};

std::vector<Rung> rungs(const ModelOptions& exact) {
  using model::SamplerKind;
  std::vector<Rung> all;
  const auto add = [&](const std::string& name, auto change) {
    Rung rung{name, exact};
    change(rung.options);
    all.push_back(std::move(rung));
  };
  for (const auto kind : {SamplerKind::euler, SamplerKind::euler_plain, SamplerKind::unipc, SamplerKind::dpmpp})
    for (const int steps : {4, 8, 16, 25, 50})
      if (kind != exact.sampler || steps != exact.steps)
        add(fmt::format("{} {}", to_string(kind), steps), [&](ModelOptions& o) {
          o.sampler = kind;
          o.steps = steps;
        });
  for (const double share : {0.75, 0.5, 0.25, 0.0})
    add(fmt::format("cfg_share {}", share), [&](ModelOptions& o) { o.cfg_share = share; });
  for (const double threshold : {0.02, 0.05, 0.1, 0.2, 0.3})
    add(fmt::format("step_cache {}", threshold), [&](ModelOptions& o) { o.step_cache = threshold; });
  for (const int margin : {4, 2, 1, 0})
    add(fmt::format("skip_known {}", margin), [&](ModelOptions& o) { o.skip_known = margin; });
  add("bf16_stored", [](ModelOptions& o) { o.weights = WeightsForm::bf16_stored; });
  add("bf16", [](ModelOptions& o) { o.weights = WeightsForm::bf16; });
  add("int8_stored", [](ModelOptions& o) { o.weights = WeightsForm::int8_stored; });
  add("int8", [](ModelOptions& o) { o.weights = WeightsForm::int8; });
  add("vae bf16", [](ModelOptions& o) { o.vae_precision = VaeNumbers::bf16; });
  return all;
}

}  // namespace

std::vector<Table> measure_ladder(const ModelBenchOptions& options) {
  ModelOptions exact;
  exact.model = options.model;
  exact.transformer = options.transformer;
  exact.prompt = "a street at night";
  exact.prompt_embeds = options.prompt_embeds;
  exact.sampler = model::SamplerKind::unipc;
  exact.steps = 50;
  exact.guidance = 4;
  exact.seed = static_cast<long>(options.seed);
  exact.weights = WeightsForm::f32;
  exact.colour_correction = false;
  exact.prompt_cache = (std::filesystem::temp_directory_path() / "uwv-bench-prompts").string();
  const RenderedClip clip = moving_pattern({options.width, options.height}, options.frames);
  const Completed truth = complete(exact, clip, options.threads);

  Table table("ladder", {"rung", "passes", "denoising_s", "psnr_db"});
  Panel panel{"Steps left out", "PSNR against 50 exact steps, dB", AxisScale::linear, {}, Better::high};
  const auto seconds = [](const Completed& one) { return one.summary.step_seconds * one.summary.steps; };
  table.add({"unipc 50, the measure", truth.summary.passes, seconds(truth), "-"});
  for (const Rung& rung : rungs(exact)) {
    const Completed one = complete(rung.options, clip, options.threads);
    const double quality = psnr(one.frames, truth.frames);
    table.add({rung.name, one.summary.passes, seconds(one), quality});
    panel.dots.push_back({rung.name, static_cast<double>(one.summary.passes), quality, rung.name == "euler 8"});
  }
  if (!options.plot.empty()) write_plot(options.plot, "passes of the transformer", {panel});
  return {table};
}

}  // namespace uwv::bench
