// SPDX-License-Identifier: Apache-2.0
// Frames of features that are used again instead of being given back to the system: at full size each one would cost
// tens of thousands of page faults.
#pragma once

#include <ATen/core/Tensor.h>

#include <map>
#include <vector>

namespace uwv::model {

/// Hands out frames (H, W, C), contiguous, of one type of number on one device. What a frame holds at first is left
/// over.
class FramePool {
 public:
  explicit FramePool(at::ScalarType type, c10::Device device = c10::kCPU) : type_(type), device_(device) {}
  at::ScalarType type() const { return type_; }
  c10::Device device() const { return device_; }
  at::Tensor take(std::int64_t height, std::int64_t width, std::int64_t channels);
  /// One with the numbers of `frame`, whatever their type and wherever they are.
  at::Tensor copy_of(const at::Tensor& frame);
  /// Back from take() or copy_of(); nobody else refers to it any more. Frames from elsewhere would pile up here.
  void give(at::Tensor frame);

 private:
  at::ScalarType type_;
  c10::Device device_;
  std::map<std::vector<std::int64_t>, std::vector<at::Tensor>> idle_;
};

/// The last frames a causal convolution read: at most three while it runs, two between.
class FrameHistory {
 public:
  bool empty() const { return frames_.empty(); }
  /// Frames at hand, the newest with `back` 0.
  std::size_t size() const { return frames_.size(); }
  const at::Tensor& frame(std::size_t back) const { return frames_[frames_.size() - 1 - back]; }
  void push(at::Tensor frame) { frames_.push_back(std::move(frame)); }
  /// Remembers `frame`, of the pool, in the newest one's place, which goes back.
  void replace_newest(at::Tensor frame, FramePool& pool);
  /// Gives all but the newest `count` back.
  void keep(std::size_t count, FramePool& pool);

 private:
  std::vector<at::Tensor> frames_;
};

}  // namespace uwv::model
