// SPDX-License-Identifier: Apache-2.0
#include <ATen/ATen.h>
#include <ATen/CPUGeneratorImpl.h>

#include <algorithm>
#include <cmath>

#include "bench/model_commands.h"
#include "bench/timing.h"
#include "model/layers/torch_scope.h"
#include "model/vae/vae_cost.h"
#include "model/vae/wan_vae.h"
#include "model/weights/freed_memory.h"
#include "uwv/core/peak_memory.h"

namespace uwv::bench {
namespace {

/// "f32", "bf16", "auto", each perhaps with "/N" for N bands of rows; "direct" is f32 without Winograd's convolutions.
model::VaeOptions options_of(const std::string& form) {
  const auto slash = form.find('/');
  model::VaeOptions options;
  const std::string name = form.substr(0, slash);
  options.winograd = name != "direct";
  options.precision = options.winograd ? model::vae_precision(name) : model::VaePrecision::f32;
  if (slash != std::string::npos) options.bands = std::stoi(form.substr(slash + 1));
  return options;
}

struct Measured {
  double seconds = 0, processor_seconds = 0, peak_bytes = 0;
  at::Tensor answer;
};

Measured measure(const std::string& folder, const std::string& form, const at::Tensor& input, bool encodes) {
  const model::WanVae vae = model::WanVae::open(folder, options_of(form));
  Monitor monitor;
  model::give_back_freed_memory();  // of the forms before
  restart_peak_memory();
  const Stopwatch watch;
  Measured measured;
  measured.answer = encodes ? vae.encode(input, monitor) : vae.decode(input, monitor);
  measured.seconds = watch.seconds();
  measured.processor_seconds = watch.processor_seconds();
  measured.peak_bytes = static_cast<double>(peak_memory());
  return measured;
}

/// Of values in [-1, 1].
double psnr(const at::Tensor& ours, const at::Tensor& exact) {
  return 10 * std::log10(4 / (ours - exact).square().mean().item<double>());
}

double largest_difference(const at::Tensor& ours, const at::Tensor& exact) {
  return (ours - exact).abs().max().item<double>();
}

}  // namespace

std::vector<Table> time_vae(const ModelBenchOptions& options) {
  const model::TorchScope scope(options.threads);
  const std::string folder = options.model + "/vae";
  const model::VaeConfig config = model::VaeConfig::read(folder + "/config.json");
  const at::Generator generator = at::detail::createCPUGenerator(options.seed);
  const std::int64_t rows = options.height / config.spatial_factor(), columns = options.width / config.spatial_factor();
  const at::Tensor latents =
      at::randn({1, config.z_dim, config.latent_frames(options.frames), rows, columns}, generator);
  const at::Tensor video = at::rand({1, 3, options.frames, options.height, options.width}, generator) * 2 - 1;

  Table table("autoencoder", {"way", "form/bands", "frames", "s_per_frame", "cpu_s_per_frame", "peak_gb",
                              "estimated_gb", "largest_difference", "psnr"});
  for (const bool encodes : {false, true}) {
    if (std::find(options.ways.begin(), options.ways.end(), encodes ? "encode" : "decode") == options.ways.end())
      continue;
    at::Tensor exact;
    for (const std::string& form : options.forms) {
      const Measured measured = measure(folder, form, encodes ? video : latents, encodes);
      if (!exact.defined()) exact = measured.answer;
      const double estimated =
          model::estimated_peak_bytes(config, {options.frames, options.height, options.width}, options_of(form),
                                      encodes ? model::VaeWay::encode : model::VaeWay::decode);
      table.add({encodes ? "encode" : "decode", form, options.frames, measured.seconds / options.frames,
                 measured.processor_seconds / options.frames, measured.peak_bytes / 1e9, estimated / 1e9,
                 largest_difference(measured.answer, exact), figure(psnr(measured.answer, exact))});
    }
  }
  return {table};
}

}  // namespace uwv::bench
