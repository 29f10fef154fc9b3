// SPDX-License-Identifier: Apache-2.0
// The noise a clip is made from.
#pragma once

#include <ATen/core/Tensor.h>

#include <cstdint>

namespace uwv::model {

/// Normal noise of any shape, float32, from a generator of its own on the CPU: the same seed gives the same bytes on
/// every device and number of threads, and those that torch.randn gives in Python after manual_seed(seed). The official
/// code draws from the CUDA generator, seeded 42 whatever the user asks for; that noise cannot be had without CUDA.
at::Tensor seeded_noise(at::IntArrayRef shape, std::uint64_t seed);

}  // namespace uwv::model
