// SPDX-License-Identifier: Apache-2.0
#include "model/network_output.h"

#include <algorithm>
#include <cmath>

#include "io/printable.h"
#include "uwv/core/error.h"

namespace uwv::model {
namespace {

constexpr std::int64_t largest_side = 1 << 16;

/// The product of the first `count` extents.
std::int64_t leading(const FloatTensor& tensor, std::size_t count) {
  std::int64_t product = 1;
  for (std::size_t i = 0; i < count; ++i) product *= tensor.shape[i];
  return product;
}

/// Where the two sides of a map are among the extents, if what stands before them makes up the frames.
bool sides_at(const FloatTensor& tensor, std::size_t first, std::int64_t before, Size& size) {
  const std::int64_t height = tensor.shape[first], width = tensor.shape[first + 1];
  if (leading(tensor, first) != before || height < 1 || width < 1 || height > largest_side || width > largest_side)
    return false;
  size = {static_cast<int>(width), static_cast<int>(height)};
  return true;
}

}  // namespace

NetworkOutput::NetworkOutput(const NetworkManifest& manifest, const std::string& model_path, ModuleOutputs outputs,
                             int frames)
    : manifest_(manifest), model_path_(model_path), outputs_(std::move(outputs)), frames_(frames) {}

const FloatTensor& NetworkOutput::tensor(std::string_view role) const {
  const OutputPlace& place = manifest_.outputs.find(role)->second;
  const std::size_t found = outputs_.tensors.size();
  if (place.key.empty()) {
    if (!outputs_.names.empty())
      fail(ErrorCode::value_invalid, "{}: returns a dictionary with {}; 'outputs/{}' in {} must be one of these keys",
           model_path_, io::printable(fmt::format("{}", fmt::join(outputs_.names, ", "))), role, manifest_.path);
    if (static_cast<std::size_t>(place.number) >= found)
      fail(ErrorCode::value_invalid, "{}: returns {} outputs; 'outputs/{}' in {} asks for number {} (counted from 0)",
           model_path_, found, role, manifest_.path, place.number);
    return outputs_.tensors[static_cast<std::size_t>(place.number)];
  }
  const auto name = std::find(outputs_.names.begin(), outputs_.names.end(), place.key);
  if (name == outputs_.names.end())
    fail(ErrorCode::value_invalid, "{}: returns {}, nothing named '{}'; change 'outputs/{}' in {}", model_path_,
         outputs_.names.empty() ? fmt::format("{} outputs by number", found)
                                : io::printable(fmt::format("{}", fmt::join(outputs_.names, ", "))),
         io::printable(place.key), role, manifest_.path);
  return outputs_.tensors[static_cast<std::size_t>(name - outputs_.names.begin())];
}

void NetworkOutput::refuse(std::string_view role, const FloatTensor& found, std::string_view wanted) const {
  fail(ErrorCode::value_invalid,
       "{}: what 'outputs/{}' in {} points at has the shape {}; for {} frame{} {} is wanted; is it another output?",
       model_path_, role, manifest_.path, shape_text(found.shape), frames_, frames_ == 1 ? "" : "s", wanted);
}

std::vector<FloatMap> NetworkOutput::maps(std::string_view role) const {
  const FloatTensor& found = tensor(role);
  const std::size_t rank = found.shape.size();
  Size size;
  const bool fits = (rank >= 2 && sides_at(found, rank - 2, frames_, size)) ||
                    (rank >= 3 && found.shape.back() == 1 && sides_at(found, rank - 3, frames_, size));
  if (!fits) refuse(role, found, "one channel, [.., height, width],");
  std::vector<FloatMap> maps(static_cast<std::size_t>(frames_), FloatMap(size));
  const float* in = found.values.data();
  for (FloatMap& map : maps) {
    std::copy(in, in + size.pixels(), map.data());
    in += size.pixels();
  }
  return maps;
}

std::vector<VectorMap> NetworkOutput::vectors(std::string_view role) const {
  const FloatTensor& found = tensor(role);
  const std::size_t rank = found.shape.size();
  Size size;
  const bool last = rank >= 3 && found.shape[rank - 1] == 3 && sides_at(found, rank - 3, frames_, size);
  const bool planes = !last && rank >= 3 && found.shape[rank - 3] == 3 && sides_at(found, rank - 2, 3L * frames_, size);
  if (!last && !planes) refuse(role, found, "three channels, [.., height, width, 3] or [.., 3, height, width],");
  const std::size_t pixels = size.pixels(), of_pixel = last ? 3 : 1, of_channel = last ? 1 : pixels;
  std::vector<VectorMap> maps(static_cast<std::size_t>(frames_), VectorMap(size));
  const float* in = found.values.data();
  for (VectorMap& map : maps) {
    for (std::size_t i = 0; i < pixels; ++i) {
      const float* first = in + i * of_pixel;
      map.data()[i] = {first[0], first[of_channel], first[2 * of_channel]};
    }
    in += 3 * pixels;
  }
  return maps;
}

std::vector<std::vector<double>> NetworkOutput::numbers(std::string_view role, std::size_t count) const {
  const FloatTensor& found = tensor(role);
  if (found.values.size() != count * static_cast<std::size_t>(frames_))
    refuse(role, found, fmt::format("{} number{}", count, count == 1 ? "" : "s"));
  std::vector<std::vector<double>> frames;
  for (auto in = found.values.begin(); in != found.values.end(); in += static_cast<std::ptrdiff_t>(count)) {
    frames.emplace_back(in, in + static_cast<std::ptrdiff_t>(count));
    for (const double value : frames.back())
      if (!std::isfinite(value))
        fail(ErrorCode::value_invalid, "{}: 'outputs/{}' holds {} for frame {} of {}; every number must be finite",
             model_path_, role, value, frames.size() - 1, frames_);
  }
  return frames;
}

}  // namespace uwv::model
