// SPDX-License-Identifier: Apache-2.0
#include "model/diffusion/rungs.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <utility>

#include "model/layers/compute_device.h"
#include "uwv/model/compute_devices.h"

namespace uwv::model {
namespace {

constexpr double gib = 1024.0 * 1024.0 * 1024.0;
constexpr int most_bands = 64;

LinearForm linear_form_of(WeightsForm weights) {
  switch (weights) {
    case WeightsForm::bf16_stored: return LinearForm::bf16_stored;
    case WeightsForm::bf16: return LinearForm::bf16;
    case WeightsForm::int8_stored: return LinearForm::int8_stored;
    case WeightsForm::int8: return LinearForm::int8;
    default: return LinearForm::f32;
  }
}

VaePrecision vae_precision_of(VaeNumbers numbers) {
  switch (numbers) {
    case VaeNumbers::f32: return VaePrecision::f32;
    case VaeNumbers::bf16: return VaePrecision::bf16;
    default: return resolved(VaePrecision::automatic);
  }
}

/// Bytes the device could give. Where libtorch does not tell, main memory's.
double available_bytes(c10::Device device) {
  const auto own = free_bytes(device);
  return own ? 0.9 * static_cast<double>(*own) : available_memory();
}

/// How far estimates may be off, docs/model.md.
constexpr double transformer_error = 0.125, autoencoder_error = 0.25;

/// Largest estimate that keeps the limit though it may err so much. What is free, without a limit, has room of its own.
double most_estimated(const Rungs& rungs, const ModelOptions& options, double error) {
  return options.memory_limit.empty() ? rungs.limit : rungs.limit / (1 + error);
}

struct Candidate {
  LinearForm form;
  bool streamed;
};

/// Whether bfloat16 is no detour: on other devices it is taken for granted.
bool has_fast_bf16(c10::Device device) { return !device.is_cpu() || fast_numbers().bf16; }

/// bfloat16 weights multiplied in bfloat16: what the official code runs. float32 would take four times as long to tell
/// apart what the checkpoint does not.
bool is_official_run(const PassSize& pass, c10::Device device) {
  return pass.stored == DType::bf16 && has_fast_bf16(device);
}

/// From exact and large to coarse and small, as far as the options leave it open.
std::vector<Candidate> candidates(const ModelOptions& options, c10::Device device, const PassSize& pass) {
  const bool fast_int8 = device.is_cpu() && fast_numbers().int8;
  std::vector<LinearForm> forms{LinearForm::f32, has_fast_bf16(device) ? LinearForm::bf16 : LinearForm::bf16_stored,
                                fast_int8 ? LinearForm::int8 : LinearForm::int8_stored};
  if (is_official_run(pass, device)) forms.erase(forms.begin());
  // Rounded to 8 bits once, a checkpoint gains nothing by wider products.
  if (pass.stored == DType::i8) forms.erase(forms.begin(), forms.end() - 1);
  if (options.weights != WeightsForm::automatic) forms = {linear_form_of(options.weights)};
  std::vector<Candidate> all;
  for (const bool streamed : {false, true}) {
    if (streamed ? options.stream == StreamChoice::off : options.stream == StreamChoice::on) continue;
    for (const LinearForm form : forms) all.push_back({form, streamed});
  }
  return all;
}

void choose_transformer(Rungs& rungs, const ModelOptions& options, c10::Device device, const TransformerConfig& config,
                        const JobSize& job) {
  const PassSize& pass = job.pass;
  const std::vector<Candidate> all = candidates(options, device, pass);
  const auto bytes = [&](const Candidate& c) {
    return denoising_bytes(transformer_cost(config, pass, c.form, c.streamed), job, rungs.vae.precision);
  };
  const double most = most_estimated(rungs, options, transformer_error);
  auto chosen = std::find_if(all.begin(), all.end(), [&](const Candidate& c) { return bytes(c) <= most; });
  if (chosen == all.end()) {
    chosen = std::min_element(all.begin(), all.end(), [&](auto& a, auto& b) { return bytes(a) < bytes(b); });
    if (!options.memory_limit.empty() && bytes(*chosen) > rungs.limit)
      fail(ErrorCode::out_of_memory,
           "--memory-limit {}: the transformer needs {:.1f} GiB at least; take a smaller --size or --window-frames, {}",
           options.memory_limit, bytes(*chosen) / gib,
           options.weights != WeightsForm::automatic || options.stream != StreamChoice::automatic
               ? "or leave --weights and --stream to be chosen"
               : "or a higher limit");
  }
  rungs.form = chosen->form;
  rungs.streamed = chosen->streamed;
  if (all.size() > 1)
    rungs.reasons.push_back(
        fmt::format("weights {}{}: {:.1f} GiB expected, {:.1f} allowed{}{}", to_string(rungs.form),
                    rungs.streamed ? ", read block by block" : "", bytes(*chosen) / gib, rungs.limit / gib,
                    rungs.form == LinearForm::bf16 && is_official_run(pass, device)
                        ? "; the checkpoint is bfloat16 and so is the official run"
                        : "",
                    chosen == all.begin()
                        ? ""
                        : fmt::format("; {} needs {:.1f}", to_string(all.front().form), bytes(all.front()) / gib)));
}

void choose_bands(Rungs& rungs, const ModelOptions& options, const VaeConfig& config, const JobSize& job) {
  if (options.vae_bands == 0)
    while (rungs.vae.bands < most_bands &&
           vae_bytes(config, rungs.vae, job) > most_estimated(rungs, options, autoencoder_error))
      ++rungs.vae.bands;
  const double bytes = vae_bytes(config, rungs.vae, job);
  if (bytes > rungs.limit && !options.memory_limit.empty())
    fail(ErrorCode::out_of_memory,
         "--memory-limit {}: the autoencoder needs {:.1f} GiB in {} bands; take a smaller --size, or --vae-precision "
         "bf16",
         options.memory_limit, bytes / gib, rungs.vae.bands);
  if (options.vae_bands == 0 && rungs.vae.bands > 1)
    rungs.reasons.push_back(fmt::format("vae_bands {}: {:.1f} GiB expected, {:.1f} allowed", rungs.vae.bands,
                                        bytes / gib, rungs.limit / gib));
}

void check_tiny_decoder(const Rungs& rungs, const ModelOptions& options, const JobSize& job) {
  if (!job.fast || options.memory_limit.empty()) return;
  const double bytes = tiny_vae_cost(*job.fast, rungs.vae.precision, job.clip).bytes;
  if (bytes > rungs.limit)
    fail(ErrorCode::out_of_memory,
         "--memory-limit {}: the tiny decoder needs {:.1f} GiB; take a smaller --size, or --vae-precision bf16",
         options.memory_limit, bytes / gib);
}

}  // namespace

double available_memory() {
  std::ifstream file("/proc/meminfo");
  for (std::string word; file >> word;) {
    if (word != "MemAvailable:") continue;
    double kibibytes = 0;
    file >> kibibytes;
    return 0.9 * 1024 * kibibytes;
  }
  return 8 * gib;
}

PartCost decoding_cost(const VaeConfig& config, const VaeOptions& options, const JobSize& job) {
  return job.fast ? tiny_vae_cost(*job.fast, options.precision, job.clip)
                  : vae_cost(config, options, job.clip, VaeWay::decode);
}

double vae_bytes(const VaeConfig& config, const VaeOptions& options, const JobSize& job) {
  const double encoding = vae_cost(config, options, job.clip, VaeWay::encode).bytes;
  return job.fast ? encoding : std::max(encoding, vae_cost(config, options, job.clip, VaeWay::decode).bytes);
}

double denoising_bytes(const PartCost& transformer, const JobSize& job, VaePrecision precision) {
  if (!job.decodes_previews()) return transformer.bytes;
  const double weights = estimated_weight_bytes(*job.fast, precision);
  const double working = estimated_working_bytes(*job.fast, job.clip, precision);
  return weights + std::max(transformer.bytes, transformer.resting + working);
}

Rungs choose_rungs(const ModelOptions& options, c10::Device device, const TransformerConfig& config,
                   const VaeConfig& vae, const JobSize& job) {
  Rungs rungs;
  rungs.limit = options.memory_limit.empty() ? available_bytes(device)
                                             : static_cast<double>(parse_bytes(options.memory_limit).value_or(0));
  rungs.vae.precision = vae_precision_of(options.vae_precision);
  rungs.vae.bands = std::max(1, options.vae_bands);
  rungs.vae.device = device;
  rungs.vae.tile = options.vae_tile;
  choose_transformer(rungs, options, device, config, job);
  choose_bands(rungs, options, vae, job);
  check_tiny_decoder(rungs, options, job);
  return rungs;
}

}  // namespace uwv::model
