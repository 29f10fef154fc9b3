// SPDX-License-Identifier: Apache-2.0
#include "model/mask_manifest.h"

#include "uwv/core/error.h"

namespace uwv::model {
namespace {

using detail::JsonNode;

constexpr std::array<std::pair<std::string_view, MaskKind>, 2> kinds{
    {{"foreground", MaskKind::foreground}, {"segmenter", MaskKind::segmenter}}};
constexpr std::array<std::pair<std::string_view, PromptRule>, 2> prompt_rules{
    {{"each", PromptRule::each}, {"together", PromptRule::together}}};

void check_layout(const JsonNode& root, const MaskManifest& manifest) {
  const bool clips = manifest.input.takes_clips();
  if (manifest.kind == MaskKind::segmenter && !clips)
    root["input"].complain("a segmenter needs a T (the frames) in 'layout', e.g. TCHW");
  if (manifest.kind == MaskKind::foreground && clips)
    root["input"].complain("one picture goes in: no T in 'layout', e.g. NCHW");
}

}  // namespace

MaskManifest read_mask_manifest(const std::string& path, MaskKind wanted) {
  const nlohmann::json json = read_manifest_json(path);
  const JsonNode root(json, "", path);
  root.check_keys({"format", "name", "model", "kind", "input", "outputs", "mask_rule", "mask_threshold", "prompts"});
  MaskManifest manifest;
  manifest.path = path;
  read_shared_keys(root, manifest);
  manifest.kind = choice(root["kind"], kinds);
  if (manifest.kind != wanted)
    root["kind"].refuse(wanted == MaskKind::foreground ? "'foreground' (a segmenter is given as --segmenter)"
                                                       : "'segmenter' (foreground networks are given as "
                                                         "--saliency-model)");
  manifest.input = read_input(root["input"]);
  check_layout(root, manifest);
  read_outputs(root["outputs"], {{"mask"}, {}}, manifest);
  if (root.has("mask_rule")) manifest.mask_is_logit = choice(root["mask_rule"], mask_rules);
  for (const std::string_view key : {"mask_threshold", "prompts"})
    if (root.has(key) && manifest.kind != MaskKind::segmenter) root[key].complain("goes with the kind 'segmenter'");
  if (root.has("mask_threshold")) manifest.mask_threshold = root["mask_threshold"].number({0, 1});
  if (root.has("prompts")) manifest.prompts = choice(root["prompts"], prompt_rules);
  return manifest;
}

}  // namespace uwv::model
