// SPDX-License-Identifier: Apache-2.0
#include "model/diffusion/completion_job.h"

#include <ATen/ATen.h>

#include <algorithm>
#include <chrono>

#include "model/diffusion/conditioning.h"
#include "model/diffusion/known_tokens.h"
#include "model/diffusion/noise.h"
#include "model/vae/tiny_vae.h"
#include "model/weights/freed_memory.h"
#include "uwv/core/matrix_library.h"
#include "uwv/core/peak_memory.h"

namespace uwv::model {
namespace {

constexpr int preview_scale = 4;  // pixels a latent: half the picture's size

}  // namespace

CompletionJob::CompletionJob(const ModelOptions& options, const RenderedClip& clip, const CompletedClip& out,
                             Monitor& monitor)
    : options_(options),
      clip_(clip),
      out_(out),
      monitor_(monitor),
      setup_(set_up(options, clip.size, clip.frames)),
      tensors_(padded_tensors(clip)) {
  summary_.choices = setup_.choices;
  if (const MatrixLibrary library = matrix_library(); library.replaced())
    warn(
        fmt::format("matrices are multiplied by {} instead of libtorch's own library, which is slow in float32: link "
                    "libtorch before it",
                    library.used));
}

void CompletionJob::warn(const std::string& sentence) {
  summary_.warnings.push_back(sentence);
  monitor_.warn(sentence);
}

template <class Work>
void CompletionJob::timed(const char* name, Work work) {
  // Or what the stage before let go of would be there beside this one's.
  give_back_freed_memory();
  const auto start = std::chrono::steady_clock::now();
  work();
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  summary_.stages.push_back({name, seconds.count(), peak_memory()});
}

void CompletionJob::encode() {
  const WanVae vae = WanVae::open(setup_.folder.vae, setup_.rungs.vae);
  conditions_ = encode_conditions(vae, tensors_, monitor_);
  references_.resize(setup_.windows.size());
  if (!conditions_.any_hole()) return;
  if (!options_.reference) return skip("reference clip: reference is off");
  if (setup_.config.reference == ReferenceBranch::none)
    return skip("reference clip: the transformer has no reference branch");
  if (!tensors_.source) return skip("reference clip: a photo has none");
  for (std::size_t k = 0; k < setup_.windows.size(); ++k)
    if (conditions_.any_hole(setup_.windows[k].first, setup_.windows[k].count))
      references_[k] =
          encode_reference(vae, tensors_, std::max<std::int64_t>(0, 4 * setup_.windows[k].first - 3), monitor_);
}

void CompletionJob::embed() {
  const bool guided = setup_.denoise.guided(0);
  if (!guided) skip("negative prompt: without guidance nothing is led away from it");
  text_ = embed_prompts(options_, setup_.folder, guided, setup_.device, monitor_);
}

/// `wanted` are the clip's tokens that may not be left out; undefined = all.
DenoiseWindow CompletionJob::make_window(const WanTransformer& network, std::size_t k, const at::Tensor& wanted,
                                         PassCount& count) {
  const Window& place = setup_.windows[k];
  if (!conditions_.any_hole(place.first, place.count)) return {place, {}, {}};
  WindowInputs inputs{
      conditions_.control.narrow(2, place.first, place.count), references_[k], text_.positive, text_.negative, {}, {}};
  at::Tensor left_out;
  const at::Tensor here = wanted.defined() ? wanted.narrow(0, place.first, place.count) : at::Tensor();
  if (here.defined() && !here.all().item<bool>()) {
    inputs.kept = places_of(here);
    left_out = latents_of_tokens(here.logical_not()).to(setup_.device);
    skip(fmt::format("{} of {} tokens in window {}: skip_known", here.numel() - inputs.kept.numel(), here.numel(),
                     k + 1));
  }
  return {place, std::make_unique<WindowNetwork>(network, inputs, options_.step_cache, count), left_out};
}

std::vector<DenoiseWindow> CompletionJob::make_windows(const WanTransformer& network, PassCount& count) {
  // Over the whole clip, so that windows that overlap leave out the same.
  const at::Tensor wanted =
      options_.skip_known ? near_unknown(conditions_.unknown_tokens, *options_.skip_known) : at::Tensor();
  std::vector<DenoiseWindow> windows;
  std::size_t without_holes = 0;
  for (std::size_t k = 0; k < setup_.windows.size(); ++k) {
    windows.push_back(make_window(network, k, wanted, count));
    if (!windows.back().model) ++without_holes;
  }
  if (without_holes > 0)
    skip(fmt::format("transformer in {} of {} windows: nothing to generate in them", without_holes,
                     setup_.windows.size()));
  return windows;
}

void CompletionJob::show_preview(const LatentColours& colours, const std::optional<TinyVae>& fast,
                                 const DenoiseStep& step) const {
  if (!out_.preview) return;
  const std::int64_t middle = step.noiseless.size(2) / 2;
  out_.preview(fast ? decoded_picture(*fast, step.noiseless, middle)
                    : colours.picture(step.noiseless.narrow(2, middle, 1).cpu(), 0, preview_scale));
}

void CompletionJob::denoise() {
  TransformerOptions options;
  options.device = setup_.device;
  options.form = setup_.rungs.form;
  options.streamed = setup_.rungs.streamed;
  for (const auto& [path, weight] : setup_.folder.loras) options.loras.push_back({LoraFile::open(path), weight});
  const WanTransformer network = WanTransformer::open(setup_.folder.transformer, options);
  for (const std::string& warning : network.warnings()) warn(warning);

  PassCount count;
  const std::vector<DenoiseWindow> windows = make_windows(network, count);
  long in_all = 0;
  for (int step = 0; step < setup_.denoise.sampler.steps; ++step)
    for (const DenoiseWindow& window : windows) in_all += window.model ? (setup_.denoise.guided(step) ? 2 : 1) : 0;
  constexpr double parts = 1000;  // of a pass, for the monitor
  count.between = [&](double done) {
    const auto passed = static_cast<double>(count.passes + count.skipped);
    monitor_.step("denoising", static_cast<long>(parts * (passed + done)), static_cast<long>(parts) * in_all);
  };
  const at::Tensor known = conditions_.control.narrow(1, 0, 16);
  const LatentColours colours(known, conditions_.small_pictures);
  std::optional<TinyVae> fast;
  if (out_.preview && !options_.vae_fast.empty()) fast = TinyVae::open(options_.vae_fast, setup_.rungs.vae);
  const auto start = std::chrono::steady_clock::now();
  const at::Tensor noise = seeded_noise(known.sizes(), static_cast<std::uint64_t>(options_.seed));
  latents_ = model::denoise(noise.to(setup_.device), windows, known.to(setup_.device), setup_.denoise,
                            [&](const DenoiseStep& step) { show_preview(colours, fast, step); });
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  summary_.windows = static_cast<int>(windows.size());
  summary_.steps = setup_.denoise.sampler.steps;
  summary_.step_seconds = seconds.count() / summary_.steps;
  summary_.passes = count.passes;
  summary_.skipped_passes = count.skipped;
  if (count.skipped > 0) skip(fmt::format("{} of {} passes: step_cache", count.skipped, count.passes + count.skipped));
}

void CompletionJob::decode() {
  DecodedFrames frames(clip_, out_, options_.colour_correction);
  const ClipSink sink = [&](std::int64_t first, const at::Tensor& decoded) { frames.take(first, decoded); };
  if (options_.vae_fast.empty())
    WanVae::open(setup_.folder.vae, setup_.rungs.vae).decode(latents_, sink, monitor_);
  else
    TinyVae::open(options_.vae_fast, setup_.rungs.vae).decode(latents_, sink, monitor_);
  if (!frames.uncorrected().empty()) skip("colour correction: " + frames.uncorrected());
}

/// With nothing to generate the rendering is the result.
void CompletionJob::copy_through() {
  skip("model: no frame has a hole");
  ImageRgb colour;
  GenerateMask holes;
  for (long k = 0; k < clip_.frames; ++k) {
    clip_.read(k, colour, holes);
    out_.write(k, colour);
    if (out_.preview && k == clip_.frames / 2) out_.preview(colour);
    monitor_.step("copying", k + 1, clip_.frames);
  }
}

CompletionSummary CompletionJob::run() {
  timed("encoding", [&] { encode(); });
  if (!conditions_.any_hole()) {
    timed("copying", [&] { copy_through(); });
    return summary_;
  }
  timed("text", [&] { embed(); });
  timed("denoising", [&] { denoise(); });
  conditions_ = {};
  timed("decoding", [&] { decode(); });
  summary_.model_was_run = true;
  return summary_;
}

}  // namespace uwv::model
