// SPDX-License-Identifier: Apache-2.0
// Names that Wan's own releases, and programs that follow them, give to weights, as the names of diffusers. Sheet
// model.md, 2 and 7.
#pragma once

#include <string>

namespace uwv::model {

/// The name without "model.diffusion_model.", "diffusion_model." or "model.", which some programs put before all.
std::string without_prefix(const std::string& name);

/// The diffusers name of a transformer's weight ("blocks.0.self_attn.q.weight" is "blocks.0.attn1.to_q.weight"). Names
/// of diffusers, and unknown ones, come back as they are but for their prefix. Which dialect a name like
/// "blocks.0.norm3.weight" is of shows by itself: in diffusers' the norms with weights are called norm2.
std::string transformer_diffusers_name(const std::string& name);

/// The same for the autoencoder ("decoder.conv1.weight" is "decoder.conv_in.weight"). It has as many levels as Wan
/// 2.1's, each of two residual blocks, three in the decoder.
std::string vae_diffusers_name(const std::string& name);

}  // namespace uwv::model
