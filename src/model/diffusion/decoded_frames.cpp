// SPDX-License-Identifier: Apache-2.0
#include "model/diffusion/decoded_frames.h"

#include <ATen/ATen.h>

namespace uwv::model {
namespace {

/// Of the first frame's pixels; a fit to fewer tells of a corner, not of the clip.
constexpr double least_known_share = 0.05;

}  // namespace

DecodedFrames::DecodedFrames(const RenderedClip& clip, const CompletedClip& out, bool colour_correction)
    : clip_(clip), out_(out), uncorrected_(colour_correction ? "" : "colour_correction is off") {}

ImageFloat3 DecodedFrames::cropped(const at::Tensor& frame) const {
  const at::Tensor pixels = frame.narrow(1, 0, clip_.size.height)
                                .narrow(2, 0, clip_.size.width)
                                .permute({1, 2, 0})
                                .mul(127.5)
                                .add(127.5)
                                .contiguous();
  ImageFloat3 picture(clip_.size);
  for (std::size_t i = 0; i < clip_.size.pixels(); ++i)
    picture.data()[i] = Eigen::Map<const Eigen::Vector3f>(pixels.data_ptr<float>() + 3 * i);
  return picture;
}

void DecodedFrames::fit(const ImageFloat3& first_frame) {
  ImageRgb wanted;
  GenerateMask holes;
  clip_.read(0, wanted, holes);
  const ValidityMask known = to_validity(holes);
  if (static_cast<double>(known.count()) < least_known_share * static_cast<double>(clip_.size.pixels())) {
    uncorrected_ = "too little of the first frame is known";
    return;
  }
  colours_ = fit_colours(first_frame, wanted, known);
}

void DecodedFrames::take(std::int64_t first, const at::Tensor& frames) {
  for (std::int64_t i = 0; i < frames.size(2) && first + i < clip_.frames; ++i) {
    const ImageFloat3 decoded = cropped(frames[0].select(1, i));
    if (first + i == 0 && uncorrected_.empty()) fit(decoded);
    // Without a correction values are rounded; the official correction cuts them off.
    const ColourMap colours = colours_.value_or(ColourMap{Eigen::Matrix3d::Identity(), Eigen::Vector3d::Constant(0.5)});
    ImageRgb picture(clip_.size);
    for (std::size_t p = 0; p < clip_.size.pixels(); ++p) picture.data()[p] = colours(decoded.data()[p].cast<double>());
    out_.write(static_cast<long>(first + i), picture);
  }
}

}  // namespace uwv::model
