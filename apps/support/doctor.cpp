// SPDX-License-Identifier: Apache-2.0
#include "support/doctor.h"

#include <fmt/format.h>

#include "uwv/core/error.h"
#include "uwv/core/matrix_library.h"
#include "uwv/core/processor.h"
#include "uwv/model/compute_devices.h"
#include "uwv/pipeline/environment.h"

namespace uwv::app {
namespace {

#ifdef UWV_APP_WITH_MODEL
constexpr bool has_networks = true;
#else
constexpr bool has_networks = false;
#endif

std::string matrix_products() {
  const MatrixLibrary library = matrix_library();
  if (library.replaced()) return fmt::format("by {} instead of libtorch's own: float32 is slow", library.used);
  return library.used.empty() ? "no library is loaded for them" : "by " + library.used;
}

/// What --device can be.
std::string model_devices() {
#ifdef UWV_APP_WITH_MODEL
  std::string text;
  for (const ComputeDevice& device : compute_devices()) {
    text += (text.empty() ? "" : ", ") + device.name;
    if (device.free_bytes)
      text += fmt::format(" ({:.1f} GiB free)", static_cast<double>(*device.free_bytes) / (1024.0 * 1024 * 1024));
  }
  return text;
#else
  return "none";
#endif
}

/// Whether numbers of fewer bits pay, else the form that holds but does not multiply them.
std::string weights_in(bool fast, const char* instead) {
  return fast ? "fast here" : fmt::format("slow here: take {}", instead);
}

FastNumbers model_numbers() {
#ifdef UWV_APP_WITH_MODEL
  return fast_numbers();
#else
  return {};
#endif
}

bool has_gpu() {
  try {
    return !make_gl_context()->is_software();
  } catch (const Error&) {  // why not is already in the list above
    return false;
  }
}

}  // namespace

std::string doctor_report() {
  std::string text = "versions\n";
  for (const auto& [name, version] : component_versions()) text += fmt::format("  {:<14} {}\n", name, version);

  const Machine machine = this_machine();
  text += fmt::format("machine\n  {:<14} {}\n  {:<14} {}\n  {:<14} {}\n  {:<14} {:.1f} GiB\n", "processor",
                      machine.processor.empty() ? "unknown" : machine.processor, "its units", processor_units().names(),
                      "threads", machine.threads, "memory", machine.memory_gib);

  text += "renderers\n  cpu            yes\n";
  for (const GlProbe& probe : probe_gl_backends())
    text += fmt::format(
        "  {:<14} {}\n", probe.name,
        probe.usable ? fmt::format("yes: {}, OpenGL {}", probe.renderer, probe.version) : "no: " + probe.reason);
  text += fmt::format("  {:<14} {}\n", "auto takes", has_gpu() ? "gl" : "cpu (no GPU: OpenGL would only be emulated)");

  text += fmt::format("networks\n  {:<14} {}\n", "TorchScript",
                      has_networks ? "yes (--depth-model, --saliency-model DIR, --segmenter)"
                                   : "no: built without libtorch, which scripts/setup fetches");

  const FastNumbers fast = model_numbers();
  text += fmt::format("video diffusion model\n  {:<14} {}\n  {:<14} {}\n  {:<14} {}\n  {:<14} {}\n  {:<14} {}\n",
                      "libtorch",
                      has_networks ? "yes (--model)" : "no: built without libtorch, which scripts/setup fetches",
                      "--device", model_devices(), "weights bf16", weights_in(fast.bf16, "bf16_stored"), "weights int8",
                      weights_in(fast.int8, "int8_stored"), "products", matrix_products());

  text += "video\n";
  for (const Capability& encoder : encoders())
    text += fmt::format("  {:<24} {}\n", encoder.name, encoder.usable ? "yes" : "no: " + encoder.effect);
  return text;
}

}  // namespace uwv::app
