// SPDX-License-Identifier: Apache-2.0
// What a layer keeps of a band for the one below: see row_bands.h.
#pragma once

#include <ATen/core/Tensor.h>

#include <deque>

#include "model/vae/frame_pool.h"
#include "model/vae/row_bands.h"

namespace uwv::model {

/// The last rows a layer was given, of every frame of a clip. Each band goes through the frames in the same order, so
/// the first rows kept are the first wanted; of the clip's frames, none is held twice.
class RowSeam {
 public:
  /// For one frame's fresh rows (rows, W, C): all that the step has at hand, contiguous, of `pool` where they were not
  /// there yet. Keeps of them, in `seams`, what the step says for the band below, if there is one.
  at::Tensor join(const at::Tensor& fresh, const BandStep& step, const BandPlace& place, const FramePool& pool,
                  const FramePool& seams);

 private:
  std::deque<at::Tensor> kept_;
};

/// Rows of a frame that begins with row `first`.
at::Tensor rows_of(const at::Tensor& frame, std::int64_t first, Rows wanted);

}  // namespace uwv::model
