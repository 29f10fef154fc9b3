// SPDX-License-Identifier: Apache-2.0
// What the video diffusion model can be asked, in one struct. A field, its command line flag and its key in run.json
// share one name. docs/model.md says how to choose; docs/performance.md what each choice was measured to cost.
#pragma once

#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "uwv/core/error.h"
#include "uwv/model/sampler_options.h"

namespace uwv {

/// How the linear layers' weights are held and multiplied; each is smaller than the one before.
enum class WeightsForm {
  /// The first that fits `memory_limit`, but no form this CPU is slow in; and bf16 instead of f32 for a bfloat16
  /// checkpoint where the CPU multiplies it faster: the official code computes so.
  automatic,
  f32,          ///< The exact answer.
  bf16_stored,  ///< Half the memory, multiplied in float32.
  bf16,         ///< Half the memory, multiplied in bfloat16: fast where fast_numbers() says so.
  int8_stored,  ///< A quarter of the memory, multiplied in float32.
  int8,         ///< A quarter of the memory, multiplied in 8-bit integers: fast with VNNI or AMX.
};

/// Whether the transformer is read block by block at every step.
enum class StreamChoice {
  automatic,  ///< Where it does not fit into memory otherwise.
  on,
  off,
};

/// Numbers the autoencoder computes in.
enum class VaeNumbers {
  automatic,  ///< bf16 where the CPU multiplies it in tiles (AMX), else f32.
  f32,        ///< The exact answer.
  bf16,
};

/// The official code's, which is Wan's stock text.
inline constexpr const char* stock_negative_prompt =
    "Bright tones, overexposed, static, blurred details, subtitles, style, works, paintings, images, static, overall "
    "gray, worst quality, low quality, JPEG compression residue, ugly, incomplete, extra fingers, poorly drawn hands, "
    "poorly drawn faces, deformed, disfigured, misshapen limbs, fused fingers, still picture, messy background, three "
    "legs, many people in the background, walking backwards";

struct ModelOptions {
  std::string model;  ///< Folder of the checkpoint in Hugging Face's layout (docs/model.md). Empty: no model is used.
  std::string transformer;        ///< Folder of the transformer where it lies elsewhere, as the official one does.
  std::vector<std::string> lora;  ///< FILE or FILE:WEIGHT, each added to the transformer's weights; weight 1 if unsaid.

  // -- text ----------------------------------------------------------------------------------------------------------
  std::string prompt;  ///< What the clip shows. Empty is a prompt too: the embedding of no text.
  std::string negative_prompt = stock_negative_prompt;  ///< What guidance leads away from.
  std::string prompt_embeds;  ///< .safetensors with prompt_embeds and negative_prompt_embeds, instead of the encoder.

  std::string prompt_cache;  ///< Folder that keeps encoded prompts. Empty: uwv/prompts in the user's cache folder.

  // -- steps ---------------------------------------------------------------------------------------------------------
  /// For LoRAs distilled to few steps: 4 evenly spaced ones with shift 8 and guidance 1, where those are unset.
  bool few_steps = false;
  std::optional<model::SamplerKind> sampler;  ///< Unset: the official code's, euler; euler_plain with few_steps.
  std::optional<int> steps;                   ///< Unset: 8 with a LoRA as in the official scripts, else 50.
  std::optional<double> shift;                ///< Unset: 5.
  std::optional<double> guidance;             ///< Unset: 4 with a LoRA, else 6, as official. 1 = off: half the time.
  double cfg_share = 1;                       ///< Share of the steps that are guided, the first ones.
  bool cfg_batch = false;                     ///< Both passes of guidance at once: more memory, little time saved.
  double step_cache = 0;  ///< Leaves out steps that change little: threshold, 0 = none, 0.1 few, 0.3 many.
  /// Leaves out tokens (16x16 pixels of a latent's frames) that are known and farther than so many tokens, in rows,
  /// columns and latent frames, from any that is not. Unset: none. Time falls with what is left, quality may too.
  std::optional<int> skip_known;
  long seed = 42;  ///< Of the noise. 42 is the official code's only one (its noise is CUDA's).

  // -- clip ----------------------------------------------------------------------------------------------------------
  bool reference = true;          ///< Show the network frames of the source clip, where its weights can use them.
  bool colour_correction = true;  ///< Fit the result's colours to the first frame, which is known.
  int window_frames = 81;         ///< Frames denoised at once, 1 + 4k; longer clips are made of several windows.
  int window_overlap = 20;        ///< Frames windows share, 4k.

