// SPDX-License-Identifier: Apache-2.0
#include "model/vae/frame_pool.h"

#include <ATen/ATen.h>

#include <iterator>
#include <utility>

namespace uwv::model {

FramePool::FramePool(at::ScalarType type, c10::Device device)
    : type_(type), device_(device), idle_(std::make_shared<Idle>()), idle_brief_(std::make_shared<Idle>()) {}

at::Tensor FramePool::fresh(std::int64_t numbers) const {
  return at::empty({numbers}, at::TensorOptions(type_).device(device_));
}

at::Tensor FramePool::lent(at::Tensor memory, c10::IntArrayRef shape, const std::shared_ptr<Idle>& idle) const {
  void* const numbers = memory.data_ptr();
  const auto options = memory.options();
  const auto come_back = [memory = std::move(memory), pool = std::weak_ptr(idle)](void*) {
    if (const auto still_there = pool.lock()) still_there->emplace(memory.numel(), memory);
  };
  return at::from_blob(numbers, shape, come_back, options, device_);
}

at::Tensor FramePool::take(std::int64_t height, std::int64_t width, std::int64_t channels) const {
  const std::int64_t wanted = height * width * channels;
  if (wanted == 0) return fresh(0).view({height, width, channels});
  const auto found = idle_->lower_bound(wanted);
  if (found == idle_->end() || found->first > wanted + wanted / 4)
    return lent(fresh(wanted), {height, width, channels}, idle_);
  at::Tensor memory = std::move(found->second);
  idle_->erase(found);
  return lent(std::move(memory), {height, width, channels}, idle_);
}

at::Tensor FramePool::take_briefly(std::int64_t numbers) const {
  at::Tensor memory;
  if (!idle_brief_->empty()) {
    const auto largest = std::prev(idle_brief_->end());
    if (largest->first >= numbers) memory = std::move(largest->second);
    idle_brief_->erase(largest);
  }
  return lent(memory.defined() ? std::move(memory) : fresh(numbers), {numbers}, idle_brief_);
}

at::Tensor FramePool::copy_of(const at::Tensor& frame) const {
  return take(frame.size(0), frame.size(1), frame.size(2)).copy_(frame);
}

void FrameHistory::keep(std::size_t count) {
  if (frames_.size() > count) frames_.erase(frames_.begin(), frames_.end() - static_cast<std::ptrdiff_t>(count));
}

}  // namespace uwv::model
