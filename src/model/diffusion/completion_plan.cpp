// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <filesystem>

#include "model/diffusion/clip_conditions.h"
#include "model/diffusion/completion_setup.h"
#include "model/diffusion/denoise_seconds.h"
#include "model/diffusion/disk_speed.h"
#include "model/diffusion/machine_speed.h"
#include "model/layers/torch_scope.h"
#include "model/text/umt5_encoder.h"
#include "uwv/model/view_completion.h"

namespace uwv {
namespace {

using namespace model;

std::vector<std::string> weight_files(const std::string& folder) {
  std::vector<std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    if (entry.is_regular_file() && entry.path().extension() == ".safetensors") files.push_back(entry.path().string());
  return files;
}

std::uint64_t folder_bytes(const std::string& folder) {
  std::uint64_t bytes = 0;
  for (const std::string& file : weight_files(folder)) bytes += std::filesystem::file_size(file);
  return bytes;
}

double gib(double bytes) { return bytes / (1024.0 * 1024.0 * 1024.0); }

/// What a pass takes besides products: norms, gates, the feed-forward's curve. Of all forms a fifth of the products'
/// time at 1.3B's width, docs/performance.md.
constexpr double beside_products = 1.2;

/// Of one pass of the transformer over one window; reading not yet.
PassSeconds computing_time(const CompletionSetup& setup, const PartCost& cost, double layer_speed) {
  const LinearForm form = setup.rungs.form;
  const PassSize& pass = setup.job.pass;
  const double attention = attention_speed(form, setup.config.head_dim, pass.tokens, setup.device);
  const double products = (cost.flops - cost.attention_flops) / layer_speed + cost.attention_flops / attention;
  PassSeconds seconds;
  seconds.computing = beside_products * products / pass.batch;
  if (cost.rounded > 0)
    seconds.rounding =
        cost.rounded / rounding_speed(form, static_cast<int>(size_of(pass.stored)), setup.config.dim(), setup.device);
  return seconds;
}

/// Of the blocks of a streamed transformer, whose time goes into `pass`.
CompletionPlan::Reading reading_time(const CompletionSetup& setup, const PartCost& cost, PassSeconds& pass) {
  CompletionPlan::Reading reading;
  const double bytes = cost.rounded * static_cast<double>(size_of(setup.job.pass.stored));
  reading.bytes = static_cast<std::uint64_t>(bytes);
  reading.first_pass_only = bytes + (setup.device.is_cpu() ? cost.bytes : 0) <= available_memory();
  reading.computing = pass.computing * setup.job.pass.batch + pass.rounding;
  const std::optional<DiskSpeed> disk = disk_speed(weight_files(setup.folder.transformer));
  if (!disk) return reading;
  reading.bytes_per_second = disk->bytes_a_second;
  reading.seconds = bytes / disk->bytes_a_second;
  pass.reading = reading.seconds;
  pass.first_reading = (1 - disk->cached) * reading.seconds;
  pass.stays = reading.first_pass_only;
  return reading;
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
  const double layer_speed = linear_speed(setup.rungs.form, setup.config.dim(), setup.device);
  PassSeconds pass = computing_time(setup, transformer, layer_speed);

  CompletionPlan plan;
  plan.limit = static_cast<std::uint64_t>(setup.rungs.limit);
  plan.gflops = layer_speed / 1e9;
  plan.choices = setup.choices;
  if (setup.rungs.streamed) plan.reading = reading_time(setup, transformer, pass);
  const DenoiseSeconds denoising = denoise_seconds(setup.denoise, setup.windows.size(), pass);
  const double previews = preview_seconds(setup, convolutions);
  plan.seconds_per_step = denoising.a_step + previews;
  plan.stages = {
      encoding_stage(setup, convolutions),
      text_stage(setup, options),
      {"denoising", static_cast<std::uint64_t>(denoising_bytes(transformer, setup.job, setup.rungs.vae.precision)),
       denoising.all + previews * setup.denoise.sampler.steps},
      decoding_stage(setup, convolutions)};
  return plan;
}

std::string CompletionPlan::Reading::sentence() const {
  const std::string amount = fmt::format("each pass reads {:.1f} GiB from disk", gib(static_cast<double>(bytes)));
  const std::string once =
      first_pass_only ? "; they fit into free memory beside all else, so only the first pass reads them" : "";
  if (bytes_per_second <= 0) return amount + ", at a speed that could not be measured and is not in the plan" + once;
  return fmt::format("{} at {:.0f} MB/s: {:.1f} s, while it computes for {:.1f} s, and takes the longer{}", amount,
                     bytes_per_second / 1e6, seconds, computing, once);
}

std::string CompletionPlan::report() const {
  std::string text = fmt::format("{:<10} {:>10} {:>12}\n", "stage", "peak GiB", "seconds");
  for (const Stage& stage : stages)
    text += fmt::format("{:<10} {:>10.2f} {:>12.1f}\n", stage.name, gib(static_cast<double>(stage.peak_bytes)),
                        stage.seconds);
  text += fmt::format("{:.1f} s per step; this machine multiplies {:.0f} GFLOP/s; {:.1f} GiB allowed\n",
                      seconds_per_step, gflops, gib(static_cast<double>(limit)));
  if (reading) text += reading->sentence() + '\n';
  for (const std::string& choice : choices) text += fmt::format("- {}\n", choice);
  return text;
}

}  // namespace uwv
