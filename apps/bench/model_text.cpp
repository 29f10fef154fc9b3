// SPDX-License-Identifier: Apache-2.0
#include <ATen/ATen.h>

#include "bench/model_commands.h"
#include "bench/timing.h"
#include "model/layers/torch_scope.h"
#include "model/text/umt5_encoder.h"
#include "uwv/core/peak_memory.h"

namespace uwv::bench {
namespace {

/// A prompt of as many tokens as asked for; any ids will do.
model::TokenBatch any_prompt(std::int64_t tokens, std::int64_t vocabulary) {
  const at::Tensor ids = (at::arange(tokens, at::kLong) * 7919 + 3).remainder(vocabulary).unsqueeze(0);
  return {ids, at::ones_like(ids)};
}

double relative_error(const at::Tensor& ours, const at::Tensor& exact) {
  return ((ours - exact).square().mean().sqrt() / exact.square().mean().sqrt()).item<double>();
}

}  // namespace

std::vector<Table> time_text_encoder(const ModelBenchOptions& options) {
  const model::TorchScope scope(options.threads);
  Table table("text encoder", {"form", "tokens", "stored_gb", "open_s", "encode_s", "peak_gb", "error", "rms"});
  at::Tensor exact;
  for (const std::string& form : options.forms) {
    restart_peak_memory();
    const Stopwatch opening;
    const auto encoder = model::Umt5Encoder::open(options.model + "/text_encoder", model::linear_form(form));
    const double open_seconds = opening.seconds();
    const model::TokenBatch prompt = any_prompt(options.text_tokens, encoder.config().vocabulary);
    std::vector<double> seconds;
    at::Tensor answer;
    for (int run = 0; run < std::max(1, options.runs); ++run) {
      const Stopwatch watch;
      answer = encoder.encode({prompt}, nullptr).front();
      seconds.push_back(watch.seconds());
    }
    if (!exact.defined()) exact = answer;
    table.add({form, options.text_tokens, static_cast<double>(encoder.weights().bytes()) / 1e9, open_seconds,
               median(seconds), static_cast<double>(peak_memory()) / 1e9, relative_error(answer, exact),
               answer.square().mean().sqrt().item<double>()});
  }
  return {table};
}

}  // namespace uwv::bench
