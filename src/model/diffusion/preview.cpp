// SPDX-License-Identifier: Apache-2.0
#include "model/diffusion/preview.h"

#include <ATen/ATen.h>

#include <algorithm>
#include <cmath>

namespace uwv::model {
namespace {

std::uint8_t level(float value) {
  return static_cast<std::uint8_t>(std::lround(std::clamp(127.5F * value + 127.5F, 0.0F, 255.0F)));
}

at::Tensor with_ones(const at::Tensor& rows) { return at::cat({rows, at::ones({rows.size(0), 1}, rows.options())}, 1); }

}  // namespace

LatentColours::LatentColours(const at::Tensor& latents, const at::Tensor& pictures) {
  const at::Tensor from = with_ones(latents[0].flatten(1).t().to(at::kDouble));
  const at::Tensor to = pictures.flatten(1).t().to(at::kDouble);
  // A little of the identity keeps the map small where the clip shows too few colours to know it.
  const at::Tensor squares =
      from.t().mm(from) + 1e-3 * static_cast<double>(from.size(0)) * at::eye(from.size(1), from.options());
  map_ = at::linalg_solve(squares, from.t().mm(to)).to(at::kFloat);
}

ImageRgb LatentColours::picture(const at::Tensor& latents, std::int64_t frame, int scale) const {
  const at::Tensor one = latents[0].select(1, frame);
  const at::Tensor colours = with_ones(one.flatten(1).t()).mm(map_).contiguous();
  const auto width = static_cast<int>(one.size(2)), height = static_cast<int>(one.size(1));
  ImageRgb picture(width * scale, height * scale);
  const float* values = colours.data_ptr<float>();
  for (int y = 0; y < picture.height(); ++y)
    for (int x = 0; x < picture.width(); ++x) {
      const std::size_t at = 3 * (static_cast<std::size_t>(y / scale) * static_cast<std::size_t>(width) +
                                  static_cast<std::size_t>(x / scale));
      picture(x, y) = {level(values[at]), level(values[at + 1]), level(values[at + 2])};
    }
  return picture;
}

ImageRgb decoded_picture(const TinyVae& vae, const at::Tensor& latents, std::int64_t frame) {
  Monitor unheard;  // A preview is no stage of the work.
  const at::Tensor pixels =
      vae.decode(latents.narrow(2, frame, 1), unheard)[0].select(1, 0).permute({1, 2, 0}).contiguous();
  ImageRgb picture(static_cast<int>(pixels.size(1)), static_cast<int>(pixels.size(0)));
  const float* values = pixels.data_ptr<float>();
  for (std::size_t i = 0; i < picture.size().pixels(); ++i)
    picture.data()[i] = {level(values[3 * i]), level(values[3 * i + 1]), level(values[3 * i + 2])};
  return picture;
}

}  // namespace uwv::model
