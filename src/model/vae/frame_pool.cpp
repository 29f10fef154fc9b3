// SPDX-License-Identifier: Apache-2.0
#include "model/vae/frame_pool.h"

#include <ATen/ATen.h>

namespace uwv::model {

at::Tensor FramePool::take(std::int64_t height, std::int64_t width, std::int64_t channels) {
  auto& idle = idle_[{height, width, channels}];
  if (idle.empty()) return at::empty({height, width, channels}, at::TensorOptions(type_).device(device_));
  at::Tensor frame = std::move(idle.back());
  idle.pop_back();
  return frame;
}

at::Tensor FramePool::copy_of(const at::Tensor& frame) {
  return take(frame.size(0), frame.size(1), frame.size(2)).copy_(frame);
}

void FramePool::give(at::Tensor frame) { idle_[frame.sizes().vec()].push_back(std::move(frame)); }

void FrameHistory::replace_newest(at::Tensor frame, FramePool& pool) {
  pool.give(std::move(frames_.back()));
  frames_.back() = std::move(frame);
}

void FrameHistory::keep(std::size_t count, FramePool& pool) {
  while (frames_.size() > count) {
    pool.give(std::move(frames_.front()));
    frames_.erase(frames_.begin());
  }
}

}  // namespace uwv::model
