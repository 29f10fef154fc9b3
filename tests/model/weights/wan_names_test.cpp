// SPDX-License-Identifier: Apache-2.0
#include "model/weights/wan_names.h"

#include <gtest/gtest.h>

#include <regex>
#include <utility>
#include <vector>

#include "support/matchers.h"
#include "uwv/io/safetensors.h"

namespace uwv::model {
namespace {

using Replacements = std::vector<std::pair<const char*, const char*>>;

/// The first replacement whose pattern is found.
std::string replaced(const std::string& name, const Replacements& replacements) {
  for (const auto& [pattern, text] : replacements)
    if (std::regex_search(name, std::regex(pattern))) return std::regex_replace(name, std::regex(pattern), text);
  return name;
}

/// The name that Wan's release gives a weight, by the official conversion read backwards.
std::string original_transformer_name(const std::string& name) {
  std::string original = replaced(name, {{R"(^condition_embedder\.time_embedder\.linear_1)", "time_embedding.0"},
                                         {R"(^condition_embedder\.time_embedder\.linear_2)", "time_embedding.2"},
                                         {R"(^condition_embedder\.text_embedder\.linear_1)", "text_embedding.0"},
                                         {R"(^condition_embedder\.text_embedder\.linear_2)", "text_embedding.2"},
                                         {R"(^condition_embedder\.time_proj)", "time_projection.1"},
                                         {R"(^proj_out)", "head.head"},
                                         {R"(^scale_shift_table)", "head.modulation"},
                                         {R"(\.attn1\.to_out\.0)", ".self_attn.o"},
                                         {R"(\.attn2\.to_out\.0)", ".cross_attn.o"},
                                         {R"(\.attn1\.to_)", ".self_attn."},
                                         {R"(\.attn2\.to_)", ".cross_attn."},
                                         {R"(\.attn1\.)", ".self_attn."},
                                         {R"(\.attn2\.)", ".cross_attn."},
                                         {R"(\.norm2\.)", ".norm3."},
                                         {R"(\.ffn\.net\.0\.proj)", ".ffn.0"},
                                         {R"(\.ffn\.net\.2)", ".ffn.2"},
                                         {R"(\.scale_shift_table)", ".modulation"},
                                         {R"(\.proj_in)", ".before_proj"},
                                         {R"(\.proj_out)", ".after_proj"}});
  return original;
}

std::string original_vae_name(const std::string& name) {
  if (name.starts_with("quant_conv")) return "conv1" + name.substr(10);
  if (name.starts_with("post_quant_conv")) return "conv2" + name.substr(15);
  std::smatch match;
  std::string original = name;
  if (std::regex_match(name, match, std::regex(R"(decoder\.up_blocks\.(\d)\.resnets\.(\d)\.(.*))")))
    original =
        "decoder.upsamples." + std::to_string(std::stoi(match[1]) * 4 + std::stoi(match[2])) + "." + match[3].str();
  else if (std::regex_match(name, match, std::regex(R"(decoder\.up_blocks\.(\d)\.upsamplers\.0\.(.*))")))
    original = "decoder.upsamples." + std::to_string(std::stoi(match[1]) * 4 + 3) + "." + match[2].str();
  for (const auto& [theirs, ours] : Replacements{{R"(\.down_blocks\.)", ".downsamples."},
                                                 {R"(\.mid_block\.resnets\.0\.)", ".middle.0."},
                                                 {R"(\.mid_block\.attentions\.0\.)", ".middle.1."},
                                                 {R"(\.mid_block\.resnets\.1\.)", ".middle.2."},
                                                 {R"(\.conv_in\.)", ".conv1."},
                                                 {R"(\.norm_out\.)", ".head.0."},
                                                 {R"(\.conv_out\.)", ".head.2."}})
    if (std::regex_search(original, std::regex(theirs)))
      original = std::regex_replace(original, std::regex(theirs), ours);
  const bool in_block = original.find("samples.") != std::string::npos || original.find("middle.") != std::string::npos;
  return in_block ? replaced(original, {{R"(\.norm1\.)", ".residual.0."},
                                        {R"(\.conv1\.)", ".residual.2."},
                                        {R"(\.norm2\.)", ".residual.3."},
                                        {R"(\.conv2\.)", ".residual.6."},
                                        {R"(\.conv_shortcut\.)", ".shortcut."}})
                  : original;
}

TEST(WanNamesParity, EveryWeightOfTheTransformersIsFoundUnderItsOriginalName) {
  for (const char* folder : {"transformer/vace", "transformer/uniview", "transformer/t2v"}) {
    const SafeTensors file =
        SafeTensors::open(testing::fixture_folder(folder) + "/diffusion_pytorch_model.safetensors");
    for (const std::string& name : file.names()) {
      const std::string original = original_transformer_name(name);
      EXPECT_EQ(transformer_diffusers_name(original), name) << original;
      EXPECT_EQ(transformer_diffusers_name("model.diffusion_model." + original), name) << original;
      EXPECT_EQ(transformer_diffusers_name(name), name);
    }
  }
}

TEST(WanNamesParity, EveryWeightOfTheAutoencoderIsFoundUnderItsOriginalName) {
  const SafeTensors file = SafeTensors::open(testing::fixture_folder("vae") + "/diffusion_pytorch_model.safetensors");
  for (const std::string& name : file.names()) {
    const std::string original = original_vae_name(name);
    EXPECT_NE(original, name);
    EXPECT_EQ(vae_diffusers_name(original), name) << original;
    EXPECT_EQ(vae_diffusers_name(name), name);
  }
}

// Written out from Wan's own code, so that the two functions above cannot err together.
TEST(WanNames, KnowsNamesOfTheReleases) {
  for (const auto& [original, ours] : std::vector<std::pair<std::string, std::string>>{
           {"blocks.39.cross_attn.norm_k.weight", "blocks.39.attn2.norm_k.weight"},
           {"blocks.7.norm3.bias", "blocks.7.norm2.bias"},
           {"blocks.7.ffn.0.weight", "blocks.7.ffn.net.0.proj.weight"},
           {"vace_blocks.0.before_proj.weight", "vace_blocks.0.proj_in.weight"},
           {"vace_blocks.3.self_attn.o.bias", "vace_blocks.3.attn1.to_out.0.bias"},
           {"diffusion_model.head.modulation", "scale_shift_table"},
           {"blocks.1.modulation", "blocks.1.scale_shift_table"},
           {"patch_embedding.weight", "patch_embedding.weight"},
           {"something.else", "something.else"},
           {"blocks.x.norm3.bias", "blocks.x.norm3.bias"},
           {"blocks.99999999999.norm3.bias", "blocks.99999999999.norm3.bias"}})
    EXPECT_EQ(transformer_diffusers_name(original), ours);
  for (const auto& [original, ours] : std::vector<std::pair<std::string, std::string>>{
           {"encoder.conv1.weight", "encoder.conv_in.weight"},
           {"encoder.downsamples.3.shortcut.bias", "encoder.down_blocks.3.conv_shortcut.bias"},
           {"encoder.downsamples.5.time_conv.weight", "encoder.down_blocks.5.time_conv.weight"},
           {"encoder.downsamples.2.resample.1.weight", "encoder.down_blocks.2.resample.1.weight"},
           {"decoder.upsamples.7.time_conv.bias", "decoder.up_blocks.1.upsamplers.0.time_conv.bias"},
           {"decoder.upsamples.4.residual.6.weight", "decoder.up_blocks.1.resnets.0.conv2.weight"},
           {"decoder.middle.1.to_qkv.weight", "decoder.mid_block.attentions.0.to_qkv.weight"},
           {"decoder.head.0.gamma", "decoder.norm_out.gamma"},
           {"conv1.bias", "quant_conv.bias"},
           {"conv2.weight", "post_quant_conv.weight"}})
    EXPECT_EQ(vae_diffusers_name(original), ours);
}

}  // namespace
}  // namespace uwv::model
