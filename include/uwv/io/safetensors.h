// SPDX-License-Identifier: Apache-2.0
// Reads .safetensors files: named tensors, used for model weights and for the golden data of the parity tests.
//
// Layout of the file: 8 bytes little-endian header length N, N bytes of JSON {"name": {"dtype", "shape",
// "data_offsets": [begin, end]}, "__metadata__": {string: string}}, then the tensors' bytes, row-major, little-endian,
// in one gap-free run. Everything is checked when the file is opened, so that later reads cannot fail on its contents.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "uwv/io/dtype.h"

namespace uwv {

struct TensorInfo {
  DType dtype = DType::f32;
  std::vector<std::size_t> shape;  ///< Outermost dimension first; empty = a scalar.
  std::size_t values() const;      ///< Product of the shape; 1 for a scalar.
};

/// An open file. The bytes are mapped, not read: opening a 30 GB checkpoint costs its header only. Copies share the
/// mapping. The file must not be shortened while it is open.
class SafeTensors {
 public:
  /// Throws Error(file_not_found), or Error(file_damaged) naming the tensor and the rule it breaks.
  static SafeTensors open(const std::string& path);

  /// All tensors, sorted by name.
  std::vector<std::string> names() const;
  bool has(const std::string& name) const;
  const std::map<std::string, std::string>& metadata() const;

  // The functions below throw Error(value_invalid) naming the file when it holds no tensor of that name or when its
  // type does not fit.

  const TensorInfo& info(const std::string& name) const;
  /// All values, row-major; every type is converted (f64 and 64-bit integers are rounded).
  std::vector<float> as_float(const std::string& name) const;
  std::vector<double> as_double(const std::string& name) const;
  /// Types U8 and BOOL only.
  std::vector<std::uint8_t> as_u8(const std::string& name) const;
  /// Integer types and BOOL only.
  std::vector<std::int64_t> as_i64(const std::string& name) const;
  /// The stored bytes, valid while any copy of this object lives. No alignment is promised.
  std::span<const std::byte> bytes(const std::string& name) const;

 private:
  struct Contents;
  std::shared_ptr<const Contents> contents_;
};

}  // namespace uwv