  // -- memory and time -----------------------------------------------------------------------------------------------
  std::string device = "cpu";  ///< Where the model runs: cpu, or cuda, cuda:N and the like where libtorch has them.
  std::string memory_limit;    ///< Such as 16G. What is automatic below is chosen to fit. Empty: what the device has.
  WeightsForm weights = WeightsForm::automatic;
  StreamChoice stream = StreamChoice::automatic;
  VaeNumbers vae_precision = VaeNumbers::f32;
  int vae_bands = 0;     ///< Bands of rows the autoencoder works through one by one; 0 = as many as memory needs.
  int vae_tile = 0;      ///< Side in pixels of overlapping squares it works on instead, blended; 0 = none. For 8K.
  std::string vae_fast;  ///< Folder or file of a tiny decoder (TAEHV layout) that decodes the result.
  bool preview = false;  ///< Write preview.png after each step: the middle frame without its noise.

  /// Steps and sampler with everything unset decided.
  model::SamplerOptions sampling() const {
    model::SamplerOptions chosen = few_steps ? model::SamplerOptions::few_steps() : model::SamplerOptions{};
    if (!few_steps && lora.empty()) chosen.steps = 50;
    return {sampler.value_or(chosen.kind), steps.value_or(chosen.steps), shift.value_or(chosen.shift)};
  }
  double guidance_scale() const { return guidance.value_or(few_steps ? 1 : lora.empty() ? 6 : 4); }

  /// Throws std::invalid_argument naming the option.
  void check() const;
};

/// Bytes of "16G", "512M", "1.5GiB", "20000000"; units are powers of 1024. Nothing when it is no such text.
inline std::optional<std::uint64_t> parse_bytes(const std::string& text) {
  std::size_t end = 0;
  double value = 0;
  try {
    value = std::stod(text, &end);
  } catch (const std::exception&) {
    return std::nullopt;
  }
  std::string unit = text.substr(end);
  if (unit.ends_with("iB")) unit.resize(unit.size() - 2);
  const std::string units = "KMGT";
  const auto place = unit.size() == 1 ? units.find(unit[0]) : std::string::npos;
  if (!unit.empty() && place == std::string::npos) return std::nullopt;
  const double bytes = value * (unit.empty() ? 1 : std::pow(1024.0, static_cast<double>(place + 1)));
  if (!(bytes >= 1 && bytes <= 1e15)) return std::nullopt;
  return static_cast<std::uint64_t>(bytes);
}

inline void ModelOptions::check() const {
  const double g = guidance_scale();
  require(!steps || (*steps >= 1 && *steps <= 1000), "--steps: found {}, wanted 1 to 1000", steps.value_or(0));
  require(!shift || (*shift >= 0.01 && *shift <= 100), "--shift: found {}, wanted 0.01 to 100", shift.value_or(0));
  require(g >= 0 && g <= 100, "--guidance: found {}, wanted 0 to 100", g);
  require(cfg_share >= 0 && cfg_share <= 1, "--cfg-share: found {}, wanted 0 to 1", cfg_share);
  require(step_cache >= 0 && step_cache <= 10, "--step-cache: found {}, wanted 0 (off) to 10", step_cache);
  require(!skip_known || (*skip_known >= 0 && *skip_known <= 1000), "--skip-known: found {}, wanted 0 to 1000",
          skip_known.value_or(0));
  require(seed >= 0, "--seed: found {}, wanted 0 or more", seed);
  require(window_frames >= 5 && window_frames % 4 == 1, "--window-frames: found {}, wanted 1 + 4k, at least 5",
          window_frames);
  require(window_overlap >= 4 && window_overlap % 4 == 0 && window_overlap < window_frames - 1,
          "--window-overlap: found {}, wanted a multiple of 4 below --window-frames {}", window_overlap, window_frames);
  require(memory_limit.empty() || parse_bytes(memory_limit), "--memory-limit: found '{}', wanted bytes such as 16G",
          memory_limit);
  require(vae_bands >= 0 && vae_bands <= 64, "--vae-bands: found {}, wanted 0 (automatic) to 64", vae_bands);
  require(vae_tile == 0 || (vae_tile >= 32 && vae_tile <= 16384 && vae_tile % 8 == 0),
          "--vae-tile: found {}, wanted 0 (none) or a multiple of 8 from 32 on", vae_tile);
}

}  // namespace uwv
