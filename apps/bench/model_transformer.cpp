// SPDX-License-Identifier: Apache-2.0
#include <ATen/ATen.h>
#include <ATen/CPUGeneratorImpl.h>

#include <filesystem>

#include "bench/model_commands.h"
#include "bench/timing.h"
#include "model/layers/torch_scope.h"
#include "model/transformer/transformer_cost.h"
#include "model/transformer/wan_transformer.h"
#include "uwv/core/error.h"
#include "uwv/core/peak_memory.h"

namespace uwv::bench {
namespace {

constexpr std::int64_t text_length = 512;
constexpr double timestep = 500;

/// What one step of a clip reads.
struct Inputs {
  at::Tensor latents, control, reference, text;
};

Inputs random_inputs(const ModelBenchOptions& options, const model::TransformerConfig& config) {
  const at::Generator generator = at::detail::createCPUGenerator(options.seed);
  const std::int64_t rows = options.height / 8, columns = options.width / 8, frames = (options.frames - 1) / 4 + 1;
  const auto random = [&](at::IntArrayRef sizes) { return at::randn(sizes, generator, at::TensorOptions(at::kFloat)); };
  Inputs in;
  in.latents = random({1, config.in_channels, frames, rows, columns});
  if (!config.vace_layers.empty()) in.control = random({1, config.vace_in_channels, frames, rows, columns});
  if (options.ref_frames > 0)
    in.reference = random({1, config.ref_in_channels, (options.ref_frames - 1) / 4 + 1, rows, columns});
  in.text = random({1, text_length, config.text_dim});
  in.text.slice(1, options.text_tokens).zero_();
  return in;
}

/// Inputs and answer another program left: safetensors with latents, control, text, out.
Inputs given_inputs(const model::WeightFiles& files) {
  return {files.load("latents", at::kFloat), files.load("control", at::kFloat), {}, files.load("text", at::kFloat)};
}

struct Measured {
  double open_seconds = 0, first_seconds = 0, step_seconds = 0, peak_bytes = 0;
  at::Tensor velocity;
};

Measured measure(const ModelBenchOptions& options, const std::string& form, const Inputs& in) {
  restart_peak_memory();
  Measured measured;
  model::TransformerOptions how;
  how.form = model::linear_form(form);
  how.streamed = options.streamed;
  Stopwatch opening;
  const model::WanTransformer network = model::WanTransformer::open(options.model + "/transformer", how);
  measured.open_seconds = opening.seconds();
  Stopwatch first;
  model::TransformerContext context = network.prepare(in.control, in.reference, in.text);
  const at::Tensor time = at::full({1}, timestep);
  measured.velocity = network.forward(context, in.latents, time);
  measured.first_seconds = first.seconds();
  std::vector<double> seconds;
  for (int run = 0; run < options.runs; ++run) {
    const Stopwatch watch;
    network.forward(context, in.latents, time);
    seconds.push_back(watch.seconds());
  }
  measured.step_seconds = seconds.empty() ? measured.first_seconds : median(seconds);
  measured.peak_bytes = static_cast<double>(peak_memory());
  return measured;
}

model::TransformerLoad load_of(const ModelBenchOptions& options, const std::string& form, const Inputs& in,
                               std::int64_t patch_values) {
  model::TransformerLoad load;
  load.tokens = in.latents.numel() / in.latents.size(1) / patch_values;
  load.text_tokens = in.text.size(1);
  if (in.reference.defined()) load.reference_tokens = in.reference.numel() / in.reference.size(1) / patch_values;
  load.form = model::linear_form(form);
  load.streamed = options.streamed;
  const auto files = model::WeightFiles::open(options.model + "/transformer");
  load.stored_bytes = static_cast<int>(size_of(files.info("blocks.0.attn1.to_q.weight").dtype));
  return load;
}

double relative_error(const at::Tensor& ours, const at::Tensor& exact) {
  return ((ours - exact).square().mean().sqrt() / exact.square().mean().sqrt()).item<double>();
}

}  // namespace

std::vector<Table> time_transformer(const ModelBenchOptions& options) {
  const model::TorchScope scope(options.threads);
  const auto config = model::TransformerConfig::read(options.model + "/transformer");
  Inputs in = random_inputs(options, config);
  at::Tensor exact;
  if (!options.compare.empty()) {
    const model::WeightFiles theirs = model::WeightFiles::open(options.compare);
    in = given_inputs(theirs);
    exact = theirs.load("out", at::kFloat);
  }
  Table table("transformer", {"form", "streamed", "tokens", "open_s", "first_step_s", "step_s", "gflops", "peak_gb",
                              "estimated_gb", "error"});
  for (const std::string& form : options.forms) {
    const Measured measured = measure(options, form, in);
    if (!exact.defined()) exact = measured.velocity;
    const model::TransformerLoad load = load_of(options, form, in, config.patch_values());
    table.add({form, options.streamed ? "yes" : "no", load.tokens, measured.open_seconds, measured.first_seconds,
               measured.step_seconds, model::estimated_flops(config, load) / measured.step_seconds / 1e9,
               measured.peak_bytes / 1e9, model::estimated_peak_bytes(config, load) / 1e9,
               relative_error(measured.velocity, exact)});
  }
  return {table};
}

}  // namespace uwv::bench
