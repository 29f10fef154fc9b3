// SPDX-License-Identifier: Apache-2.0
// Files and goldens for tests that work on torch's tensors.
#pragma once

#include <ATen/ATen.h>
#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "model/weights/weight_files.h"

namespace uwv::testing {

inline void write_text(const std::string& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

/// Writes a well-formed safetensors file.
inline void write_safetensors(const std::string& path, const std::map<std::string, at::Tensor>& tensors) {
  static const std::map<at::ScalarType, const char*> names{
      {at::kFloat, "F32"},  {at::kHalf, "F16"}, {at::kBFloat16, "BF16"}, {at::kFloat8_e4m3fn, "F8_E4M3"},
      {at::kDouble, "F64"}, {at::kLong, "I64"}, {at::kByte, "U8"},       {at::kFloat8_e5m2, "F8_E5M2"},
      {at::kChar, "I8"}};
  nlohmann::ordered_json header;
  std::string data;
  for (const auto& [name, tensor] : tensors) {
    const at::Tensor t = tensor.contiguous();
    header[name] = {{"dtype", names.at(t.scalar_type())},
                    {"shape", t.sizes().vec()},
                    {"data_offsets", {data.size(), data.size() + t.nbytes()}}};
    data.append(static_cast<const char*>(t.data_ptr()), t.nbytes());
  }
  std::string text = header.dump();
  while ((text.size() + 8) % 8 != 0) text += ' ';
  const std::uint64_t bytes = text.size();
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(&bytes), sizeof bytes);
  file << text << data;
}

/// Holds each value within `tolerance` (absolute) of the golden one; tells the worst place.
inline ::testing::AssertionResult near(const at::Tensor& ours, const at::Tensor& golden, double tolerance) {
  if (ours.sizes() != golden.sizes())
    return ::testing::AssertionFailure() << "shape " << ours.sizes() << " instead of " << golden.sizes();
  const at::Tensor difference = (ours.to(at::kDouble) - golden.to(at::kDouble)).abs().flatten();
  if (difference.numel() == 0) return ::testing::AssertionSuccess();
  // NaN counts as the largest difference.
  const auto at = difference.argmax().item<std::int64_t>();
  const double worst = difference[at].item<double>();
  if (worst <= tolerance) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << "value " << at << " of " << ours.sizes() << " is "
                                       << ours.flatten()[at].item<double>() << " instead of "
                                       << golden.flatten()[at].item<double>() << ", off by " << worst << " > "
                                       << tolerance;
}

}  // namespace uwv::testing
