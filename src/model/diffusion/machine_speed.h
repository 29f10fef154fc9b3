// SPDX-License-Identifier: Apache-2.0
// How fast this machine does what the model's time goes into, each measured for a moment in the form it will run in.
#pragma once

#include <c10/core/Device.h>

#include <cstdint>

#include "model/layers/linear_form.h"
#include "model/vae/vae_options.h"

namespace uwv::model {

/// Floating point operations a second of a layer `width` wide, its tokens' rounding included.
double linear_speed(LinearForm form, std::int64_t width, c10::Device device = c10::kCPU);
/// Of attention among `tokens` tokens with heads of `head_dim`, in the type of number the form hands it.
double attention_speed(LinearForm form, std::int64_t head_dim, std::int64_t tokens, c10::Device device = c10::kCPU);
/// Of the autoencoder's convolutions; of `channels`, as many as in the middle of the decoder unless told.
double convolution_speed(VaePrecision precision, c10::Device device = c10::kCPU, std::int64_t channels = 192);
/// Weights a second that are brought from `stored_bytes` each (4, 2 or 1) into a form, as a streamed pass does.
double rounding_speed(LinearForm form, int stored_bytes, std::int64_t width, c10::Device device = c10::kCPU);

}  // namespace uwv::model
