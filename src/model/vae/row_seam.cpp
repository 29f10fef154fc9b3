// SPDX-License-Identifier: Apache-2.0
#include "model/vae/row_seam.h"

#include <ATen/ATen.h>

#include "uwv/core/error.h"

namespace uwv::model {

at::Tensor RowSeam::join(const at::Tensor& fresh, const BandStep& step, const BandPlace& place) {
  at::Tensor all = fresh.contiguous();
  if (!place.first) {
    require(!kept_.empty(), "RowSeam: a band of {} rows went through more frames than the one above it", fresh.size(0));
    all = at::cat({kept_.front(), fresh});
    kept_.pop_front();
  }
  require(all.size(0) == step.all.count(), "RowSeam: {} rows are at hand, {} are wanted", all.size(0),
          step.all.count());
  if (!place.last) kept_.push_back(rows_of(all, step.all.begin, {step.keep_from, step.all.end}).clone());
  return all;
}

at::Tensor rows_of(const at::Tensor& frame, std::int64_t first, Rows wanted) {
  return frame.narrow(0, wanted.begin - first, wanted.count());
}

}  // namespace uwv::model
