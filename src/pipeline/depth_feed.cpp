// SPDX-License-Identifier: Apache-2.0
#include "pipeline/depth_feed.h"

#include <cmath>

namespace uwv::pipeline {

DepthFeed::DepthFeed(const RunOptions& options, Size full_size, Size working_size, const Intrinsics& full_intrinsics,
                     long clip_frames, Monitor& monitor)
    : path_(options.disparity.empty() ? options.depth : options.disparity),
      full_size_(full_size),
      working_size_(working_size),
      single_(options.static_depth),
      is_disparity_(!options.disparity.empty()),
      is_inverse_(options.depth_kind == DepthKind::inverse),
      fx_times_baseline_(std::abs(full_intrinsics.fx) * options.baseline),
      doffs_(options.doffs) {
  DepthOptions depth_options;
  depth_options.scale = options.depth_scale.value_or(is_disparity_ ? 1 : 0);
  depth_options.key = options.depth_key;
  if (!single_) {
    depth_options.start = options.start;
    depth_options.stride = options.stride;
  }
  source_ = open_depth(path_, depth_options, monitor);
  if (!single_ && source_->frames() < clip_frames)
    fail(ErrorCode::size_mismatch,
         "{}: found depth for {} frames, wanted {}, one per frame of {}; use --max-frames {}, or --static-depth for a "
         "camera that stands still",
         path_, source_->frames(), clip_frames, options.video, source_->frames());
}

void DepthFeed::read(long index, DepthMap& depth) {
  if (!source_->read(single_ ? 0 : index, depth))
    fail(ErrorCode::file_damaged, "{}: ends before frame {}", path_, index);
  if (is_disparity_) disparity_to_depth(depth);
  if (is_inverse_) invert(depth);
  if (depth.size() != working_size_) depth = resize_depth(depth, working_size_);
}

void DepthFeed::disparity_to_depth(DepthMap& disparity) const {
  // A map smaller than the picture counts in its own, larger pixels.
  const double pixels = static_cast<double>(disparity.width()) / full_size_.width;
  for (float& value : disparity.pixels()) {
    const double shift = value / pixels + doffs_;
    value = value > 0 && shift > 0 ? static_cast<float>(fx_times_baseline_ / shift) : 0.0F;
  }
  sanitize_depth(disparity);
}

void DepthFeed::invert(DepthMap& inverse_depth) {
  for (float& value : inverse_depth.pixels()) value = value > 0 ? 1 / value : 0.0F;
  sanitize_depth(inverse_depth);
}

}  // namespace uwv::pipeline
