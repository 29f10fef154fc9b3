// SPDX-License-Identifier: Apache-2.0
#include "model/diffusion/clip_tensors.h"

#include <ATen/ATen.h>

#include <algorithm>

#include "model/diffusion/completion_setup.h"
#include "model/diffusion/conditioning.h"

namespace uwv::model {
namespace {

at::Tensor padded(const at::Tensor& frame) {
  const std::int64_t down = whole_side(frame.size(3)) - frame.size(3),
                     right = whole_side(frame.size(4)) - frame.size(4);
  return down == 0 && right == 0 ? frame : at::replication_pad3d(frame, {0, right, 0, down, 0, 0});
}

at::Tensor mask_tensor(const GenerateMask& holes) {
  const auto bytes =
      at::from_blob(const_cast<std::uint8_t*>(holes.data()), {1, 1, 1, holes.height(), holes.width()}, at::kByte);
  return bytes.ne(0).to(at::kFloat);
}

/// Frames one by one, the last one again for those behind it.
ClipSource frame_by_frame(long frames, std::function<at::Tensor(long)> read) {
  return [frames, read = std::move(read)](std::int64_t first, std::int64_t count) {
    std::vector<at::Tensor> parts;
    for (std::int64_t k = first; k < first + count; ++k) parts.push_back(padded(read(std::min<long>(k, frames - 1))));
    return parts.size() == 1 ? parts.front() : at::cat(parts, 2);
  };
}

}  // namespace

at::Tensor to_tensor(const ImageRgb& picture) {
  const auto bytes =
      at::from_blob(const_cast<Rgb8*>(picture.data()), {picture.height(), picture.width(), 3}, at::kByte);
  return bytes.permute({2, 0, 1}).to(at::kFloat).contiguous().div_(127.5).sub_(1).unsqueeze(0).unsqueeze(2);
}

ClipTensors padded_tensors(const RenderedClip& clip) {
  require(clip.frames >= 1 && clip.size.width >= 1 && clip.size.height >= 1 && clip.read,
          "a clip of {} frames of {}x{} pixels cannot be completed", clip.frames, clip.size.width, clip.size.height);
  ClipTensors tensors;
  tensors.frames = whole_frames(clip.frames);
  tensors.height = whole_side(clip.size.height);
  tensors.width = whole_side(clip.size.width);
  const auto read = [&clip](long k, ImageRgb& colour, GenerateMask& holes) {
    clip.read(k, colour, holes);
    require(colour.size() == clip.size && holes.size() == clip.size, "frame {} is {}x{}, wanted {}x{}", k,
            colour.width(), colour.height(), clip.size.width, clip.size.height);
  };
  tensors.video = frame_by_frame(clip.frames, [read](long k) {
    ImageRgb colour;
    GenerateMask holes;
    read(k, colour, holes);
    return to_tensor(colour);
  });
  tensors.mask = frame_by_frame(clip.frames, [read](long k) {
    ImageRgb colour;
    GenerateMask holes;
    read(k, colour, holes);
    return mask_tensor(holes);
  });
  if (!clip.read_source) return tensors;
  tensors.source_frames = clip.frames;
  tensors.source = frame_by_frame(clip.frames, [&clip](long k) {
    ImageRgb colour;
    clip.read_source(k, colour);
    require(colour.size() == clip.size, "source frame {} is {}x{}, wanted {}x{}", k, colour.width(), colour.height(),
            clip.size.width, clip.size.height);
    return to_tensor(colour);
  });
  return tensors;
}

}  // namespace uwv::model
