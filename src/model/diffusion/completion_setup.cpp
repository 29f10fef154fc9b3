// SPDX-License-Identifier: Apache-2.0
#include "model/diffusion/completion_setup.h"

#include <algorithm>
#include <map>

#include "model/diffusion/conditioning.h"
#include "model/layers/compute_device.h"
#include "model/sampling/scheduler_config.h"
#include "model/vae/tiny_vae.h"
#include "model/weights/weight_files.h"

namespace uwv::model {
namespace {

constexpr std::int64_t side_multiple = 16;  // a latent has 8 pixels, a token 2 latents
constexpr std::int64_t reference_latents = 3;

void choose_sampler(CompletionSetup& setup, const ModelOptions& options) {
  SamplerOptions& sampler = setup.denoise.sampler;
  if (options.sampler) return;
  const bool plain = setup.config.reference == ReferenceBranch::none;
  std::string why = options.few_steps ? "few_steps" : "the official code's";
  if (!options.few_steps && plain && !setup.folder.scheduler_config.empty()) {
    const SamplerOptions published = read_scheduler_config(setup.folder.scheduler_config);
    sampler.kind = published.kind;
    sampler.shift = options.shift.value_or(published.shift);
    why = "the checkpoint's own";
  }
  setup.choices.push_back(fmt::format("sampler {} with shift {}: {}", to_string(sampler.kind), sampler.shift, why));
}

/// The type most numbers of the layers' matrices are stored in.
DType most_stored(const WeightFiles& files) {
  std::map<DType, std::size_t> numbers;
  for (const std::string& name : files.names())
    if (const TensorInfo& info = files.info(name); info.shape.size() == 2) numbers[info.dtype] += info.values();
  const auto most = std::max_element(numbers.begin(), numbers.end(),
                                     [](const auto& a, const auto& b) { return a.second < b.second; });
  return most == numbers.end() ? DType::f32 : most->first;
}

PassSize pass_size(const CompletionSetup& setup, const ModelOptions& options) {
  const std::int64_t tokens_a_latent = setup.job.clip.height / side_multiple * (setup.job.clip.width / side_multiple);
  PassSize pass;
  pass.tokens = tokens_a_latent * setup.windows.front().count;
  const bool refers = options.reference && setup.config.reference != ReferenceBranch::none;
  pass.reference_tokens = refers ? tokens_a_latent * reference_latents : 0;
  pass.stored = most_stored(WeightFiles::open(setup.folder.transformer));
  pass.branches = setup.denoise.guided(0) ? 2 : 1;
  pass.batch = options.cfg_batch ? pass.branches : 1;
  pass.branches *= static_cast<int>(setup.windows.size());
  pass.step_cache = options.step_cache > 0;
  return pass;
}

}  // namespace

std::int64_t whole_side(std::int64_t side) { return (side + side_multiple - 1) / side_multiple * side_multiple; }

CompletionSetup set_up(const ModelOptions& options, Size size, long frames) {
  require(frames >= 1 && size.width >= 1 && size.height >= 1, "a clip of {} frames of {}x{} pixels cannot be completed",
          frames, size.width, size.height);
  CompletionSetup setup;
  setup.device = compute_device(options.device);
  setup.folder = CheckpointFolder::find(options);
  setup.config = TransformerConfig::read(setup.folder.transformer);
  setup.vae = VaeConfig::read(setup.folder.vae + "/config.json");
  setup.denoise = {options.sampling(), options.guidance_scale(), options.cfg_share, options.cfg_batch};
  choose_sampler(setup, options);
  setup.denoise.check();
  setup.job.clip = {whole_frames(frames), whole_side(size.height), whole_side(size.width)};
  setup.job.previews = options.preview;
  if (!options.vae_fast.empty()) {
    TinyVae::check(options.vae_fast, setup.vae.z_dim);
    setup.job.fast = TinyVaeSizes::read(options.vae_fast);
  }
  setup.windows = plan_windows(latent_frames(setup.job.clip.frames), {options.window_frames, options.window_overlap});
  setup.job.pass = pass_size(setup, options);
  setup.rungs = choose_rungs(options, setup.device, setup.config, setup.vae, setup.job);
  setup.choices.insert(setup.choices.end(), setup.rungs.reasons.begin(), setup.rungs.reasons.end());
  return setup;
}

}  // namespace uwv::model
