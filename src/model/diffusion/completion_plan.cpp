// SPDX-License-Identifier: Apache-2.0
#include <ATen/ATen.h>
#include <sys/stat.h>

#include <algorithm>
#include <chrono>
#include <filesystem>

#include "model/diffusion/completion_setup.h"
#include "model/layers/linear.h"
#include "model/layers/torch_scope.h"
#include "uwv/model/view_completion.h"

namespace uwv {
namespace {

using namespace model;

/// Floating point operations a second of a layer of this form, measured for a moment.
double measured_flops(LinearForm form) {
  constexpr std::int64_t tokens = 512, width = 1536;
  const Linear layer(at::full({width, width}, 0.01), {}, form);
  const at::Tensor x = at::ones({tokens, width}, token_type(form));
  layer(x);  // the first call sets the library up
  const auto start = std::chrono::steady_clock::now();
  std::chrono::duration<double> passed{};
  int calls = 0;
  do {
    layer(x);
    ++calls;
    passed = std::chrono::steady_clock::now() - start;
  } while (passed.count() < 0.25);
  return 2.0 * tokens * width * width * calls / passed.count();
}

std::uint64_t folder_bytes(const std::string& folder) {
  std::uint64_t bytes = 0;
  if (!folder.empty())
    for (const auto& entry : std::filesystem::directory_iterator(folder))
      if (entry.is_regular_file() && entry.path().extension() == ".safetensors") bytes += entry.file_size();
  return bytes;
}

double gib(double bytes) { return bytes / (1024.0 * 1024.0 * 1024.0); }

}  // namespace

CompletionPlan plan_completion(const ModelOptions& options, Size size, long frames, int threads) {
  options.check();
  const TorchScope scope(threads);
  const CompletionSetup setup = set_up(options, size, frames);
  const JobSize& job = setup.job;
  const PartCost transformer = transformer_cost(setup.config, job.pass, setup.rungs.form, setup.rungs.streamed);
  const PartCost encoder = vae_cost(setup.vae, setup.rungs.vae, job.clip, VaeWay::encode);
  const PartCost decoder = vae_cost(setup.vae, setup.rungs.vae, job.clip, VaeWay::decode);
  const double plain = measured_flops(LinearForm::f32);
  const double fast = setup.rungs.form == LinearForm::f32 ? plain : measured_flops(setup.rungs.form);

  CompletionPlan plan;
  plan.limit = static_cast<std::uint64_t>(setup.rungs.limit);
  plan.gflops = fast / 1e9;
  plan.choices = setup.choices;
  double passes = 0;
  for (int step = 0; step < setup.denoise.sampler.steps; ++step) passes += setup.denoise.guided(step) ? 2 : 1;
  const auto windows = static_cast<double>(setup.windows.size());
  const double pass_seconds = transformer.flops / job.pass.batch / fast;
  const double step_bytes = setup.rungs.streamed ? static_cast<double>(folder_bytes(setup.folder.transformer)) : 0;
  plan.seconds_per_step = windows * pass_seconds * passes / setup.denoise.sampler.steps;
  const double text_bytes = static_cast<double>(folder_bytes(setup.folder.text_encoder));
  plan.stages = {
      {"encoding", static_cast<std::uint64_t>(encoder.bytes), 2 * encoder.flops / plain},
      {"text", static_cast<std::uint64_t>(300e6 + text_bytes / 8), 2 * text_bytes * 30 / plain},
      {"denoising", static_cast<std::uint64_t>(transformer.bytes), plan.seconds_per_step * setup.denoise.sampler.steps},
      {"decoding", static_cast<std::uint64_t>(decoder.bytes), decoder.flops / plain}};
  if (step_bytes > 0)
    plan.choices.push_back(
        fmt::format("each pass reads {:.1f} GiB from disk, unless the system keeps them", gib(step_bytes)));
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
