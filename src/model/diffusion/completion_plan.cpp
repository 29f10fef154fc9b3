// SPDX-License-Identifier: Apache-2.0
#include <sys/stat.h>

#include <algorithm>
#include <filesystem>

#include "model/diffusion/clip_conditions.h"
#include "model/diffusion/completion_setup.h"
#include "model/diffusion/machine_speed.h"
#include "model/layers/torch_scope.h"
#include "model/text/umt5_encoder.h"
#include "uwv/model/view_completion.h"

namespace uwv {
namespace {

using namespace model;

std::uint64_t folder_bytes(const std::string& folder) {
  std::uint64_t bytes = 0;
  if (!folder.empty())
    for (const auto& entry : std::filesystem::directory_iterator(folder))
      if (entry.is_regular_file() && entry.path().extension() == ".safetensors") bytes += entry.file_size();
  return bytes;
}

double gib(double bytes) { return bytes / (1024.0 * 1024.0 * 1024.0); }

/// Of one pass of the transformer over one window.
struct PassTime {
  double gflops = 0, seconds = 0;
};

/// What a pass takes besides products: norms, gates, the feed-forward's curve. Of all forms a fifth of the products'
/// time at 1.3B's width, docs/performance.md.
constexpr double beside_products = 1.2;

PassTime pass_time(const CompletionSetup& setup, const PartCost& cost) {
  const LinearForm form = setup.rungs.form;
  const PassSize& pass = setup.job.pass;
  const double layers = linear_speed(form, setup.config.dim(), setup.device);
  const double attention = attention_speed(form, setup.config.head_dim, pass.tokens, setup.device);
  double seconds = beside_products * ((cost.flops - cost.attention_flops) / layers + cost.attention_flops / attention);
  if (cost.rounded > 0)
    seconds +=
        cost.rounded / rounding_speed(form, static_cast<int>(size_of(pass.stored)), setup.config.dim(), setup.device);
  return {layers / 1e9, seconds / pass.batch};
}

/// Of what encodes and of what decodes.
struct ConvolutionSpeeds {
  explicit ConvolutionSpeeds(const CompletionSetup& setup)
      : encoding(convolution_speed(setup.rungs.vae.precision, setup.device)),
        decoding(setup.job.fast
                     ? convolution_speed(setup.rungs.vae.precision, setup.device, setup.job.fast->levels.back())
                     : encoding) {}
  double encoding, decoding;
};

CompletionPlan::Stage encoding_stage(const CompletionSetup& setup, const ConvolutionSpeeds& speeds) {
  const JobSize& job = setup.job;
  const PartCost clip = vae_cost(setup.vae, setup.rungs.vae, job.clip, VaeWay::encode);
  double flops = 2 * clip.flops;  // what is known, and what lies in the holes
  if (job.pass.reference_tokens > 0) {
    const ClipSize reference{std::min(reference_frames, job.clip.frames), job.clip.height, job.clip.width};
    flops += vae_cost(setup.vae, setup.rungs.vae, reference, VaeWay::encode).flops *
             static_cast<double>(setup.windows.size());
  }
  return {"encoding", static_cast<std::uint64_t>(clip.bytes), flops / speeds.encoding};
}

CompletionPlan::Stage decoding_stage(const CompletionSetup& setup, const ConvolutionSpeeds& speeds) {
  const PartCost cost = decoding_cost(setup.vae, setup.rungs.vae, setup.job);
  return {"decoding", static_cast<std::uint64_t>(cost.bytes), cost.flops / speeds.decoding};
}

/// Of one picture by the tiny decoder after each step; other previews take no time.
double preview_seconds(const CompletionSetup& setup, const ConvolutionSpeeds& speeds) {
  if (!setup.job.decodes_previews()) return 0;
  const ClipSize& clip = setup.job.clip;
  return estimated_flops(*setup.job.fast, {1, clip.height, clip.width}) / speeds.decoding;
}

/// Layers are read one by one and held in float32 while they work; each prompt's own words go through them.
CompletionPlan::Stage text_stage(const CompletionSetup& setup, const ModelOptions& options) {
  const std::string& folder = setup.folder.text_encoder;
  if (folder.empty() || !options.prompt_embeds.empty()) return {"text", 0, 0};
  constexpr double letters_a_token = 4;
  const Umt5Config config = Umt5Config::read(folder + "/config.json");
  const auto inner = static_cast<double>(config.heads * config.d_kv);
  const double a_layer = static_cast<double>(config.d_model) * (4 * inner + 3 * static_cast<double>(config.d_ff));
  const double letters = static_cast<double>(options.prompt.size()) +
                         (setup.denoise.guided(0) ? static_cast<double>(options.negative_prompt.size()) : 0);
  const double flops = 2 * a_layer * static_cast<double>(config.layers) * (letters / letters_a_token + 2);
  const double stored = static_cast<double>(folder_bytes(folder));
  const auto peak = 300e6 + stored / static_cast<double>(config.layers);
  return {"text", static_cast<std::uint64_t>(peak), flops / linear_speed(LinearForm::f32, config.d_model)};
}

}  // namespace

CompletionPlan plan_completion(const ModelOptions& options, Size size, long frames, int threads) {
  options.check();
  const TorchScope scope(threads);
  const CompletionSetup setup = set_up(options, size, frames);
  const PartCost transformer = transformer_cost(setup.config, setup.job.pass, setup.rungs.form, setup.rungs.streamed);
  const ConvolutionSpeeds convolutions(setup);
  const PassTime pass = pass_time(setup, transformer);

  CompletionPlan plan;
  plan.limit = static_cast<std::uint64_t>(setup.rungs.limit);
  plan.gflops = pass.gflops;
  plan.choices = setup.choices;
  double passes = 0;
  for (int step = 0; step < setup.denoise.sampler.steps; ++step) passes += setup.denoise.guided(step) ? 2 : 1;
  plan.seconds_per_step =
      static_cast<double>(setup.windows.size()) * pass.seconds * passes / setup.denoise.sampler.steps +
      preview_seconds(setup, convolutions);
  plan.stages = {
      encoding_stage(setup, convolutions),
      text_stage(setup, options),
      {"denoising", static_cast<std::uint64_t>(denoising_bytes(transformer, setup.job, setup.rungs.vae.precision)),
       plan.seconds_per_step * setup.denoise.sampler.steps},
      decoding_stage(setup, convolutions)};
  if (setup.rungs.streamed)
    plan.choices.push_back(
        fmt::format("each pass reads {:.1f} GiB from disk, unless the system keeps them; the time that takes is not "
                    "in the plan",
                    gib(static_cast<double>(folder_bytes(setup.folder.transformer)))));
  return plan;
}

std::string CompletionPlan::report() const {
  std::string text = fmt::format("{:<10} {:>10} {:>12}\n", "stage", "peak GiB", "seconds");
  for (const Stage& stage : stages)
    text += fmt::format("{:<10} {:>10.2f} {:>12.1f}\n", stage.name, gib(static_cast<double>(stage.peak_bytes)),
                        stage.seconds);
  text += fmt::format("{:.1f} s per step; this machine multiplies {:.0f} GFLOP/s; {:.1f} GiB allowed\n",
                      seconds_per_step, gflops, gib(static_cast<double>(limit)));
  for (const std::string& choice : choices) text += fmt::format("- {}\n", choice);
  return text;
}

}  // namespace uwv
