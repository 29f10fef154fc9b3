// SPDX-License-Identifier: Apache-2.0
// What leaving out known tokens saves, and what it changes in the hole.
#include <ATen/ATen.h>
#include <ATen/CPUGeneratorImpl.h>

#include <algorithm>
#include <cmath>

#include "bench/model_commands.h"
#include "bench/timing.h"
#include "model/diffusion/known_tokens.h"
#include "model/layers/torch_scope.h"
#include "model/transformer/wan_transformer.h"

namespace uwv::bench {
namespace {

constexpr std::int64_t text_length = 512;
constexpr double timestep = 500;

struct Clip {
  at::Tensor latents, control, text;
};

Clip random_clip(const ModelBenchOptions& options, const model::TransformerConfig& config) {
  const at::Generator generator = at::detail::createCPUGenerator(options.seed);
  const std::int64_t rows = options.height / 16 * 2, columns = options.width / 16 * 2,
                     frames = (options.frames - 1) / 4 + 1;
  const auto random = [&](at::IntArrayRef sizes) { return at::randn(sizes, generator, at::TensorOptions(at::kFloat)); };
  return {random({1, config.in_channels, frames, rows, columns}),
          random({1, config.vace_in_channels, frames, rows, columns}), random({1, text_length, config.text_dim})};
}

/// The right of the picture in every frame but the first, as when the camera turns.
at::Tensor hole_on_the_right(const Clip& clip, double share) {
  const std::int64_t frames = clip.latents.size(2), rows = clip.latents.size(3) / 2, columns = clip.latents.size(4) / 2;
  const std::int64_t wide = std::max<std::int64_t>(1, std::lround(share * static_cast<double>(columns)));
  at::Tensor unknown = at::zeros({frames, rows, columns}, at::kBool);
  unknown.slice(0, 1).slice(2, columns - wide).fill_(true);
  return unknown;
}

struct Step {
  at::Tensor velocity;
  double seconds = 0;
};

Step step(const model::WanTransformer& network, const Clip& clip, const at::Tensor& kept, int runs) {
  model::TransformerContext context = network.prepare(clip.control, {}, clip.text);
  context.kept = kept;
  const at::Tensor time = at::full({1}, timestep);
  Step result;
  result.velocity = network.forward(context, clip.latents, time);  // fills in what later steps find
  std::vector<double> seconds;
  for (int run = 0; run < std::max(1, runs); ++run) {
    const Stopwatch watch;
    network.forward(context, clip.latents, time);
    seconds.push_back(watch.seconds());
  }
  result.seconds = median(seconds);
  return result;
}

/// Root mean square of the difference over that of the exact, where `where` says.
double relative_error(const at::Tensor& ours, const at::Tensor& exact, const at::Tensor& where) {
  const at::Tensor mask = where.expand_as(exact);
  const at::Tensor a = ours.masked_select(mask), b = exact.masked_select(mask);
  return ((a - b).square().mean().sqrt() / b.square().mean().sqrt()).item<double>();
}

}  // namespace

std::vector<Table> time_known_tokens(const ModelBenchOptions& options) {
  const model::TorchScope scope(options.threads);
  model::TransformerOptions how;
  how.form = model::linear_form(options.forms.front());
  const model::WanTransformer network = model::WanTransformer::open(options.model + "/transformer", how);
  const Clip clip = random_clip(options, network.config());
  const Step whole = step(network, clip, {}, options.runs);
  Table table("known tokens left out", {"hole", "margin", "tokens_kept", "share", "step_s", "time_share", "error"});
  for (const double share : options.holes)
    for (const int margin : options.margins) {
      const at::Tensor unknown = hole_on_the_right(clip, share), near = model::near_unknown(unknown, margin);
      const at::Tensor kept = model::places_of(near);
      const Step cut = step(network, clip, kept, options.runs);
      table.add({share, margin, kept.numel(), static_cast<double>(kept.numel()) / static_cast<double>(near.numel()),
                 cut.seconds, cut.seconds / whole.seconds,
                 relative_error(cut.velocity, whole.velocity, model::latents_of_tokens(unknown))});
    }
  return {table};
}

}  // namespace uwv::bench
