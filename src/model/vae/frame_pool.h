// SPDX-License-Identifier: Apache-2.0
// Frames of features that are used again instead of being given back to the system: at full size each one would cost
// tens of thousands of page faults, and between frames that stay, the heap would be left with gaps.
#pragma once

#include <ATen/core/Tensor.h>

#include <map>
#include <memory>
#include <vector>

namespace uwv::model {

/// Hands out frames (H, W, C), contiguous, of one type of number on one device. What a frame holds at first is left
/// over. A frame comes back by itself, when the last tensor that refers to it is gone; to a pool that is gone as well,
/// its memory is freed.
class FramePool {
 public:
  explicit FramePool(at::ScalarType type, c10::Device device = c10::kCPU);
  at::ScalarType type() const { return type_; }
  c10::Device device() const { return device_; }

  /// In memory of this size, or up to a quarter more.
  at::Tensor take(std::int64_t height, std::int64_t width, std::int64_t channels) const;
  /// (numbers), to be dropped before long: in the largest idle memory handed out so before, whatever its size, or in
  /// new memory in its place. Askers for several do well to ask for the largest first.
  at::Tensor take_briefly(std::int64_t numbers) const;
  /// One with the numbers of `frame`, whatever their type and wherever they are.
  at::Tensor copy_of(const at::Tensor& frame) const;

 private:
  /// Memory nobody uses at the moment, by how many numbers it holds.
  using Idle = std::multimap<std::int64_t, at::Tensor>;
  /// A tensor in `memory`, which goes to `idle` after it.
  at::Tensor lent(at::Tensor memory, c10::IntArrayRef shape, const std::shared_ptr<Idle>& idle) const;
  at::Tensor fresh(std::int64_t numbers) const;

  at::ScalarType type_;
  c10::Device device_;
  std::shared_ptr<Idle> idle_, idle_brief_;
};

/// The last frames a causal convolution read: at most three while it runs, two between.
class FrameHistory {
 public:
  bool empty() const { return frames_.empty(); }
  /// Frames at hand, the newest with `back` 0.
  std::size_t size() const { return frames_.size(); }
  const at::Tensor& frame(std::size_t back) const { return frames_[frames_.size() - 1 - back]; }
  void push(at::Tensor frame) { frames_.push_back(std::move(frame)); }
  /// Remembers `frame` in the newest one's place.
  void replace_newest(at::Tensor frame) { frames_.back() = std::move(frame); }
  /// Forgets all but the newest `count`.
  void keep(std::size_t count);

 private:
  std::vector<at::Tensor> frames_;
};

}  // namespace uwv::model
