// SPDX-License-Identifier: Apache-2.0
#include "model/diffusion/rungs.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <utility>

#include "uwv/core/processor.h"

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

/// Bytes the machine could give: what is free, less a tenth for others.
double available_bytes() {
  std::ifstream file("/proc/meminfo");
  for (std::string word; file >> word;) {
    if (word != "MemAvailable:") continue;
    double kibibytes = 0;
    file >> kibibytes;
    return 0.9 * 1024 * kibibytes;
  }
  return 8 * gib;
}

struct Candidate {
  LinearForm form;
  bool streamed;
};

/// bfloat16 weights multiplied in bfloat16: what the official code runs. float32 would take four times as long to tell
/// apart what the checkpoint does not.
bool is_official_run(const PassSize& pass, const ProcessorUnits& units) {
  return pass.stored == DType::bf16 && units.bf16();
}

/// From exact and large to coarse and small, as far as the options leave it open.
std::vector<Candidate> candidates(const ModelOptions& options, const PassSize& pass) {
  const ProcessorUnits units = processor_units();
  std::vector<LinearForm> forms{LinearForm::f32, units.bf16() ? LinearForm::bf16 : LinearForm::bf16_stored,
                                units.int8() ? LinearForm::int8 : LinearForm::int8_stored};
  if (is_official_run(pass, units)) forms.erase(forms.begin());
  if (options.weights != WeightsForm::automatic) forms = {linear_form_of(options.weights)};
  std::vector<Candidate> all;
  for (const bool streamed : {false, true}) {
    if (streamed ? options.stream == StreamChoice::off : options.stream == StreamChoice::on) continue;
    for (const LinearForm form : forms) all.push_back({form, streamed});
  }
  return all;
}

void choose_transformer(Rungs& rungs, const ModelOptions& options, const TransformerConfig& config,
                        const PassSize& pass) {
  const std::vector<Candidate> all = candidates(options, pass);
  const auto bytes = [&](const Candidate& c) { return transformer_cost(config, pass, c.form, c.streamed).bytes; };
  auto chosen = std::find_if(all.begin(), all.end(), [&](const Candidate& c) { return bytes(c) <= rungs.limit; });
  if (chosen == all.end()) {
    chosen = std::min_element(all.begin(), all.end(), [&](auto& a, auto& b) { return bytes(a) < bytes(b); });
    if (!options.memory_limit.empty())
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
                    rungs.form == LinearForm::bf16 && is_official_run(pass, processor_units())
                        ? "; the checkpoint is bfloat16 and so is the official run"
                        : "",
                    chosen == all.begin()
                        ? ""
                        : fmt::format("; {} needs {:.1f}", to_string(all.front().form), bytes(all.front()) / gib)));
}

void choose_vae(Rungs& rungs, const ModelOptions& options, const VaeConfig& config, const JobSize& job) {
  rungs.vae = {vae_precision_of(options.vae_precision), std::max(1, options.vae_bands), 0, 0};
  if (options.vae_bands == 0)
    while (rungs.vae.bands < most_bands && vae_bytes(config, rungs.vae, job) > rungs.limit) ++rungs.vae.bands;
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

}  // namespace

double vae_bytes(const VaeConfig& config, const VaeOptions& options, const JobSize& job) {
  return std::max(vae_cost(config, options, job.clip, VaeWay::encode).bytes,
                  vae_cost(config, options, job.clip, VaeWay::decode).bytes);
}

Rungs choose_rungs(const ModelOptions& options, const TransformerConfig& config, const VaeConfig& vae,
                   const JobSize& job) {
  Rungs rungs;
  rungs.limit = options.memory_limit.empty() ? available_bytes()
                                             : static_cast<double>(parse_bytes(options.memory_limit).value_or(0));
  choose_transformer(rungs, options, config, job.pass);
  choose_vae(rungs, options, vae, job);
  return rungs;
}

}  // namespace uwv::model
