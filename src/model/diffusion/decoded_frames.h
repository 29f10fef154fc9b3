// SPDX-License-Identifier: Apache-2.0
// From decoded frames to pictures: colours corrected, what was added to the clip cut off.
#pragma once

#include <ATen/core/Tensor.h>

#include <optional>

#include "model/diffusion/colour_correction.h"
#include "uwv/model/view_completion.h"

namespace uwv::model {

/// Takes frames in order and hands pictures on.
class DecodedFrames {
 public:
  /// `clip` and `out` must outlive this.
  DecodedFrames(const RenderedClip& clip, const CompletedClip& out, bool colour_correction);

  /// (1, 3, n, H, W) in [-1, 1], of which `first` is the first's number. Rows, columns and frames beyond the clip's are
  /// dropped.
  void take(std::int64_t first, const at::Tensor& frames);
  /// Why colours were left as they are, or "".
  const std::string& uncorrected() const { return uncorrected_; }

 private:
  void fit(const ImageFloat3& first_frame);
  ImageFloat3 cropped(const at::Tensor& frame) const;

  const RenderedClip& clip_;
  const CompletedClip& out_;
  std::optional<ColourMap> colours_;
  std::string uncorrected_;
};

}  // namespace uwv::model
