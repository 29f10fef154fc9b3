// SPDX-License-Identifier: Apache-2.0
#include "model/weights/wan_names.h"

#include <array>
#include <charconv>
#include <optional>
#include <string_view>
#include <utility>

namespace uwv::model {
namespace {

using Part = std::pair<std::string_view, std::string_view>;  // theirs, ours

/// `name` with the beginning `from` replaced by `to`; both end at a dot or at the end of the name.
std::optional<std::string> with_beginning(std::string_view name, const Part& part) {
  const auto& [from, to] = part;
  if (!name.starts_with(from) || (name.size() > from.size() && name[from.size()] != '.')) return std::nullopt;
  return std::string(to) + std::string(name.substr(from.size()));
}

template <std::size_t n>
std::string with_first_beginning(std::string_view name, const std::array<Part, n>& parts) {
  for (const Part& part : parts)
    if (auto renamed = with_beginning(name, part)) return *renamed;
  return std::string(name);
}

/// "<list>.<number>.<rest>", or nothing when the name is none of the list's.
struct Member {
  int number = 0;
  std::string_view rest;
};
std::optional<Member> member_of(std::string_view name, std::string_view list) {
  if (!name.starts_with(list)) return std::nullopt;
  name.remove_prefix(list.size());
  Member member;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), member.number);
  const auto digits = static_cast<std::size_t>(end - name.data());
  if (error != std::errc() || digits == name.size() || name[digits] != '.') return std::nullopt;
  member.rest = name.substr(digits + 1);
  return member;
}

std::string joined(std::string_view list, int number, std::string_view rest) {
  return std::string(list) + std::to_string(number) + "." + std::string(rest);
}

constexpr std::array<Part, 8> transformer_parts{{{"time_embedding.0", "condition_embedder.time_embedder.linear_1"},
                                                 {"time_embedding.2", "condition_embedder.time_embedder.linear_2"},
                                                 {"text_embedding.0", "condition_embedder.text_embedder.linear_1"},
                                                 {"text_embedding.2", "condition_embedder.text_embedder.linear_2"},
                                                 {"time_projection.1", "condition_embedder.time_proj"},
                                                 {"head.head", "proj_out"},
                                                 {"head.modulation", "scale_shift_table"},
                                                 {"modulation", "scale_shift_table"}}};

/// Wan numbers its norms in another order: the one with weights is its third.
constexpr std::array<Part, 18> block_parts{{{"self_attn.q", "attn1.to_q"},
                                            {"self_attn.k", "attn1.to_k"},
                                            {"self_attn.v", "attn1.to_v"},
                                            {"self_attn.o", "attn1.to_out.0"},
                                            {"self_attn.norm_q", "attn1.norm_q"},
                                            {"self_attn.norm_k", "attn1.norm_k"},
                                            {"cross_attn.q", "attn2.to_q"},
                                            {"cross_attn.k", "attn2.to_k"},
                                            {"cross_attn.v", "attn2.to_v"},
                                            {"cross_attn.o", "attn2.to_out.0"},
                                            {"cross_attn.norm_q", "attn2.norm_q"},
                                            {"cross_attn.norm_k", "attn2.norm_k"},
                                            {"norm3", "norm2"},
                                            {"ffn.0", "ffn.net.0.proj"},
                                            {"ffn.2", "ffn.net.2"},
                                            {"modulation", "scale_shift_table"},
                                            {"before_proj", "proj_in"},
                                            {"after_proj", "proj_out"}}};

constexpr std::array<Part, 5> residual_parts{{{"residual.0", "norm1"},
                                              {"residual.2", "conv1"},
                                              {"residual.3", "norm2"},
                                              {"residual.6", "conv2"},
                                              {"shortcut", "conv_shortcut"}}};

constexpr std::array<Part, 3> coder_parts{{{"conv1", "conv_in"}, {"head.0", "norm_out"}, {"head.2", "conv_out"}}};

/// A weight of the encoder or the decoder, without that word.
std::string coder_name(std::string_view name) {
  if (const auto middle = member_of(name, "middle.")) {
    if (middle->number == 1) return "mid_block.attentions.0." + std::string(middle->rest);
    return joined("mid_block.resnets.", middle->number / 2, with_first_beginning(middle->rest, residual_parts));
  }
  if (const auto down = member_of(name, "downsamples."))
    return joined("down_blocks.", down->number, with_first_beginning(down->rest, residual_parts));
  if (const auto up = member_of(name, "upsamples.")) {
    // Three residual blocks a level, and what makes the next level larger.
    constexpr int a_level = 4, residuals = 3;
    const std::string level = joined("up_blocks.", up->number / a_level, "");
    if (up->number % a_level == residuals) return level + "upsamplers.0." + std::string(up->rest);
    return level + joined("resnets.", up->number % a_level, with_first_beginning(up->rest, residual_parts));
  }
  return with_first_beginning(name, coder_parts);
}

}  // namespace

std::string without_prefix(const std::string& name) {
  for (const std::string_view prefix : {"model.diffusion_model.", "diffusion_model.", "model."})
    if (name.starts_with(prefix)) return name.substr(prefix.size());
  return name;
}

std::string transformer_diffusers_name(const std::string& full_name) {
  const std::string name = without_prefix(full_name);
  for (const std::string_view list : {"blocks.", "vace_blocks."})
    if (const auto block = member_of(name, list))
      return joined(list, block->number, with_first_beginning(block->rest, block_parts));
  return with_first_beginning(name, transformer_parts);
}

std::string vae_diffusers_name(const std::string& full_name) {
  constexpr std::array<Part, 2> outer{{{"conv1", "quant_conv"}, {"conv2", "post_quant_conv"}}};
  const std::string name = without_prefix(full_name);
  for (const std::string_view coder : {"encoder.", "decoder."})
    if (name.starts_with(coder)) return std::string(coder) + coder_name(std::string_view(name).substr(coder.size()));
  return with_first_beginning(name, outer);
}

}  // namespace uwv::model
