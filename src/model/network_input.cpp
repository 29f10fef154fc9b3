// SPDX-License-Identifier: Apache-2.0
#include "model/network_input.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "uwv/core/error.h"

namespace uwv::model {
namespace {

/// 8 GiB of floats in one call.
constexpr std::int64_t most_numbers = std::int64_t{1} << 31;

int rounded(double side, const InputRule& rule) {
  const double steps = side / rule.multiple_of;
  // A side that is a multiple but for rounding stays what it is.
  const double whole = rule.rounding == Rounding::nearest ? std::floor(steps + 0.5)
                       : rule.rounding == Rounding::down  ? std::floor(steps + 1e-9)
                                                          : std::ceil(steps - 1e-9);
  return static_cast<int>(std::clamp(whole, 1.0, 1e6)) * rule.multiple_of;
}

double scale_of(const InputRule& rule, Size frame) {
  const double longer = std::max(frame.width, frame.height), shorter = std::min(frame.width, frame.height);
  switch (rule.size_rule) {
    case SizeRule::longer_side: return rule.side / longer;
    case SizeRule::width: return static_cast<double>(rule.side) / frame.width;
    case SizeRule::area: return std::sqrt(rule.pixels / static_cast<double>(frame.pixels()));
    default: break;
  }
  double side = rule.side;
  if (rule.limit_aspect > 0 && longer / shorter > rule.limit_aspect)
    side = rounded(std::floor(side * rule.limit_aspect / (longer / shorter)), rule);
  return side / shorter;
}

int interpolation(InputFilter filter) {
  switch (filter) {
    case InputFilter::bilinear: return cv::INTER_LINEAR;
    case InputFilter::bicubic: return cv::INTER_CUBIC;
    case InputFilter::area: return cv::INTER_AREA;
    case InputFilter::lanczos: return cv::INTER_LANCZOS4;
  }
  return cv::INTER_LINEAR;
}

}  // namespace

Size network_size(const InputRule& rule, Size frame) {
  require(frame.width > 0 && frame.height > 0, "a frame of {}x{} has no pixels", frame.width, frame.height);
  if (rule.size_rule == SizeRule::fixed) return rule.size;
  const double scale = scale_of(rule, frame);
  const double width = rounded(frame.width * scale, rule), height = rounded(frame.height * scale, rule);
  if (width * height > static_cast<double>(1 << 28))
    fail(ErrorCode::value_invalid,
         "frames of {}x{} would enter the network as {}x{}, more than 2^28 pixels; lower 'input/side' in its manifest",
         frame.width, frame.height, width, height);
  return {static_cast<int>(width), static_cast<int>(height)};
}

FloatTensor prepared_frame(const InputRule& rule, const ImageRgb& frame) {
  const Size size = network_size(rule, frame.size());
  const cv::Mat bytes(frame.height(), frame.width(), CV_8UC3, const_cast<Rgb8*>(frame.data()));
  cv::Mat floats;
  bytes.convertTo(floats, CV_32FC3);
  if (size != frame.size())
    cv::resize(floats, floats, cv::Size(size.width, size.height), 0, 0, interpolation(rule.filter));
  FloatTensor tensor{{3, size.height, size.width}, std::vector<float>(3 * size.pixels())};
  for (std::size_t c = 0; c < 3; ++c) {
    const double scale = (rule.range[1] - rule.range[0]) / 255.0 / rule.std[c];
    const double offset = (rule.range[0] - rule.mean[c]) / rule.std[c];
    const std::size_t source = rule.bgr ? 2 - c : c;
    float* out = tensor.values.data() + c * size.pixels();
    for (int y = 0; y < size.height; ++y) {
      const float* in = floats.ptr<float>(y) + source;
      // Cubic filters overshoot; no picture has such values.
      for (int x = 0; x < size.width; ++x)
        *out++ = static_cast<float>(std::clamp(in[3 * x], 0.0F, 255.0F) * scale + offset);
    }
  }
  return tensor;
}

FloatTensor network_input(const InputRule& rule, std::span<const FloatTensor* const> frames) {
  require(!frames.empty() && (rule.takes_clips() || frames.size() == 1), "{} frames do not fit the layout {}",
          frames.size(), rule.layout);
  const std::int64_t count = static_cast<std::int64_t>(frames.size());
  const std::int64_t c_size = frames[0]->shape[0], h_size = frames[0]->shape[1], w_size = frames[0]->shape[2];
  FloatTensor input;
  std::int64_t c_stride = 0, h_stride = 0, w_stride = 0, stride = 1;
  for (auto letter = rule.layout.rbegin(); letter != rule.layout.rend(); ++letter) {
    const std::int64_t extent = *letter == 'C'   ? c_size
                                : *letter == 'H' ? h_size
                                : *letter == 'W' ? w_size
                                : *letter == 'T' ? count
                                                 : 1;
    if (*letter == 'C') c_stride = stride;
    if (*letter == 'H') h_stride = stride;
    if (*letter == 'W') w_stride = stride;
    stride *= extent;
    input.shape.insert(input.shape.begin(), extent);
  }
  if (stride > most_numbers)
    fail(
        ErrorCode::out_of_memory,
        "{} frames of {}x{} are too many for one call of the network; give fewer frames, or a 'window' in its manifest",
        count, w_size, h_size);
  input.values.resize(static_cast<std::size_t>(stride));
  float* out = input.values.data();
  for (const FloatTensor* frame : frames) {
    const float* in = frame->values.data();
    for (std::int64_t c = 0; c < c_size; ++c)
      for (std::int64_t y = 0; y < h_size; ++y)
        for (std::int64_t x = 0; x < w_size; ++x) out[c * c_stride + y * h_stride + x * w_stride] = *in++;
    out += c_size * h_size * w_size;
  }
  return input;
}

}  // namespace uwv::model
