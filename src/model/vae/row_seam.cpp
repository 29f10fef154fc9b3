// SPDX-License-Identifier: Apache-2.0
#include "model/vae/row_seam.h"

#include <ATen/ATen.h>

#include "uwv/core/error.h"

namespace uwv::model {

at::Tensor RowSeam::join(const at::Tensor& fresh, const BandStep& step, const BandPlace& place, const FramePool& pool,
                         const FramePool& seams) {
  at::Tensor all = fresh;
  if (!place.first) {
    require(!kept_.empty(), "RowSeam: a band of {} rows went through more frames than the one above it", fresh.size(0));
    const std::int64_t above = kept_.front().size(0);
    all = pool.take(above + fresh.size(0), fresh.size(1), fresh.size(2));
    all.narrow(0, 0, above).copy_(kept_.front());
    all.narrow(0, above, fresh.size(0)).copy_(fresh);
    kept_.pop_front();
  } else if (!fresh.is_contiguous()) {
    all = pool.copy_of(fresh);
  }
  require(all.size(0) == step.all.count(), "RowSeam: {} rows are at hand, {} are wanted", all.size(0),
          step.all.count());
  if (!place.last) kept_.push_back(seams.copy_of(rows_of(all, step.all.begin, {step.keep_from, step.all.end})));
  return all;
}

at::Tensor rows_of(const at::Tensor& frame, std::int64_t first, Rows wanted) {
  return frame.narrow(0, wanted.begin - first, wanted.count());
}

}  // namespace uwv::model
