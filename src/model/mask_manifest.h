// SPDX-License-Identifier: Apache-2.0
// manifest.json of a network that finds the foreground of a picture, or follows it through a clip. docs/depth-models.md
// is its reference.
#pragma once

#include <string>

#include "model/network_manifest.h"

namespace uwv::model {

enum class MaskKind {
  foreground,  ///< A picture in, its foreground out: matting and saliency networks.
  segmenter,   ///< A clip and points of its first frame in, what they belong to out: SAM 2 and its like.
};
/// How a segmenter is asked.
enum class PromptRule {
  each,      ///< Once for each point; the answers are united, as the official code does.
  together,  ///< Once, with all points.
};

struct MaskManifest : NetworkManifest {
  MaskKind kind = MaskKind::foreground;
  bool mask_is_logit = false;
  double mask_threshold = 0.5;  ///< segmenter: a larger probability is foreground.
  PromptRule prompts = PromptRule::each;
};

/// Throws Error(file_not_found, file_damaged, value_invalid): also when its kind is not `wanted`.
MaskManifest read_mask_manifest(const std::string& path, MaskKind wanted);

}  // namespace uwv::model
