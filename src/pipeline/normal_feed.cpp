// SPDX-License-Identifier: Apache-2.0
#include "pipeline/normal_feed.h"

#include <fmt/ranges.h>

namespace uwv::pipeline {
namespace {

constexpr std::size_t max_side = 65535;

}  // namespace

NormalFeed::NormalFeed(const RunOptions& options, Size working_size, long clip_frames)
    : reader_(options.normals),
      working_size_(working_size),
      single_(reader_.header().shape.size() == 3),
      start_(single_ ? 0 : options.start),
      stride_(single_ ? 0 : options.stride) {
  const std::vector<std::size_t>& shape = reader_.header().shape;
  const std::size_t axes = shape.size();
  const bool fits = (axes == 3 || axes == 4) && shape[axes - 1] == 3 && shape[axes - 2] >= 1 && shape[axes - 3] >= 1 &&
                    shape[axes - 2] <= max_side && shape[axes - 3] <= max_side;
  if (!fits)
    fail(ErrorCode::size_mismatch, "{}: found an array of shape ({}), wanted normals (h, w, 3) or (n, h, w, 3)",
         options.normals, fmt::join(shape, ", "));
  stored_size_ = {static_cast<int>(shape[axes - 2]), static_cast<int>(shape[axes - 3])};
  const long frames = single_ ? 1 : static_cast<long>(shape[0]);
  const long wanted = single_ && options.static_depth ? 1 : start_ + (clip_frames - 1) * options.stride + 1;
  if (frames < wanted)
    fail(ErrorCode::size_mismatch, "{}: found normals of {} frames, wanted {}, as many as {} uses", options.normals,
         frames, wanted, options.video);
}

SlopeMap NormalFeed::read(long index, const Intrinsics& intrinsics) {
  const std::size_t pixels = stored_size_.pixels();
  values_.resize(pixels * 3);
  reader_.read(single_ ? 0 : static_cast<std::size_t>(start_ + index * stride_), std::span<float>(values_));
  // Nearest neighbour: a blend of two surfaces' normals belongs to neither.
  NormalMap normals(working_size_, Eigen::Vector3f::Zero());
  for (int y = 0; y < working_size_.height; ++y)
    for (int x = 0; x < working_size_.width; ++x) {
      const auto from_x = static_cast<std::size_t>((2L * x + 1) * stored_size_.width / (2L * working_size_.width));
      const auto from_y = static_cast<std::size_t>((2L * y + 1) * stored_size_.height / (2L * working_size_.height));
      const float* n = &values_[(from_y * static_cast<std::size_t>(stored_size_.width) + from_x) * 3];
      normals(x, y) = Eigen::Vector3f(n[0], n[1], n[2]);
    }
  return slopes_from_normals(normals, intrinsics);
}

}  // namespace uwv::pipeline
